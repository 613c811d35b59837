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


def field_paths_of_numbers(tuple_type: type, path_prefix: str = "") -> Iterator[str]:
    """Yield the path of field names to each number of a named tuple type, such as ``left.penetration``, depth first."""
    for name, kind in get_type_hints(tuple_type).items():
        if hasattr(kind, "_fields"):
            yield from field_paths_of_numbers(kind, f"{path_prefix}{name}.")
        else:
            yield path_prefix + name


@cache
def numba_tuple_type(tuple_type: type) -> Any:
    """Return the Numba type of a named tuple of float64 numbers or of further such tuples."""
    if not hasattr(tuple_type, "_fields"):
        return types.float64
    return types.BaseTuple.from_types(
        tuple(numba_tuple_type(inner) for inner in get_type_hints(tuple_type).values()), pyclass=tuple_type
    )


def llvm_numbers_of_tuple(builder: Any, tuple_type: type, llvm_tuple_or_number: Any) -> list[Any]:
    """Return the numbers of a named tuple, as LLVM values, in the order of `field_paths_of_numbers`."""
    inners = get_type_hints(tuple_type).values() if hasattr(tuple_type, "_fields") else ()
    parts = (
        llvm_numbers_of_tuple(builder, inner, builder.extract_value(llvm_tuple_or_number, at))
        for at, inner in enumerate(inners)
    )
    return [number for part in parts for number in part] if inners else [llvm_tuple_or_number]


def build_llvm_tuple(context: Any, builder: Any, tuple_type: type, llvm_numbers: Iterator[Any]) -> Any:
    """Return a tuple, as a value of LLVM, built from numbers in the order of `field_paths_of_numbers`."""
    if not hasattr(tuple_type, "_fields"):
        return next(llvm_numbers)
    parts = [build_llvm_tuple(context, builder, inner, llvm_numbers) for inner in get_type_hints(tuple_type).values()]
    return context.make_tuple(builder, numba_tuple_type(tuple_type), parts)


def select_llvm_value_without_branch(
    builder: Any, llvm_condition: Any, llvm_value_if_true: Any, llvm_value_if_false: Any
) -> Any:
    """Select one of two values by a condition, in LLVM code that needs no branch.

    If one value was just loaded from the address at which the result will be stored, LLVM would make this store
    conditional, which is slower. The instruction ``freeze`` hides from LLVM where the values come from.
    """
    # The builder has no method for this instruction.
    frozen = [
        Instruction(builder.block, value.type, "freeze", [value]) for value in (llvm_value_if_true, llvm_value_if_false)
    ]
    for one in frozen:
        builder._insert(one)
    return builder.select(llvm_condition, *frozen)


class GeneratedLlvmFunction:
    """LLVM function that is generated at its first call, and linked and inlined into every caller.

    Parameters
    ----------
    machine_code_name : str
        Name in the machine code; two functions with the same name must be identical.
    generate_llvm_instructions : callable
        ``generate_llvm_instructions(context, builder, *values)`` emits the instructions of the function and returns
        its result as an LLVM value, or None.
    """

    def __init__(self, machine_code_name: str, generate_llvm_instructions: Callable[..., Any]) -> None:
        self._name, self._generate_llvm_instructions, self._library = (
            machine_code_name,
            generate_llvm_instructions,
            None,
        )

    def __call__(self, context: Any, builder: Any, numba_return_type: Any, *llvm_arguments: Any) -> Any:
        """Emit an LLVM call of the function with numbers and addresses as arguments; return its result."""
        into = (
            None
            if numba_return_type == types.void
            else cgutils.alloca_once(builder, context.get_value_type(numba_return_type))
        )
        llvm_arguments = llvm_arguments if into is None else (into, *llvm_arguments)
        kind = ir.FunctionType(ir.VoidType(), [value.type for value in llvm_arguments])
        self._library = self._library or self._generate_llvm_library(context, kind, into is not None)
        context.add_linking_libs([self._library])
        builder.call(cgutils.get_or_insert_function(builder.module, kind, self._name), llvm_arguments)
        return context.get_dummy_value() if into is None else builder.load(into)

    def _generate_llvm_library(self, context: Any, llvm_function_type: Any, result_is_first_argument: bool) -> Any:
        """Generate the function in its own LLVM library, which is linked to each caller."""
        library = context.codegen().create_library(self._name)
        module = library.create_ir_module(self._name)
        function = ir.Function(module, llvm_function_type, self._name)
        function.attributes.add("alwaysinline")
        builder = ir.IRBuilder(function.append_basic_block())
        result = self._generate_llvm_instructions(context, builder, *function.args[result_is_first_argument:])
        if result_is_first_argument:
            function.args[0].add_attribute("noalias")
            builder.store(result, function.args[0])
        builder.ret_void()
        library.add_ir_module(module)
        return library


