"""Compile options of all kernels, and storage of named tuples in an array with one lane (column) per case.

A kernel keeps its cases in one flat float64 array with a row per quantity and a lane per case: quantity ``Q`` of lane
``j`` is ``array[Q + j]``. The equations are written for one case, as functions of named tuples; a loop over the lanes
loads the tuples, calls the functions and stores the results. LLVM vectorises such a loop at full width if

- every function that it calls is compiled with `INLINE_OPTIONS`;
- there is no branch on a case's numbers: use ``a if c else b`` instead, and `select` if one of the two values is the
  one already stored;
- the arrays are aligned (`cache_line_aligned_zeros`): vectors that straddle two cache lines are a fifth slower.

Three other forms are not vectorised, or are slow: a named tuple *of arrays* (each array has its own base address and
may overlap the others); a choice between two whole tuples before they are stored, or between numbers within a tuple's
own arguments; and a conditional (masked) store. `TupleReaderAndWriter.store_unless` selects number by number instead.
"""

import hashlib
from collections.abc import Collection
from functools import cache
from typing import Any, Final, NamedTuple, get_type_hints

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from overturning.dem.kernel.compiler import (
    InternalFunctionCompiler,
    NoAliasFunctionCompiler,
    PythonCallableKernelCompiler,
)
from overturning.dem.kernel.tuples import (
    create_elementwise_function,
    create_tuple_loader,
    create_tuple_storer,
    create_tuple_storer_skipping_flagged_lanes,
    create_zero_tuple_function,
    field_paths_of_numbers,
    select_llvm_value_without_branch,
)

COMPILE_OPTIONS: Final[dict[str, Any]] = {
    "fastmath": False,
    "error_model": "numpy",
    "boundscheck": False,
    "pipeline_class": PythonCallableKernelCompiler,
}
"""Options of every compiled function: no fast-math and no contraction, so that results are bit-equal everywhere."""

PYTHON_CALLABLE_COMPILE_OPTIONS: Final[dict[str, Any]] = {**COMPILE_OPTIONS, "nogil": True, "no_cfunc_wrapper": True}
"""Options of the functions that Python calls; without a C wrapper."""

ALLOCATING_INLINE_OPTIONS: Final[dict[str, Any]] = {
    **COMPILE_OPTIONS,
    "pipeline_class": InternalFunctionCompiler,
    "no_cfunc_wrapper": True,
    "forceinline": True,
}
"""Options of inlined functions that may allocate arrays; without a C wrapper."""

INTERNAL_COMPILE_OPTIONS: Final[dict[str, Any]] = {
    **COMPILE_OPTIONS,
    "pipeline_class": InternalFunctionCompiler,
    "no_cfunc_wrapper": True,
    "_nrt": False,
    "forceinline": False,
}
"""Options of functions that only compiled code calls: they allocate no arrays, and take those of
`view_without_reference_counts`.

Without reference counts (``_nrt``). `forceinline` is set explicitly: unset, Numba inherits it from the caller, the
whole kernel becomes one function, and compilation takes twice as long.
"""

NO_ALIAS_COMPILE_OPTIONS: Final[dict[str, Any]] = {
    **INTERNAL_COMPILE_OPTIONS,
    "pipeline_class": NoAliasFunctionCompiler,
}
"""Options of loops over the lanes whose array arguments never overlap, so that LLVM omits its overlap tests.

With `INTERNAL_COMPILE_OPTIONS`, LLVM compiles each such loop twice and tests for overlap in every call.
"""

INLINE_OPTIONS: Final[dict[str, Any]] = {**INTERNAL_COMPILE_OPTIONS, "forceinline": True}
"""Options of functions called within a loop over the lanes."""

_FLOATS_PER_CACHE_LINE: Final = 8
"""Number of float64 values in a cache line, and in the widest vector."""


