"""Layout of named tuples in rows of an array, and small mechanics functions shared by the kernels."""

from typing import NamedTuple

import numpy as np
import pytest
from numba import njit

from overturning.dem.block import plan as block
from overturning.dem.body import plan as body
from overturning.dem.kernel import mechanics
from overturning.dem.kernel.lanes import (
    COMPILE_OPTIONS,
    TupleReaderAndWriter,
    TupleRowLayout,
    assume_lane_count_is_multiple_of_8,
    cache_line_aligned_zeros,
)
from overturning.dem.polygon import plan as polygon
from overturning.dem.stack import plan as stack


class TupleNestedTwice(NamedTuple):
    """Named tuple that occurs twice in `NestedContactPairTuple`."""

    spring: float
    force: float


class NestedContactPairTuple(NamedTuple):
    """Named tuple with nested tuples, as the kernels store in rows."""

    depth: float
    one: TupleNestedTwice
    two: TupleNestedTwice


class MassTuple(NamedTuple):
    """Named tuple with one field, stored before `NestedContactPairTuple`."""

    mass: float


def compile_tuple_reader_and_writer_for_python(access: TupleReaderAndWriter) -> TupleReaderAndWriter:
    """Return the access functions of a tuple compiled so that Python can call them."""
    load, store, store_unless = access
    return TupleReaderAndWriter(
        njit(lambda array, j: load(array, j)),
        njit(lambda array, j, value: store(array, j, value)),
        njit(lambda array, j, keep, value: store_unless(array, j, keep, value)),
    )


compiled_updated_maximum = njit(lambda peak, value: mechanics.updated_maximum(peak, value))
compiled_normalise_cosine_and_sine = njit(lambda c, s: mechanics.normalise_cosine_and_sine(c, s))
compiled_rotate_cosine_and_sine = njit(lambda c, s, turn: mechanics.rotate_cosine_and_sine_by_small_angle(c, s, turn))
compiled_clamp_magnitude = njit(lambda force, limit: mechanics.clamp_magnitude(force, limit))

TUPLE_ROW_LAYOUT = TupleRowLayout(4, MassTuple, NestedContactPairTuple)
CONTACT_PAIR_READER_AND_WRITER = compile_tuple_reader_and_writer_for_python(
    TUPLE_ROW_LAYOUT.tuple_reader_and_writer(NestedContactPairTuple)
)
SECOND_SPRING_READER_AND_WRITER = compile_tuple_reader_and_writer_for_python(
    TUPLE_ROW_LAYOUT.tuple_reader_and_writer(NestedContactPairTuple, "two")
)
READER_AND_WRITER_WITHOUT_SPRING_FIELD = compile_tuple_reader_and_writer_for_python(
    TUPLE_ROW_LAYOUT.tuple_reader_and_writer(NestedContactPairTuple, unused_fields=["spring"])
)


def state_array_filled_with_indices() -> np.ndarray:
    """Return a state array of all lanes (cases in parallel) in which each value is the index of its place."""
    return np.arange(float(TUPLE_ROW_LAYOUT.array_length))


def test_an_unused_field_that_no_tuple_of_the_layout_has_is_refused() -> None:
    """A name that no tuple has is refused, as a renamed field would be loaded and stored needlessly and unnoticed."""
    with pytest.raises(KeyError, match="springs"):
        TUPLE_ROW_LAYOUT.tuple_reader_and_writer(NestedContactPairTuple, unused_fields=["spring", "springs"])
    TUPLE_ROW_LAYOUT.tuple_reader_and_writer(MassTuple, unused_fields=["spring"])  # a field of the other tuple only


def test_the_rows_of_the_state_array_follow_the_fields_of_named_tuples() -> None:
    assert (TUPLE_ROW_LAYOUT.row_count, TUPLE_ROW_LAYOUT.array_length) == (6, 24)
    assert [
        TUPLE_ROW_LAYOUT.row_offset_of_field(MassTuple, "mass"),
        TUPLE_ROW_LAYOUT.row_offset_of_field(NestedContactPairTuple, "depth"),
        TUPLE_ROW_LAYOUT.row_offset_of_field(NestedContactPairTuple, "two.spring"),
    ] == [
        0,
        4,
        16,
    ]
    with pytest.raises(KeyError):
        TUPLE_ROW_LAYOUT.row_offset_of_field(NestedContactPairTuple, "three")
    assert CONTACT_PAIR_READER_AND_WRITER.load(state_array_filled_with_indices(), 1) == NestedContactPairTuple(
        5.0, TupleNestedTwice(9.0, 13.0), TupleNestedTwice(17.0, 21.0)
    )
    assert SECOND_SPRING_READER_AND_WRITER.load(state_array_filled_with_indices(), 3) == TupleNestedTwice(19.0, 23.0)


