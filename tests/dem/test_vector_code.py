"""Innermost loops are vectorised at full width, without fused multiply–add instructions."""

import platform
import re
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numba
import numpy as np
import pytest
from numba import typeof

from overturning.dem.kernel.queue import run_case_queue
from overturning.dem.plan import SimulationPlan
from overturning.dem.polygon import cundall, rows, submatrices
from overturning.dem.polygon.centred import add_pair_contact_terms_to_equations
from overturning.dem.polygon.centred_solution import (
    add_solved_pair_forces_and_store_trial_history,
    store_accepted_pair_history,
)
from overturning.dem.polygon.equations import PairSubmatrices
from overturning.dem.polygon.slip import store_slip_and_last_time_rotation_recoverable
from overturning.dem.polygon.step import predict_element_motion, store_element_state_of_accepted_step
from overturning.dem.run import run_cases, simulate_cases
from overturning.model.cases import Cases
from overturning.model.shapes import RectangularPrism
from overturning.model.stack import Stack
from overturning.motion.motion import Motion
from tests.expect import skip_test_unless_skipping_is_forbidden

pytestmark = pytest.mark.long

LoopAssemblyGenerator = Callable[[], Iterator[str]]
"""Function that compiles a loop and yields the assembly of each of its variants."""


def create_function_yielding_loop_assembly(loop: Any, *arguments: Any) -> LoopAssemblyGenerator:
    """Return a function that compiles a loop for the types of its arguments and yields its assembly code."""

    def compile_loop_and_yield_assembly_of_versions() -> Iterator[str]:
        """Compile the loop and yield the assembly code of each version."""
        loop.compile(tuple(typeof(value) for value in arguments))
        yield from loop.inspect_asm().values()

    return compile_loop_and_yield_assembly_of_versions


UPWARD_ACCELERATION = np.zeros(8)
PAIR, ELEMENT, CASE, BLOCK = (
    np.zeros(table.array_length)
    for table in (rows.PAIR_ROW_LAYOUT, rows.ELEMENT_ROW_LAYOUT, rows.CASE_ROW_LAYOUT, submatrices.SUBMATRIX_ROW_LAYOUT)
)
ASSEMBLY_GENERATORS_BY_LOOP: dict[str, LoopAssemblyGenerator] = {
    "couple": create_function_yielding_loop_assembly(
        add_pair_contact_terms_to_equations,
        PAIR,
        ELEMENT,
        ELEMENT.copy(),
        CASE,
        PairSubmatrices(*(BLOCK.copy() for _ in range(4))),
        (True, True, True),
    ),
    "correct": create_function_yielding_loop_assembly(
        add_solved_pair_forces_and_store_trial_history, PAIR, ELEMENT, ELEMENT.copy(), CASE
    ),
    "keep": create_function_yielding_loop_assembly(store_accepted_pair_history, PAIR, CASE),
    "invert": create_function_yielding_loop_assembly(submatrices.invert_submatrix_in_place, BLOCK),
    "divide": create_function_yielding_loop_assembly(
        submatrices.right_multiply_submatrix_by_pivot_inverse, BLOCK, BLOCK.copy()
    ),
    "eliminate": create_function_yielding_loop_assembly(
        submatrices.subtract_submatrix_product, BLOCK, BLOCK.copy(), BLOCK.copy(), False
    ),
    "subtract product": create_function_yielding_loop_assembly(
        submatrices.subtract_coupled_velocity_change, ELEMENT, BLOCK, ELEMENT.copy()
    ),
    "predict, vertical": create_function_yielding_loop_assembly(
        predict_element_motion, UPWARD_ACCELERATION, ELEMENT, CASE, 128.0, 9.80665
    ),
    "predict, level": create_function_yielding_loop_assembly(
        predict_element_motion, None, ELEMENT, CASE, 128.0, 9.80665
    ),
    "correct state, vertical": create_function_yielding_loop_assembly(
        store_element_state_of_accepted_step, UPWARD_ACCELERATION, ELEMENT, CASE, 128.0, 9.80665
    ),
    "correct state, level": create_function_yielding_loop_assembly(
        store_element_state_of_accepted_step, None, ELEMENT, CASE, 128.0, 9.80665
    ),
    "cundall contact": create_function_yielding_loop_assembly(
        cundall.add_pair_forces_and_store_contact_history, PAIR, ELEMENT, ELEMENT.copy(), CASE
    ),
    "motion, vertical": create_function_yielding_loop_assembly(
        cundall.advance_element_motion_one_step, UPWARD_ACCELERATION, ELEMENT, CASE, 9.80665
    ),
    "motion, level": create_function_yielding_loop_assembly(
        cundall.advance_element_motion_one_step, None, ELEMENT, CASE, 9.80665
    ),
    "slip": create_function_yielding_loop_assembly(
        store_slip_and_last_time_rotation_recoverable, ELEMENT, ELEMENT.copy(), CASE, 0.1, 0.01
    ),
}
"""Loops of the scene kernel; they have as many lanes as the widest vector has numbers."""


