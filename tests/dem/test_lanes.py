"""Layout of named tuples in rows of an array, and small mechanics functions shared by the kernels."""

from typing import NamedTuple

import numpy as np
import pytest
from numba import njit

from overturning.dem.block import plan as block
from overturning.dem.body import plan as body
from overturning.dem.kernel import mechanics
from overturning.dem.kernel.lanes import (
    OPTIONS,
    StateTupleAccess,
    TupleRowLayout,
    cache_line_aligned_zeros,
    whole_vectors,
)
from overturning.dem.polygon import plan as polygon
from overturning.dem.stack import plan as stack


class Memory(NamedTuple):
    spring: float
    force: float


class Pair(NamedTuple):
    depth: float
    one: Memory
    two: Memory


class Other(NamedTuple):
    mass: float


def compiled(access: StateTupleAccess) -> StateTupleAccess:
    """Return the access functions compiled so that Python can call them."""
    load, store, store_unless = access
    return StateTupleAccess(
        njit(lambda array, j: load(array, j)),
        njit(lambda array, j, value: store(array, j, value)),
        njit(lambda array, j, keep, value: store_unless(array, j, keep, value)),
    )


larger = njit(lambda peak, value: mechanics.updated_maximum(peak, value))
unit_pair = njit(lambda c, s: mechanics.normalise_cosine_and_sine(c, s))
rotate_pair = njit(lambda c, s, turn: mechanics.rotate_cosine_and_sine(c, s, turn))
clamp = njit(lambda force, limit: mechanics.clamp_magnitude(force, limit))

ROWS = TupleRowLayout(4, Other, Pair)
PAIR, TWO = compiled(ROWS.tuple_access(Pair)), compiled(ROWS.tuple_access(Pair, "two"))
NO_SPRINGS = compiled(ROWS.tuple_access(Pair, unused_fields=["spring"]))


def lanes() -> np.ndarray:
    return np.arange(float(ROWS.size))


def test_rows_follow_the_fields() -> None:
    assert (ROWS.count, ROWS.size) == (6, 24)
    assert [ROWS.row_start(Other, "mass"), ROWS.row_start(Pair, "depth"), ROWS.row_start(Pair, "two.spring")] == [
        0,
        4,
        16,
    ]
    with pytest.raises(KeyError):
        ROWS.row_start(Pair, "three")
    assert PAIR.load(lanes(), 1) == Pair(5.0, Memory(9.0, 13.0), Memory(17.0, 21.0))
    assert TWO.load(lanes(), 3) == Memory(19.0, 23.0)


def test_store_and_load_use_the_same_rows() -> None:
    array, value = lanes(), Pair(-1.0, Memory(-2.0, -3.0), Memory(-4.0, -5.0))
    PAIR.store(array, 2, value)
    assert PAIR.load(array, 2) == value
    assert np.count_nonzero(array < 0) == 5
    # In a slice of a larger array, like the rows of one of many pairs.
    many = np.concatenate([lanes(), lanes()])
    TWO.store(many[ROWS.size :], 0, value.two)
    assert np.flatnonzero(many < 0).tolist() == [24 + 16, 24 + 20]


def test_store_unless_keeps_a_lane_and_omitted_fields_are_not_stored() -> None:
    array, value = lanes(), Pair(-1.0, Memory(-2.0, -3.0), Memory(-4.0, -5.0))
    PAIR.store_unless(array, 0, True, value)
    np.testing.assert_array_equal(array, lanes())
    NO_SPRINGS.store_unless(array, 0, False, value)
    assert PAIR.load(array, 0) == Pair(-1.0, Memory(8.0, -3.0), Memory(16.0, -5.0))
    assert NO_SPRINGS.load(array, 0) == Pair(-1.0, Memory(0.0, -3.0), Memory(0.0, -5.0))


def test_compiled_code_allocates_aligned_zeros() -> None:
    @njit(**OPTIONS)
    def allocated(size: int) -> np.ndarray:
        return cache_line_aligned_zeros(size)

    for size in (1, 100, 4032):
        numbers = allocated(size)  # not a copy: Python gets the array at its address
        assert (numbers.ctypes.data % 64, numbers.size, np.abs(numbers).sum()) == (0, size, 0.0)


def test_a_rotated_sine_and_cosine_stay_on_the_unit_circle() -> None:
    c, s = np.cos(0.4), np.sin(0.4)
    for turn in (1e-2, -1e-3, 0.0):
        np.testing.assert_allclose(
            rotate_pair(c, s, turn), (np.cos(0.4 + turn), np.sin(0.4 + turn)), atol=2 * turn**6 + 1e-16
        )
    long = (1.0 + 1e-6) * c, (1.0 + 1e-6) * s
    np.testing.assert_allclose(np.hypot(*unit_pair(*long)), 1.0, atol=2e-12)


def test_limits_keep_the_sign_and_propagate_nan() -> None:
    assert [clamp(force, 2.0) for force in (3.0, -3.0, 1.0, 2.0)] == [2.0, -2.0, 1.0, 2.0]
    assert np.signbit(clamp(-1.0, 0.0))
    assert np.isnan(clamp(np.nan, 1.0))
    assert [larger(1.0, 2.0), larger(1.0, 0.0), larger(1.0, np.nan)] == [2.0, 1.0, 1.0]


def test_the_lanes_of_all_models_fill_whole_vectors() -> None:
    """`whole_vectors` returns another number than it is given unless that is a positive multiple of 8."""
    counted = njit(lambda lane_count: whole_vectors(lane_count))
    for model in (block, body, polygon, stack):
        assert model.COLUMNS % 8 == 0
        assert counted(model.COLUMNS) == model.COLUMNS
    assert [counted(count) for count in (8, 16, 24)] == [8, 16, 24]
