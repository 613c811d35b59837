"""Cases to simulate: values of azimuth, sizes, friction and further parameters, checked against their bounds."""

from dataclasses import dataclass, fields
from typing import Final

import numpy as np

from overturning.arrays import ArrayLike, FloatArray, check_has_no_masked_values, convert_argument_to_float_array
from overturning.errors import ArgumentError, refuse_unknown_keywords

MAX_CASES_PER_CALL: Final = 50_000_000
"""Largest number of cases in one call; more would not fit into the memory of an ordinary machine."""

MAX_DIRECTION_DEG: Final = 1e6
"""Largest azimuth or orientation, degrees: beyond it, rounding takes away digits that matter."""

MIN_STONE_HEIGHT_M, MAX_STONE_HEIGHT_M = 0.01, 50.0
"""Range of heights in the map of stability (docs/validation.md), m; a height outside it suggests a wrong unit."""

MEMORY_BYTES_PER_CASE: Final = 300
"""Memory of inputs, plan and results of one case, bytes."""


@refuse_unknown_keywords()
@dataclass(frozen=True, eq=False)
class Cases:
    """Parameters of the cases to simulate: for each parameter one value per case, or one value for all cases.

    Parameters
    ----------
    azimuth_deg : array_like
        Azimuth of the vertical plane (2-D), or that the first side of a 3-D body faces, degrees clockwise from north.
    height : array_like
        H of the model's reference element, m.
    b_over_h : array_like
        B/H of the reference element; ignored for a polyhedron, which has its own.
    friction : array_like
        Friction coefficient μ between the object and its base.
    amplitude : array_like
        Factor on the whole motion.
    damping_factor : array_like
        Factor on the contact's dashpots.
    initial_tilt : array_like
        Initial rotation θ of a block at rest on one corner, rad; positive towards the azimuth.
    aspect : array_like
        D/B of a rectangular prism in 3-D.

    Raises
    ------
    ArgumentError
        If lengths differ or a value is outside its bounds.
    """

    azimuth_deg: ArrayLike
    height: ArrayLike
    b_over_h: ArrayLike
    friction: ArrayLike
    amplitude: ArrayLike = 1.0
    damping_factor: ArrayLike = 1.0
    initial_tilt: ArrayLike = 0.0
    aspect: ArrayLike = 1.0

    def __post_init__(self) -> None:
        # Copies, so that arrays of the caller that change later do not change the checked cases.
        columns = {
            item.name: convert_argument_to_float_array(item.name, getattr(self, item.name), copy=True)
            for item in fields(self)
        }
        for name, values in columns.items():
            check_has_no_masked_values(name, values)
            if values.ndim > 1:
                raise ArgumentError(f"{name}: shape {values.shape}; give one row with a value per case")
        try:
            arrays = np.broadcast_arrays(*(np.atleast_1d(values) for values in columns.values()))
        except ValueError:
            sizes = ", ".join(f"{name} {values.size}" for name, values in columns.items())
            raise ArgumentError(f"cases: lengths differ ({sizes}); give one value per case, or one for all") from None
        for name, values in zip(columns, arrays, strict=True):
            values.flags.writeable = False
            object.__setattr__(self, name, values)
            above, signed = name in ("height", "b_over_h", "aspect"), name in ("azimuth_deg", "initial_tilt")
            wrong = ~np.isfinite(values) | (not signed) & ((values < 0.0) | above & (values == 0.0))
            if wrong.any():
                bound = "" if signed else f" and {'above' if above else 'at least'} 0"
                raise ArgumentError(f"{name}: {values[wrong][0]}; it must be finite{bound}")
        check_stone_heights_within_allowed_range(self.height)
        check_directions_within_allowed_range("azimuth_deg", np.asarray(self.azimuth_deg))
        check_case_count(self.case_count)
        tilt = np.tan(np.minimum(np.abs(np.asarray(self.initial_tilt)), 1.57))
        if (tilt >= np.asarray(self.b_over_h)).any():
            raise ArgumentError("initial_tilt: the block would fall by itself; it must stay below arctan(B/H)")

    @property
    def case_count(self) -> int:
        """Number of cases to simulate, each with its own direction, size and friction."""
        return int(np.asarray(self.azimuth_deg).size)


def check_directions_within_allowed_range(argument_name: str, direction_deg: FloatArray) -> None:
    """Raise an `ArgumentError` with the argument's name if an azimuth or orientation is too large to be exact."""
    if (far := direction_deg[np.abs(direction_deg) > MAX_DIRECTION_DEG]).size:
        raise ArgumentError(f"{argument_name}: {far[0]:g}; at most {MAX_DIRECTION_DEG:g} degrees, a full turn is 360")


def check_stone_heights_within_allowed_range(height: ArrayLike) -> None:
    """Raise an `ArgumentError` if a stone height (m) is outside the allowed range, which suggests a wrong unit."""
    for value in np.unique(np.asarray(height, dtype=np.float64)):
        if not MIN_STONE_HEIGHT_M <= value <= MAX_STONE_HEIGHT_M:
            unit = "; is that in centimetres or millimetres?" if value > MAX_STONE_HEIGHT_M else "; heights are in m"
            raise ArgumentError(
                f"height: {value:g} m; a stone is {MIN_STONE_HEIGHT_M:g} to {MAX_STONE_HEIGHT_M:g} m high{unit}"
            )


def checked_stone_height(height: float) -> float:
    """Return a stone height (m) unchanged; raise an `ArgumentError` if it is outside the allowed range."""
    check_stone_heights_within_allowed_range(height)
    return height


def check_case_count(case_count: int) -> None:
    """Raise an `ArgumentError` if there are no cases, or more than fit into the memory of an ordinary machine."""
    if case_count == 0:
        raise ArgumentError("cases: none; give at least one azimuth, height, B/H and friction")
    if case_count > MAX_CASES_PER_CALL:
        raise ArgumentError(
            f"cases: {case_count} at once would take {case_count * MEMORY_BYTES_PER_CASE / 2**30:.0f} GiB; "
            f"ask for at most {MAX_CASES_PER_CALL} per call"
        )