def _convert_tuple_to_float64(
    context: Any, builder: Any, tuple_type: type, numba_type_of_value: Any, llvm_tuple_or_number: Any
) -> Any:
    """Return a tuple, or a number, with all its numbers converted from their actual types to float64."""
    if numba_type_of_value == numba_tuple_type(tuple_type):
        return llvm_tuple_or_number
    if not hasattr(tuple_type, "_fields"):
        return context.cast(builder, llvm_tuple_or_number, numba_type_of_value, types.float64)
    inners = zip(get_type_hints(tuple_type).values(), numba_type_of_value, strict=True)
    parts = [
        _convert_tuple_to_float64(context, builder, inner, of, builder.extract_value(llvm_tuple_or_number, at))
        for at, (inner, of) in enumerate(inners)
    ]
    return context.make_tuple(builder, numba_tuple_type(tuple_type), parts)


def _check_argument_types(tuple_type: type, *argument_types: Any) -> None:
    """Raise a `TypingError` if Numba argument types differ from the type of the named tuple."""
    for one in argument_types:
        if getattr(one, "instance_class", None) is not tuple_type:
            raise TypingError(f"expected a {tuple_type.__name__}, got {one}")


def _first_number_address(context: Any, builder: Any, numba_array_type: Any, llvm_array: Any) -> Any:
    """Return the address of the first number of a contiguous 1-D float64 array; raise a `TypingError` for others."""
    if not (
        isinstance(numba_array_type, types.Array)
        and numba_array_type.ndim == 1
        and numba_array_type.layout == "C"
        and numba_array_type.dtype == types.float64
    ):
        raise TypingError(f"expected a contiguous row of numbers, got {numba_array_type}")
    return context.make_array(numba_array_type)(context, builder, value=llvm_array).data


def create_tuple_loader(
    tuple_type: type, row_offset_of_each_number_or_none: list[int | None], llvm_function_name_without_prefix: str
) -> Any:
    """Return a compiled function ``load(array, j)`` that reads a named tuple from column j of a state array.

    `row_offset_of_each_number_or_none` holds the array index at which the row of each number starts; None: the number
    has no row and is 0.
    """

    def generate_load_instructions(context: Any, builder: Any, llvm_array_address: Any, llvm_lane_index: Any) -> Any:
        """Generate the LLVM instructions that load the tuple's numbers from column `llvm_lane_index`."""
        zero = ir.Constant(ir.DoubleType(), 0.0)
        numbers = [
            zero if row is None else builder.load(_address_of_number(builder, llvm_array_address, row, llvm_lane_index))
            for row in row_offset_of_each_number_or_none
        ]
        return build_llvm_tuple(context, builder, tuple_type, iter(numbers))

    generated = GeneratedLlvmFunction(f"load.{llvm_function_name_without_prefix}", generate_load_instructions)

    def signature_and_generator_for_load(
        _typing_context: Any,
        array_type: Any,
        lane_index_type: Any,  # noqa: ARG001
    ) -> Any:
        """Return the Numba signature of ``load`` and the function that generates the LLVM code of its call."""

        def generate_load_call(context: Any, builder: Any, signature: Any, llvm_arguments: Any) -> Any:
            """Generate the LLVM code that calls the loading function."""
            data = _first_number_address(context, builder, signature.args[0], llvm_arguments[0])
            return generated(context, builder, signature.return_type, data, llvm_arguments[1])

        return numba_tuple_type(tuple_type)(array_type, types.uintp), generate_load_call

    return intrinsic(signature_and_generator_for_load)


