"""Load, store and elementwise arithmetic of named tuples of numbers, generated as LLVM instructions.

A kernel has some fifty functions that only load, store or add all numbers of a tuple. Written in Python, they would
take a fifth of the compile time, because Numba would type every number separately.
"""

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, get_type_hints

import numpy as np
from llvmlite import ir
from llvmlite.ir.instructions import Instruction
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic


def number_paths(tuple_type: type, prefix: str = "") -> Iterator[str]:
    """Yield the paths of field names to the numbers of a tuple type, depth first."""
    for name, kind in get_type_hints(tuple_type).items():
        if hasattr(kind, "_fields"):
            yield from number_paths(kind, f"{prefix}{name}.")
        else:
            yield prefix + name


@cache
def numba_tuple_type(tuple_type: type) -> Any:
    """Return the Numba type of a named tuple of float64 numbers or of further such tuples."""
    if not hasattr(tuple_type, "_fields"):
        return types.float64
    return types.BaseTuple.from_types(
        tuple(numba_tuple_type(inner) for inner in get_type_hints(tuple_type).values()), pyclass=tuple_type
    )


def extract_numbers(builder: Any, tuple_type: type, value: Any) -> list[Any]:
    """Return the numbers of a tuple value, in the order of `number_paths`."""
    inners = get_type_hints(tuple_type).values() if hasattr(tuple_type, "_fields") else ()
    parts = (extract_numbers(builder, inner, builder.extract_value(value, at)) for at, inner in enumerate(inners))
    return [number for part in parts for number in part] if inners else [value]


def build_tuple(context: Any, builder: Any, tuple_type: type, numbers: Iterator[Any]) -> Any:
    """Return a tuple value built from numbers in the order of `number_paths`."""
    if not hasattr(tuple_type, "_fields"):
        return next(numbers)
    parts = [build_tuple(context, builder, inner, numbers) for inner in get_type_hints(tuple_type).values()]
    return context.make_tuple(builder, numba_tuple_type(tuple_type), parts)


def select_frozen(builder: Any, condition: Any, first: Any, second: Any) -> Any:
    """Return `first` if the condition holds, else `second`, so that a store of the result stays unconditional.

    LLVM turns the store of a value that was just loaded from the same place into a conditional store. ``freeze`` hides
    that the values are equal.
    """
    # The builder has no method for this instruction.
    frozen = [Instruction(builder.block, value.type, "freeze", [value]) for value in (first, second)]
    for one in frozen:
        builder._insert(one)
    return builder.select(condition, *frozen)


class GeneratedFunction:
    """LLVM function that is generated at its first call, and linked and inlined into every caller.

    Parameters
    ----------
    name : str
        Name in the machine code; functions of one name must be identical.
    write : callable
        ``write(context, builder, *values)`` emits the instructions and returns the result, or None.
    """

    def __init__(self, name: str, write: Callable[..., Any]) -> None:
        self._name, self._write, self._library = name, write, None

    def __call__(self, context: Any, builder: Any, returns: Any, *values: Any) -> Any:
        """Emit a call with numbers and addresses as arguments; return its result, of type `returns`."""
        into = None if returns == types.void else cgutils.alloca_once(builder, context.get_value_type(returns))
        values = values if into is None else (into, *values)
        kind = ir.FunctionType(ir.VoidType(), [value.type for value in values])
        self._library = self._library or self._generate(context, kind, into is not None)
        context.add_linking_libs([self._library])
        builder.call(cgutils.get_or_insert_function(builder.module, kind, self._name), values)
        return context.get_dummy_value() if into is None else builder.load(into)

    def _generate(self, context: Any, kind: Any, has_result: bool) -> Any:
        library = context.codegen().create_library(self._name)
        module = library.create_ir_module(self._name)
        function = ir.Function(module, kind, self._name)
        function.attributes.add("alwaysinline")
        builder = ir.IRBuilder(function.append_basic_block())
        result = self._write(context, builder, *function.args[has_result:])
        if has_result:
            function.args[0].add_attribute("noalias")
            builder.store(result, function.args[0])
        builder.ret_void()
        library.add_ir_module(module)
        return library


def _to_float64(context: Any, builder: Any, tuple_type: type, actual: Any, value: Any) -> Any:
    """Convert a tuple, or a number, of any numeric types to float64."""
    if actual == numba_tuple_type(tuple_type):
        return value
    if not hasattr(tuple_type, "_fields"):
        return context.cast(builder, value, actual, types.float64)
    inners = zip(get_type_hints(tuple_type).values(), actual, strict=True)
    parts = [
        _to_float64(context, builder, inner, of, builder.extract_value(value, at))
        for at, (inner, of) in enumerate(inners)
    ]
    return context.make_tuple(builder, numba_tuple_type(tuple_type), parts)


def _check(tuple_type: type, *given: Any) -> None:
    for one in given:
        if getattr(one, "instance_class", None) is not tuple_type:
            raise TypingError(f"expected a {tuple_type.__name__}, got {one}")


