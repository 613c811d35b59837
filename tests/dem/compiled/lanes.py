"""Access to named tuples in rows of an array, and small functions of the kernels; called by Python."""

from typing import NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel import mechanics
from overturning.dem.kernel.cache import cache_compiled_kernel
from overturning.dem.kernel.lanes import OPTIONS, TupleRowLayout, aligned_zeros, whole_vectors


class Memory(NamedTuple):
    spring: float
    force: float


class Pair(NamedTuple):
    depth: float
    one: Memory
    two: Memory


class Other(NamedTuple):
    mass: float


ROWS = TupleRowLayout(4, Other, Pair)
_load_pair, _store_pair, _store_pair_unless = ROWS.lane_access(Pair)
_load_two, _store_two, _ = ROWS.lane_access(Pair, "two")
_load_forces, _, _store_forces_unless = ROWS.lane_access(Pair, unused_fields=["spring"])


@cache_compiled_kernel
@njit
def load_pair(array, j):  # type: ignore[no-untyped-def]
    return _load_pair(array, j)


@cache_compiled_kernel
@njit
def store_pair(array, j, value):  # type: ignore[no-untyped-def]
    _store_pair(array, j, value)


@cache_compiled_kernel
@njit
def store_pair_unless(array, j, keep, value):  # type: ignore[no-untyped-def]
    _store_pair_unless(array, j, keep, value)


@cache_compiled_kernel
@njit
def load_two(array, j):  # type: ignore[no-untyped-def]
    return _load_two(array, j)


@cache_compiled_kernel
@njit
def store_two(array, j, value):  # type: ignore[no-untyped-def]
    _store_two(array, j, value)


@cache_compiled_kernel
@njit
def load_forces(array, j):  # type: ignore[no-untyped-def]
    return _load_forces(array, j)


@cache_compiled_kernel
@njit
def store_forces_unless(array, j, keep, value):  # type: ignore[no-untyped-def]
    _store_forces_unless(array, j, keep, value)


@cache_compiled_kernel
@njit(**OPTIONS)
def place_and_sum_of_zeros(size):  # type: ignore[no-untyped-def]
    """Return address, size and sum of a new array of aligned zeros."""
    numbers = aligned_zeros(size)
    return numbers.ctypes.data, numbers.size, np.abs(numbers).sum()


@cache_compiled_kernel
@njit
def larger(peak, value):  # type: ignore[no-untyped-def]
    return mechanics.updated_maximum(peak, value)


@cache_compiled_kernel
@njit
def unit_pair(c, s):  # type: ignore[no-untyped-def]
    return mechanics.normalise_cosine_and_sine(c, s)


@cache_compiled_kernel
@njit
def rotate_pair(c, s, turn):  # type: ignore[no-untyped-def]
    return mechanics.rotate_cosine_and_sine(c, s, turn)


@cache_compiled_kernel
@njit
def clamp(force, limit):  # type: ignore[no-untyped-def]
    return mechanics.clamp_magnitude(force, limit)


@cache_compiled_kernel
@njit
def counted(lane_count):  # type: ignore[no-untyped-def]
    return whole_vectors(lane_count)