def create_tuple_storer(
    tuple_type: type, row_offset_of_each_number_or_none: list[int | None], llvm_function_name_without_prefix: str
) -> Any:
    """Return a compiled function ``store(array, j, value)`` that writes a named tuple to column j of a state array.

    `row_offset_of_each_number_or_none` holds the array index at which the row of each number starts; None: the number
    has no row and is not written.
    """

    def generate_store_instructions(
        _: Any, builder: Any, llvm_array_address: Any, llvm_lane_index: Any, *llvm_numbers: Any
    ) -> None:
        """Generate the LLVM instructions that store the tuple's numbers in column `llvm_lane_index`."""
        for row, number in zip(row_offset_of_each_number_or_none, llvm_numbers, strict=True):
            if row is not None:
                builder.store(number, _address_of_number(builder, llvm_array_address, row, llvm_lane_index))

    generated = GeneratedLlvmFunction(f"store.{llvm_function_name_without_prefix}", generate_store_instructions)

    def signature_and_generator_for_store(
        _typing_context: Any,
        array_type: Any,
        lane_index_type: Any,  # noqa: ARG001
        stored_tuple_type: Any,
    ) -> Any:
        """Check the types; return the Numba signature of ``store`` and the generator of the LLVM code of its call."""
        _check_argument_types(tuple_type, stored_tuple_type)

        def generate_call_of_store_function(context: Any, builder: Any, signature: Any, llvm_arguments: Any) -> Any:
            """Generate the LLVM code that calls the storing function."""
            data = _first_number_address(context, builder, signature.args[0], llvm_arguments[0])
            numbers = _convert_tuple_to_float64(context, builder, tuple_type, signature.args[2], llvm_arguments[2])
            return generated(
                context,
                builder,
                types.void,
                data,
                llvm_arguments[1],
                *llvm_numbers_of_tuple(builder, tuple_type, numbers),
            )

        return types.void(array_type, types.uintp, stored_tuple_type), generate_call_of_store_function

    return intrinsic(signature_and_generator_for_store)


def create_tuple_storer_skipping_flagged_lanes(
    tuple_type: type, row_offset_of_each_number_or_none: list[int | None], llvm_function_name_without_prefix: str
) -> Any:
    """Return a compiled function ``store_unless(array, j, keep, value)`` that writes a tuple unless `keep` is true.

    It writes to column j of a state array. `row_offset_of_each_number_or_none` holds the array index at which the row
    of each number starts; None: the number has no row and is not written.
    """

    def generate_store_instructions(
        _: Any,
        builder: Any,
        llvm_array_address: Any,
        llvm_lane_index: Any,
        llvm_skip_store_flag: Any,
        *llvm_numbers: Any,
    ) -> None:
        """Generate the LLVM instructions that store the tuple's numbers in a lane's column unless the flag is true."""
        for row, number in zip(row_offset_of_each_number_or_none, llvm_numbers, strict=True):
            if row is not None:
                at = _address_of_number(builder, llvm_array_address, row, llvm_lane_index)
                builder.store(
                    select_llvm_value_without_branch(builder, llvm_skip_store_flag, builder.load(at), number), at
                )

    generated = GeneratedLlvmFunction(f"store_unless.{llvm_function_name_without_prefix}", generate_store_instructions)

    def signature_and_generator_for_store_unless(
        _context: Any,
        array_type: Any,
        lane_index_type: Any,  # noqa: ARG001
        keep_flag_type: Any,  # noqa: ARG001
        stored_tuple_type: Any,
    ) -> Any:
        """Check the types; return Numba signature of ``store_unless`` and generator of the LLVM code of its call."""
        _check_argument_types(tuple_type, stored_tuple_type)

        def generate_call_of_store_function(context: Any, builder: Any, signature: Any, llvm_arguments: Any) -> Any:
            """Generate the LLVM code that calls the storing function."""
            data = _first_number_address(context, builder, signature.args[0], llvm_arguments[0])
            numbers = _convert_tuple_to_float64(context, builder, tuple_type, signature.args[3], llvm_arguments[3])
            return generated(
                context,
                builder,
                types.void,
                data,
                llvm_arguments[1],
                llvm_arguments[2],
                *llvm_numbers_of_tuple(builder, tuple_type, numbers),
            )

        return types.void(array_type, types.uintp, types.boolean, stored_tuple_type), generate_call_of_store_function

    return intrinsic(signature_and_generator_for_store_unless)