@njit(**ALLOCATING_INLINE_OPTIONS)
def cache_line_aligned_zeros(length: int) -> Any:
    """Return a float64 array of zeros aligned to a cache line of 64 bytes; Numba aligns its arrays to 32 bytes."""
    numbers = np.zeros(length + _FLOATS_PER_CACHE_LINE)
    skip = -(numbers.ctypes.data // 8) % _FLOATS_PER_CACHE_LINE
    return numbers[skip : skip + length]


def _signature_and_generator_of_uncounted_array_view(
    _typing_context: Any, type_of_array_or_tuple_of_arrays: Any
) -> Any:
    """Return Numba signature and code generator of a view of one or more arrays that counts no references to them.

    Reference counts of slices took a fifth of the time. The caller must keep the arrays alive.
    """

    def remove_array_owners_from_llvm_value(context: Any, builder: Any, numba_type: Any, llvm_value: Any) -> Any:
        """Return the value with the owner of each array removed, so that references are not counted."""
        if isinstance(numba_type, types.Array):
            view = context.make_array(numba_type)(context, builder, value=llvm_value)
            view.meminfo, view.parent = view.meminfo.type(None), view.parent.type(None)
            return view._getvalue()
        inners: Any = numba_type if isinstance(numba_type, types.BaseTuple) else ()
        for number, inner in enumerate(inners):
            one = remove_array_owners_from_llvm_value(
                context, builder, inner, builder.extract_value(llvm_value, number)
            )
            llvm_value = builder.insert_value(llvm_value, one, number)
        return llvm_value

    def generate_view_code(context: Any, builder: Any, signature: Any, llvm_arguments: Any) -> Any:
        """Generate the LLVM code that returns the view of the argument."""
        return remove_array_owners_from_llvm_value(context, builder, signature.args[0], llvm_arguments[0])

    return type_of_array_or_tuple_of_arrays(type_of_array_or_tuple_of_arrays), generate_view_code


view_without_reference_counts: Final[Any] = intrinsic(_signature_and_generator_of_uncounted_array_view)


def create_window_slicer(window_length: int, first_window_array_index: int = 0, stride: int | None = None) -> Any:
    """Return a compiled function ``window(array, k)`` that returns the k-th slice of fixed length of an array.

    A slice has `window_length` values from ``first_window_array_index + k * stride`` on; `stride` defaults to
    `window_length`. The array is flat, and references to it are not counted. Unlike an ordinary slice it has no bounds
    checks, which take long to compile.
    """

    def signature_and_generator_for_slice(
        _typing_context: Any,
        array_type: Any,
        window_index_type: Any,  # noqa: ARG001
    ) -> Any:
        """Return the Numba signature of the slicing and the function that generates its LLVM code."""

        def generate_slice_code(context: Any, builder: Any, signature: Any, llvm_arguments: Any) -> Any:
            """Generate the LLVM code that returns the slice as an array."""
            length, begin, apart = (
                context.get_constant(types.intp, n)
                for n in (window_length, first_window_array_index, stride or window_length)
            )
            view = context.make_array(signature.args[0])(context, builder, value=llvm_arguments[0])
            view.data = builder.gep(view.data, [builder.add(builder.mul(llvm_arguments[1], apart), begin)])
            view.nitems, view.shape = length, cgutils.pack_array(builder, [length])
            return view._getvalue()

        return array_type(array_type, types.intp), generate_slice_code

    return intrinsic(signature_and_generator_for_slice)


def _signature_and_generator_for_selection(
    _typing_context: Any, condition_type: Any, type_of_value_if_true: Any, type_of_value_if_false: Any
) -> Any:
    """Return Numba signature and code generator of a selection of one of two values, by a condition, without branch."""

    def generate_selection_code(_: Any, builder: Any, __: Any, llvm_arguments: Any) -> Any:
        """Generate the LLVM code that selects one of the two values."""
        return select_llvm_value_without_branch(builder, *llvm_arguments)

    return type_of_value_if_false(
        condition_type, type_of_value_if_true, type_of_value_if_false
    ), generate_selection_code


select: Final[Any] = intrinsic(_signature_and_generator_for_selection)


def _signature_and_generator_for_rounding_lanes_down(_typing_context: Any, lane_count_type: Any) -> Any:
    """Return Numba signature and code generator for rounding a number of lanes down to a multiple of 8, at least 8."""

    def generate_code_rounding_down_to_cache_lines(_: Any, builder: Any, __: Any, llvm_arguments: Any) -> Any:
        """Generate the LLVM code that rounds the number down to whole cache lines, at least to one."""
        multiple = builder.and_(llvm_arguments[0], ir.Constant(llvm_arguments[0].type, -_FLOATS_PER_CACHE_LINE))
        least = ir.Constant(llvm_arguments[0].type, _FLOATS_PER_CACHE_LINE)
        return builder.select(builder.icmp_signed(">", multiple, least), multiple, least)

    return types.intp(lane_count_type), generate_code_rounding_down_to_cache_lines


assume_lane_count_is_multiple_of_8: Final[Any] = intrinsic(_signature_and_generator_for_rounding_lanes_down)
"""``assume_lane_count_is_multiple_of_8(n)`` returns n, a positive multiple of 8.

LLVM then omits the loop for the lanes that vectors leave; otherwise each loop is compiled twice. Kernels compute all
lanes up to the next multiple of 8."""


def _signature_and_generator_for_hiding_number(_typing_context: Any, number_type: Any) -> Any:
    """Return Numba signature and code generator for hiding a number from LLVM, which then unrolls no loop over it."""

    def generate_code_to_hide_number_from_llvm(_: Any, builder: Any, __: Any, llvm_arguments: Any) -> Any:
        """Generate empty assembler code that returns the number."""
        kind = ir.FunctionType(llvm_arguments[0].type, [llvm_arguments[0].type])
        return builder.asm(kind, "", "=r,0", [llvm_arguments[0]], side_effect=False)

    return number_type(number_type), generate_code_to_hide_number_from_llvm


hide_number_from_llvm: Final[Any] = intrinsic(_signature_and_generator_for_hiding_number)
"""``hide_number_from_llvm(n)`` returns n, hidden from LLVM: a short loop of n passes is vectorised, not unrolled."""


class TupleReaderAndWriter(NamedTuple):
    """Compiled functions that read a named tuple from a column (lane) of the state array, and write it there."""

    load: Any
    """``load(array, j)`` returns the tuple of lane j."""
    store: Any
    """``store(array, j, value)`` writes a tuple to lane j."""
    store_unless: Any
    """``store_unless(array, j, keep, value)`` writes a tuple to lane j unless `keep` is true."""


class ElementwiseTupleFunctions(NamedTuple):
    """Compiled functions that add, subtract or compare two named tuples of one type, element by element."""

    zero: Any
    """``zero()`` returns a tuple of zeros."""
    plus: Any
    """``plus(a, b)`` returns the elementwise sum."""
    minus: Any
    """``minus(a, b)`` returns the elementwise difference."""
    largest: Any
    """``largest(a, b)`` returns the elementwise maximum."""


@cache
def create_tuple_sum_difference_and_maximum_functions(tuple_type: type) -> ElementwiseTupleFunctions:
    """Return compiled functions for the elementwise sum, difference and maximum of two named tuples of a type."""
    name = f"{tuple_type.__module__}.{tuple_type.__qualname__}"

    def llvm_code_for_larger_number(builder: Any, first_llvm_number: Any, second_llvm_number: Any) -> Any:
        """Return LLVM code for the larger of two numbers; the second one if either is NaN."""
        return select_llvm_value_without_branch(
            builder,
            builder.fcmp_ordered(">", first_llvm_number, second_llvm_number),
            first_llvm_number,
            second_llvm_number,
        )

    return ElementwiseTupleFunctions(
        create_zero_tuple_function(tuple_type),
        create_elementwise_function(tuple_type, f"plus.{name}", lambda builder, x, y: builder.fadd(x, y)),
        create_elementwise_function(tuple_type, f"minus.{name}", lambda builder, x, y: builder.fsub(x, y)),
        create_elementwise_function(tuple_type, f"largest.{name}", llvm_code_for_larger_number),
    )


class TupleRowLayout:
    """Layout of named tuples in an array with a column (lane) per case: the row of each number of a tuple.

    Parameters
    ----------
    lane_count : int
        Number of values in a row: one for each lane.
    *tuple_types : type
        Named tuples of numbers or of further such tuples; rows are assigned in the order of the fields.

    Notes
    -----
    Rows are counted from the start of the array passed to the functions, which may be a slice of a larger one with the
    rows of one of many bodies or pairs.
    """

    def __init__(self, lane_count: int, *tuple_types: type) -> None:
        numbers = [(of, path) for of in tuple_types for path in field_paths_of_numbers(of)]
        self.row_count: Final = len(numbers)
        self.array_length: Final = lane_count * self.row_count
        self._rows = {number: lane_count * row for row, number in enumerate(numbers)}
        self._made: dict[tuple[object, ...], TupleReaderAndWriter] = {}

    def row_offset_of_field(self, tuple_type: type, field_path: str) -> int:
        """Return the array index at which the values of the field `field_path` (e.g. ``left.penetration``) start."""
        return self._rows[tuple_type, field_path]

    def tuple_reader_and_writer(
        self, tuple_type: type, field_path: str = "", unused_fields: Collection[str] = ()
    ) -> TupleReaderAndWriter:
        """Return the compiled functions that read and write a named tuple in a column (lane) of the array.

        Parameters
        ----------
        tuple_type : type
            One of the tuples of this layout.
        field_path : str
            Path of field names to a nested tuple; "" for the whole tuple.
        unused_fields : collection of str
            Names of fields, at any depth, that a variant of a kernel does not need: they are loaded as 0, not stored.
            A tuple need not have all of them; a name that no tuple of the layout has raises KeyError.
        """
        unknown = set(unused_fields).difference(*(path.split(".") for _, path in self._rows))
        if unknown:
            raise KeyError(f"unused_fields: no tuple of the layout has {', '.join(sorted(unknown))}")
        kind, prefix = tuple_type, ""
        for name in field_path.split(".") if field_path else ():
            kind, prefix = get_type_hints(kind)[name], f"{prefix}{name}."
        inner = [inner for inner in field_paths_of_numbers(kind) if not set(inner.split(".")) & set(unused_fields)]
        key = (tuple_type, field_path, *inner)
        if key not in self._made:
            self._made[key] = self._create_tuple_access(tuple_type, kind, prefix, inner)
        return self._made[key]

    def _create_tuple_access(
        self,
        layout_tuple_type: type,
        accessed_tuple_type: type,
        path_prefix_of_accessed_tuple: str,
        accessed_field_paths: list[str],
    ) -> TupleReaderAndWriter:
        """Return the compiled functions that read and write a named tuple, which may be a field of a larger tuple."""
        rows = [
            self._rows[layout_tuple_type, path_prefix_of_accessed_tuple + path]
            if path in accessed_field_paths
            else None
            for path in field_paths_of_numbers(accessed_tuple_type)
        ]
        # The rows are part of the name: functions of one name in the machine code must be identical.
        digest = hashlib.sha256(str(rows).encode()).hexdigest()[:16]
        name = f"{accessed_tuple_type.__module__}.{accessed_tuple_type.__qualname__}.{digest}"
        return TupleReaderAndWriter(
            create_tuple_loader(accessed_tuple_type, rows, name),
            create_tuple_storer(accessed_tuple_type, rows, name),
            create_tuple_storer_skipping_flagged_lanes(accessed_tuple_type, rows, name),
        )