def _data(context: Any, builder: Any, array: Any, value: Any) -> Any:
    if not (
        isinstance(array, types.Array) and array.ndim == 1 and array.layout == "C" and array.dtype == types.float64
    ):
        raise TypingError(f"expected a contiguous row of numbers, got {array}")
    return context.make_array(array)(context, builder, value=value).data


def tuple_loader(tuple_type: type, row_offsets: list[int | None], function_name: str) -> Any:
    """Return a compiled function ``load(array, j)``: the tuple of ``array[row + j]``, with 0 for each row None."""

    def write(context: Any, builder: Any, data: Any, j: Any) -> Any:
        zero = ir.Constant(ir.DoubleType(), 0.0)
        numbers = [zero if row is None else builder.load(_at(builder, data, row, j)) for row in row_offsets]
        return build_tuple(context, builder, tuple_type, iter(numbers))

    generated = GeneratedFunction(f"load.{function_name}", write)

    def load(_: Any, array: Any, j: Any) -> Any:  # noqa: ARG001
        def make(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            data = _data(context, builder, signature.args[0], values[0])
            return generated(context, builder, signature.return_type, data, values[1])

        return numba_tuple_type(tuple_type)(array, types.uintp), make

    return intrinsic(load)


def tuple_storer(tuple_type: type, row_offsets: list[int | None], function_name: str) -> Any:
    """Return a compiled function ``store(array, j, value)`` that writes to ``array[row + j]``, except for row None."""

    def write(_: Any, builder: Any, data: Any, j: Any, *numbers: Any) -> None:
        for row, number in zip(row_offsets, numbers, strict=True):
            if row is not None:
                builder.store(number, _at(builder, data, row, j))

    generated = GeneratedFunction(f"store.{function_name}", write)

    def store(_: Any, array: Any, j: Any, value: Any) -> Any:  # noqa: ARG001
        _check(tuple_type, value)

        def make(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            data = _data(context, builder, signature.args[0], values[0])
            numbers = _to_float64(context, builder, tuple_type, signature.args[2], values[2])
            return generated(
                context, builder, types.void, data, values[1], *extract_numbers(builder, tuple_type, numbers)
            )

        return types.void(array, types.uintp, value), make

    return intrinsic(store)


def conditional_tuple_storer(tuple_type: type, row_offsets: list[int | None], function_name: str) -> Any:
    """Return a compiled function ``store_unless(array, j, keep, value)``: a store unless `keep`, without a branch."""

    def write(_: Any, builder: Any, data: Any, j: Any, keep: Any, *numbers: Any) -> None:
        for row, number in zip(row_offsets, numbers, strict=True):
            if row is not None:
                at = _at(builder, data, row, j)
                builder.store(select_frozen(builder, keep, builder.load(at), number), at)

    generated = GeneratedFunction(f"store_unless.{function_name}", write)

    def store_unless(_: Any, array: Any, j: Any, keep: Any, value: Any) -> Any:  # noqa: ARG001
        _check(tuple_type, value)

        def make(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            data = _data(context, builder, signature.args[0], values[0])
            numbers = _to_float64(context, builder, tuple_type, signature.args[3], values[3])
            return generated(
                context, builder, types.void, data, values[1], values[2], *extract_numbers(builder, tuple_type, numbers)
            )

        return types.void(array, types.uintp, types.boolean, value), make

    return intrinsic(store_unless)


def _at(builder: Any, data: Any, row: int, j: Any) -> Any:
    # Unsigned: LLVM cannot always prove that a signed index is not negative.
    return builder.gep(data, [builder.add(j, ir.Constant(j.type, row))])


def zero_tuple_maker(tuple_type: type) -> Any:
    """Return a compiled function ``zero()``: a tuple of zeros."""

    def zero(_: Any) -> Any:
        def make(context: Any, *_: Any) -> Any:
            return ir.Constant(context.get_value_type(numba_tuple_type(tuple_type)), None)

        return numba_tuple_type(tuple_type)(), make

    return intrinsic(zero)


def elementwise_function(tuple_type: type, function_name: str, combine: Callable[[Any, Any, Any], Any]) -> Any:
    """Return a compiled function ``f(a, b)`` that applies ``combine(builder, x, y)`` to each pair of numbers."""

    def write(context: Any, builder: Any, *numbers: Any) -> Any:
        first, second = numbers[: len(numbers) // 2], numbers[len(numbers) // 2 :]
        return build_tuple(
            context, builder, tuple_type, (combine(builder, *two) for two in zip(first, second, strict=True))
        )

    generated = GeneratedFunction(function_name, write)

    def function(_: Any, a: Any, b: Any) -> Any:
        _check(tuple_type, a, b)

        def make(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            two = [_to_float64(context, builder, tuple_type, *one) for one in zip(signature.args, values, strict=True)]
            numbers = [number for one in two for number in extract_numbers(builder, tuple_type, one)]
            return generated(context, builder, signature.return_type, *numbers)

        return numba_tuple_type(tuple_type)(a, b), make

    return intrinsic(function)


def table_dtype(*kinds: Any) -> np.dtype[np.void]:
    """Return the dtype of a table with a column of floats for each field of named tuples, in their order."""
    return np.dtype([(name, "f8") for kind in kinds for name in kind._fields])