def _address_of_number(builder: Any, llvm_array_address: Any, row_start_index: int, llvm_lane_index: Any) -> Any:
    """Return the address of the number in column `llvm_lane_index` of the row that starts at `row_start_index`."""
    # Unsigned: LLVM cannot always prove that a signed index is not negative.
    return builder.gep(
        llvm_array_address, [builder.add(llvm_lane_index, ir.Constant(llvm_lane_index.type, row_start_index))]
    )


def create_zero_tuple_function(tuple_type: type) -> Any:
    """Return a compiled function ``zero()`` that returns a named tuple of the given type with all numbers zero."""

    def signature_and_generator_for_zeros(_typing_context: Any) -> Any:
        """Return the Numba signature of ``zero()`` and the function that generates the LLVM code of its result."""

        def generate_code_returning_zeros(context: Any, *_: Any) -> Any:
            """Generate the LLVM code of a tuple of zeros."""
            return ir.Constant(context.get_value_type(numba_tuple_type(tuple_type)), None)

        return numba_tuple_type(tuple_type)(), generate_code_returning_zeros

    return intrinsic(signature_and_generator_for_zeros)


def create_elementwise_function(
    tuple_type: type, machine_code_name: str, generate_code_combining_two_numbers: Callable[[Any, Any, Any], Any]
) -> Any:
    """Return a compiled function ``f(a, b)`` that combines two named tuples of one type number by number.

    ``generate_code_combining_two_numbers(builder, x, y)`` emits the LLVM code that combines two numbers.
    """

    def generate_llvm_for_elementwise_operation(context: Any, builder: Any, *llvm_numbers: Any) -> Any:
        """Generate the LLVM instructions that combine the numbers of two tuples one by one."""
        first, second = llvm_numbers[: len(llvm_numbers) // 2], llvm_numbers[len(llvm_numbers) // 2 :]
        return build_llvm_tuple(
            context,
            builder,
            tuple_type,
            (generate_code_combining_two_numbers(builder, *two) for two in zip(first, second, strict=True)),
        )

    generated = GeneratedLlvmFunction(machine_code_name, generate_llvm_for_elementwise_operation)

    def signature_and_generator_for_elementwise_function(
        _typing_context: Any, first_tuple_type: Any, second_tuple_type: Any
    ) -> Any:
        """Check the types; return the Numba signature of ``f(a, b)`` and the generator of the LLVM code of its call."""
        _check_argument_types(tuple_type, first_tuple_type, second_tuple_type)

        def generate_elementwise_function_call(context: Any, builder: Any, signature: Any, llvm_arguments: Any) -> Any:
            """Generate the LLVM code that calls the combining function."""
            two = [
                _convert_tuple_to_float64(context, builder, tuple_type, *one)
                for one in zip(signature.args, llvm_arguments, strict=True)
            ]
            numbers = [number for one in two for number in llvm_numbers_of_tuple(builder, tuple_type, one)]
            return generated(context, builder, signature.return_type, *numbers)

        return numba_tuple_type(tuple_type)(first_tuple_type, second_tuple_type), generate_elementwise_function_call

    return intrinsic(signature_and_generator_for_elementwise_function)


def table_dtype_of_named_tuples(*tuple_types: Any) -> np.dtype[np.void]:
    """Return the dtype of a table with one float64 column for each field of the given named tuples, in order."""
    return np.dtype([(name, "f8") for kind in tuple_types for name in kind._fields])