@cache
def name_of_widest_vector_register() -> str:
    """Return the name of the widest vector registers that LLVM uses on this processor, such as zmm (512 bits)."""

    def add_term_to_total(total: np.ndarray, term: np.ndarray) -> None:
        """Add arrays in a loop that LLVM can vectorise."""
        for i in range(total.size):
            total[i] += term[i]

    loop = numba.njit(add_term_to_total)
    loop.compile((typeof(UPWARD_ACCELERATION), typeof(UPWARD_ACCELERATION)))
    (assembly,) = loop.inspect_asm().values()
    return next(name for name in ("zmm", "ymm", "xmm") if re.search(rf"\bv?addpd\b[^\n]*%{name}", assembly))


def regexes_of_packed_and_scalar_arithmetic() -> tuple[str, str]:
    """Return regular expressions for packed double arithmetic at full width, and for scalar double arithmetic."""
    kind = platform.machine().lower()
    if kind in ("x86_64", "amd64"):
        register = name_of_widest_vector_register()
        return rf"\bv?(?:add|sub|mul|div)pd\b[^\n]*%{register}", r"\bv?(?:add|sub|mul|div)sd\b"
    if kind not in ("aarch64", "arm64"):
        skip_test_unless_skipping_is_forbidden(f"{kind}: no patterns of vector code for this processor")
    return r"\bf(?:add|sub|mul|div)(?:\.2d)?\s+v[^\n]*", r"\bf(?:add|sub|mul|div)\s+d\d"


MASKED_STORE_REGEX = re.compile(
    r"\bvmaskmovpd\s+%[xy]mm\d+, %[xy]mm\d+, \S*\(|\bvmov[au]pd\s+%[xyz]mm\d+, \S*\([^\n]*\{%k"
)
"""Conditional (masked) stores, which take ten cycles each on some processors."""

FUSED_MULTIPLY_ADD = re.compile(r"\bv?f[n]?m(?:add|sub|addsub|subadd)\w*|\bfml[as]\b|\bfn?madd\b")


@pytest.mark.parametrize("name", ASSEMBLY_GENERATORS_BY_LOOP)
def test_small_loops_are_fully_vectorised_without_fused_multiply_add(name: str) -> None:
    packed, scalar = regexes_of_packed_and_scalar_arithmetic()
    for assembly in ASSEMBLY_GENERATORS_BY_LOOP[name]():
        assert not FUSED_MULTIPLY_ADD.search(assembly)
        wide, single = len(re.findall(packed, assembly)), len(re.findall(scalar, assembly))
        assert not MASKED_STORE_REGEX.search(assembly)
        # Left-over columns are processed in scalar code, so each operation occurs once in both forms.
        assert wide >= 15 or name == "keep", name
        assert wide >= 0.9 * single, f"{wide} packed operations and {single} scalar ones"


ACCELERATION = 4.0 * np.sin(0.1 * np.arange(50))
KERNEL_CALLS_AND_LARGE_LOOP_COUNTS: dict[str, tuple[Callable[..., Any], int]] = {
    "block, centred": (lambda motion, mu: run_cases(motion, Cases(0.0, 0.6, 0.3, mu)), 3),
    "block, cundall": (lambda motion, mu: run_cases(motion, Cases(0.0, 0.6, 0.3, mu), scheme="cundall"), 1),
    "body": (lambda motion, _: simulate_cases(RectangularPrism(), motion, Cases(0.0, 0.6, 0.3, 1.0)), 6),
    "stack": (lambda motion, _: simulate_cases(Stack(), motion, Cases(0.0, 0.6, 0.3, 1.0)), 10),
}
"""Function that makes a kernel compile or load, and its number of large loops over the lanes."""


def short_motion(vertical: bool) -> Motion:
    """Return a motion of 50 samples, with or without a vertical component."""
    return Motion(ACCELERATION, ACCELERATION, ACCELERATION if vertical else None, sampling_interval=0.01)