def test_tuples_are_stored_in_and_loaded_from_the_same_rows() -> None:
    array = state_array_filled_with_indices()
    value = NestedContactPairTuple(-1.0, TupleNestedTwice(-2.0, -3.0), TupleNestedTwice(-4.0, -5.0))
    CONTACT_PAIR_READER_AND_WRITER.store(array, 2, value)
    assert CONTACT_PAIR_READER_AND_WRITER.load(array, 2) == value
    assert np.count_nonzero(array < 0) == 5
    # In a slice of a larger array, like the rows of one of many pairs.
    many = np.concatenate([state_array_filled_with_indices(), state_array_filled_with_indices()])
    SECOND_SPRING_READER_AND_WRITER.store(many[TUPLE_ROW_LAYOUT.array_length :], 0, value.two)
    assert np.flatnonzero(many < 0).tolist() == [24 + 16, 24 + 20]


def test_store_unless_writes_neither_if_true_nor_omitted_fields() -> None:
    array = state_array_filled_with_indices()
    value = NestedContactPairTuple(-1.0, TupleNestedTwice(-2.0, -3.0), TupleNestedTwice(-4.0, -5.0))
    CONTACT_PAIR_READER_AND_WRITER.store_unless(array, 0, True, value)
    np.testing.assert_array_equal(array, state_array_filled_with_indices())
    READER_AND_WRITER_WITHOUT_SPRING_FIELD.store_unless(array, 0, False, value)
    assert CONTACT_PAIR_READER_AND_WRITER.load(array, 0) == NestedContactPairTuple(
        -1.0, TupleNestedTwice(8.0, -3.0), TupleNestedTwice(16.0, -5.0)
    )
    assert READER_AND_WRITER_WITHOUT_SPRING_FIELD.load(array, 0) == NestedContactPairTuple(
        -1.0, TupleNestedTwice(0.0, -3.0), TupleNestedTwice(0.0, -5.0)
    )


def test_compiled_code_allocates_aligned_zeros() -> None:
    @njit(**COMPILE_OPTIONS)
    def allocate_aligned_zeros_in_compiled_code(size: int) -> np.ndarray:
        """Allocate zeros in compiled code."""
        return cache_line_aligned_zeros(size)

    for size in (1, 100, 4032):
        numbers = allocate_aligned_zeros_in_compiled_code(size)  # not a copy: Python gets the array at its address
        assert (numbers.ctypes.data % 64, numbers.size, np.abs(numbers).sum()) == (0, size, 0.0)


def test_a_rotated_sine_and_cosine_stay_on_the_unit_circle() -> None:
    c, s = np.cos(0.4), np.sin(0.4)
    for turn in (1e-2, -1e-3, 0.0):
        np.testing.assert_allclose(
            compiled_rotate_cosine_and_sine(c, s, turn),
            (np.cos(0.4 + turn), np.sin(0.4 + turn)),
            atol=2 * turn**6 + 1e-16,
        )
    long = (1.0 + 1e-6) * c, (1.0 + 1e-6) * s
    np.testing.assert_allclose(np.hypot(*compiled_normalise_cosine_and_sine(*long)), 1.0, atol=2e-12)


def test_clamping_keeps_sign_and_nan_and_peaks_ignore_nan() -> None:
    assert [compiled_clamp_magnitude(force, 2.0) for force in (3.0, -3.0, 1.0, 2.0)] == [2.0, -2.0, 1.0, 2.0]
    assert np.signbit(compiled_clamp_magnitude(-1.0, 0.0))
    assert np.isnan(compiled_clamp_magnitude(np.nan, 1.0))
    assert [
        compiled_updated_maximum(1.0, 2.0),
        compiled_updated_maximum(1.0, 0.0),
        compiled_updated_maximum(1.0, np.nan),
    ] == [2.0, 1.0, 1.0]


def test_the_number_of_lanes_is_a_multiple_of_the_vector_length() -> None:
    """`assume_lane_count_is_multiple_of_8` returns its argument only if that is a positive multiple of 8."""
    counted = njit(lambda lane_count: assume_lane_count_is_multiple_of_8(lane_count))
    for model in (block, body, polygon, stack):
        assert model.PARALLEL_CASE_COUNT % 8 == 0
        assert counted(model.PARALLEL_CASE_COUNT) == model.PARALLEL_CASE_COUNT
    assert [counted(count) for count in (8, 16, 24)] == [8, 16, 24]
