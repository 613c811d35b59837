"""The innermost loops are vector code of full width, and nothing is contracted to a fused multiply–add."""

import os
import platform
import re
from collections.abc import Callable, Iterator
from typing import Any

import llvmlite.binding as llvm
import numpy as np
import pytest
from numba import typeof

from overturning.dem.block.rules import SCHEMES
from overturning.dem.block.state import COLUMNS, ROWS, TICKS
from overturning.dem.body import centred_loops as space_centred
from overturning.dem.body import state as space
from overturning.dem.kernel.lanes import aligned
from overturning.dem.polygon import centred, cundall, equations, rows
from overturning.dem.polygon.step import arrive, predict
from overturning.dem.polygon.verdict import note_standing

Compile = Callable[[], Iterator[str]]
"""Compiles a kernel's loops and gives the assembly of each."""


def block_loops(scheme: Any, vertical: bool, with_friction: bool) -> Compile:
    def assemblies() -> Iterator[str]:
        advance = SCHEMES[scheme][1](vertical, with_friction)
        advance(None, aligned(ROWS.size), COLUMNS, 1, float(TICKS))
        inner = [cell.cell_contents for cell in advance.py_func.__closure__]
        named = [part for part in inner if getattr(part, "__name__", "").endswith("_all")]
        for loop in named or [advance]:
            yield from loop.inspect_asm().values()

    return assemblies


def compiled(loop: Any, *arguments: Any) -> Compile:
    def assemblies() -> Iterator[str]:
        loop.compile(tuple(typeof(value) for value in arguments))
        yield from loop.inspect_asm().values()

    return assemblies


UP = np.zeros(8)
BODY, POINT = np.zeros(space.ROWS.size), np.zeros(space.VERTEX.size)
PAIR, ELEMENT, OWN, BLOCK = (
    np.zeros(table.size) for table in (rows.PAIR, rows.ELEMENT, rows.CASE, equations.SUBMATRIX)
)
LOOPS: dict[str, Compile] = {
    f"block, {scheme.name.lower()}, vertical {vertical}, with friction {with_friction}": block_loops(
        scheme, vertical, with_friction
    )
    for scheme in SCHEMES
    for vertical in (False, True)
    for with_friction in (True, False)
} | {
    "polygons, couple": compiled(centred.couple, PAIR, ELEMENT, ELEMENT.copy(), OWN),
    "polygons, correct": compiled(centred.correct, PAIR, ELEMENT, ELEMENT.copy(), OWN),
    "polygons, invert": compiled(equations.invert, BLOCK),
    "polygons, divide": compiled(equations.divide, BLOCK, BLOCK.copy()),
    "polygons, eliminate": compiled(equations.eliminate, BLOCK, BLOCK.copy(), BLOCK.copy()),
    "polygons, carry": compiled(equations.carry, ELEMENT, BLOCK, ELEMENT.copy()),
    "polygons, predict, vertical": compiled(predict, UP, ELEMENT, OWN, 128.0, 9.80665),
    "polygons, predict, level": compiled(predict, None, ELEMENT, OWN, 128.0, 9.80665),
    "polygons, arrive, vertical": compiled(arrive, UP, ELEMENT, OWN, 128.0, 9.80665),
    "polygons, arrive, level": compiled(arrive, None, ELEMENT, OWN, 128.0, 9.80665),
    "polygons, cundall contact": compiled(cundall.contact, PAIR, ELEMENT, ELEMENT.copy(), OWN),
    "polygons, motion, vertical": compiled(cundall.advance, UP, ELEMENT, OWN, 9.80665),
    "polygons, motion, level": compiled(cundall.advance, None, ELEMENT, OWN, 9.80665),
    "polygons, slip": compiled(note_standing, ELEMENT, ELEMENT.copy(), OWN, 0.1, 0.01),
} | {
    f"space, {name}, {loop}": compiled(getattr(scheme, loop), BODY, *more)
    for name, scheme, loop, more in (
        ("centred", space_centred, "predict_all", (space.COLUMNS, 128.0)),
        ("centred", space_centred, "predict_vertices", (POINT, POINT.copy(), space.COLUMNS)),
        ("centred", space_centred, "contribute_all", (POINT, POINT.copy(), space.COLUMNS)),
        ("centred", space_centred, "solve_all", (space.COLUMNS,)),
        ("centred", space_centred, "correct_all", (POINT, POINT.copy(), space.COLUMNS, False)),
        ("centred", space_centred, "commit_all", (space.COLUMNS, 128.0, False)),
    )
}  # fmt: skip


def operations() -> tuple[str, str]:
    """Patterns of packed double arithmetic at full width and of scalar double arithmetic."""
    kind = platform.machine().lower()
    if kind in ("x86_64", "amd64"):
        has = llvm.get_host_cpu_features()
        register = "zmm" if has.get("avx512f") else "ymm" if has.get("avx2") else "xmm"
        return rf"\bv?(?:add|sub|mul|div)pd\b[^\n]*%{register}", r"\bv?(?:add|sub|mul|div)sd\b"
    if kind in ("aarch64", "arm64"):
        return r"\bf(?:add|sub|mul|div)(?:\.2d)?\s+v[^\n]*", r"\bf(?:add|sub|mul|div)\s+d\d"
    if os.environ.get("OVERTURNING_NO_SKIP"):
        pytest.fail(f"{kind}: say what vector code looks like here")
    pytest.skip(f"{kind}: not known what vector code looks like there")


FUSED = re.compile(r"\bv?f[n]?m(?:add|sub|addsub|subadd)\w*|\bfml[as]\b|\bfn?madd\b")


# A compile each: those that differ by the vertical component or the lack of friction are left to `make verify`.
CHOSEN = [name for name in LOOPS if "OVERTURNING_EVERY_TARGET" in os.environ or not re.search("vertical|smooth", name)]


@pytest.mark.parametrize("name", CHOSEN)
def test_each_loop_is_vector_code_of_full_width_without_fused_multiply_add(name: str) -> None:
    packed, scalar = operations()
    for assembly in LOOPS[name]():
        assert not FUSED.search(assembly)
        wide, single = len(re.findall(packed, assembly)), len(re.findall(scalar, assembly))
        # What is left over of the columns is done in scalar code: each operation stands there once in either form.
        assert wide >= 20, name
        assert wide >= 0.9 * single, f"{wide} packed operations beside {single} scalar ones"


def test_a_fused_multiply_add_would_be_seen() -> None:
    for text in (
        "vfmadd213pd %zmm0",
        "vfnmadd231sd",
        "vfmsub132pd",
        "vfnmsub213sd",
        "fmla v0.2d",
        "fmadd d0",
        "vfmaddsub213pd",
    ):
        assert FUSED.search(f"\t{text}, x")
    assert not FUSED.search("vmulpd %zmm0, %zmm1\n vaddpd")