def numba_library_of_kernel_in_call(compute: Callable[[], Any], monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return Numba's library of compiled code of the kernel that `compute` runs."""
    called = []

    def store_argument_types_and_run_kernel(*arguments: Any) -> Any:
        """Record the types of the arguments and run the kernel."""
        called.append(tuple(map(typeof, arguments)))
        return run_case_queue(*arguments)

    monkeypatch.setattr(SimulationPlan, "run_case_queue_function", staticmethod(store_argument_types_and_run_kernel))
    compute()
    return run_case_queue.overloads[called[0]].library


@pytest.mark.parametrize("name", ["body", "stack"])
def test_loops_of_a_kernel_get_no_arguments_that_they_do_not_use(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Functions of two to five arrays get only the address of each, not all seven numbers that Numba passes."""
    compute, _ = KERNEL_CALLS_AND_LARGE_LOOP_COUNTS[name]
    module = str(
        numba_library_of_kernel_in_call(
            lambda: compute(short_motion(False), 1.0), monkeypatch
        )._get_module_for_linking()
    )
    names = r"(?:point_pair|vertex_pair|opposite_(?:rim_)?points|patch_forces)"
    found = re.findall(rf"^define private [^@]*@[^(]*{names}[^(]*\((.*)\)", module, re.MULTILINE)
    counts = [len(re.findall(r" %", arguments)) for arguments in found]
    assert len(counts) >= 4
    assert max(counts) <= 14, counts


def test_loops_of_the_body_kernel_have_no_scalar_copy_for_overlapping_arrays(monkeypatch: pytest.MonkeyPatch) -> None:
    """With such a copy, LLVM would compile each loop twice and test in every call if its arrays overlap."""
    compute, _ = KERNEL_CALLS_AND_LARGE_LOOP_COUNTS["body"]
    library = numba_library_of_kernel_in_call(lambda: compute(short_motion(False), 1.0), monkeypatch)
    assembly = library._codegen._tm.emit_assembly(library._get_module_for_linking())
    packed, scalar = regexes_of_packed_and_scalar_arithmetic()
    loops = re.findall(
        r"^\S*(?:point_pair|vertex_pair|opposite_(?:rim_)?points)\S*:(.*?)^\.Lfunc_end",
        assembly,
        re.MULTILINE | re.DOTALL,
    )
    counts = [(len(re.findall(packed, text)), len(re.findall(scalar, text))) for text in loops]
    assert sum(wide > 100 for wide, _ in counts) >= 5
    assert max(single for _, single in counts) < 10, counts


@pytest.mark.parametrize(
    ("name", "vertical", "friction"),
    [
        (name, up, mu)
        for name in KERNEL_CALLS_AND_LARGE_LOOP_COUNTS
        for up in (False, True)
        for mu in (0.7, 0.0)[: 1 + ("block" in name)]
    ],
)
def test_the_large_loops_of_a_kernel_are_vectorised(
    name: str, vertical: bool, friction: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the code that the tests run, each large loop (a block that jumps to its own start) is vectorised.

    A loop over a variable number of lanes may have a scalar copy for the lanes that do not fill a vector.
    """
    compute, large = KERNEL_CALLS_AND_LARGE_LOOP_COUNTS[name]
    library = numba_library_of_kernel_in_call(lambda: compute(short_motion(vertical), friction), monkeypatch)
    packed, scalar = regexes_of_packed_and_scalar_arithmetic()
    # A loaded library holds machine code and, for linking, the LLVM module from which the assembly is made.
    assembly = library._codegen._tm.emit_assembly(library._get_module_for_linking())
    assert not FUSED_MULTIPLY_ADD.search(assembly)
    found = []
    for label, text in re.findall(r"^([.\w$]+):(.*?)(?=^[.\w$]+:|\Z)", assembly, re.MULTILINE | re.DOTALL):
        if re.search(rf"{re.escape(label)}\b", text):
            found.append(
                (len(re.findall(packed, text)), len(re.findall(scalar, text)), len(MASKED_STORE_REGEX.findall(text)))
            )
    assert sum(wide >= 50 for wide, _, _ in found) >= large
    assert {single for _, single, _ in found if single >= 60} <= {wide for wide, _, _ in found}
    assert max(masked for wide, _, masked in found if wide >= 50) <= 1


def test_fused_multiply_add_instructions_are_detected_in_assembly_code() -> None:
    for text in (
        "vfmadd213pd %zmm0",
        "vfnmadd231sd",
        "vfmsub132pd",
        "vfnmsub213sd",
        "fmla v0.2d",
        "fmadd d0",
        "vfmaddsub213pd",
    ):
        assert FUSED_MULTIPLY_ADD.search(f"\t{text}, x")
    assert not FUSED_MULTIPLY_ADD.search("vmulpd %zmm0, %zmm1\n vaddpd")
