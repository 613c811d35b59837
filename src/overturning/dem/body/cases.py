"""The cases in space, checked."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.cases import check_count, check_heights
from overturning.model.shapes import Shape


@dataclass(frozen=True)
class SpaceCases:
    """Bodies of one kind to run, one row per case.

    Parameters
    ----------
    orientation_deg : array_like
        Azimuth to which the body's x-axis points, degrees clockwise from north: for a prism the normal of its first side.
    height, b_over_h, aspect : array_like
        H (m), B/H and D/B; those that the kind of body has itself count for nothing.
    friction : array_like
        μ.
    amplitude : array_like
        Factor on the whole motion.
    damping_factor : array_like
        Factor on the contact's dashpots.

    Raises
    ------
    ArgumentError
        If lengths differ or a value is outside its bounds.
    """

    orientation_deg: ArrayLike
    height: ArrayLike
    b_over_h: ArrayLike
    aspect: ArrayLike
    friction: ArrayLike
    amplitude: ArrayLike = 1.0
    damping_factor: ArrayLike = 1.0

    def __post_init__(self) -> None:
        columns = {item.name: np.atleast_1d(np.asarray(getattr(self, item.name), np.float64)) for item in fields(self)}
        try:
            arrays = np.broadcast_arrays(*columns.values())
        except ValueError:
            sizes = ", ".join(f"{name} {values.size}" for name, values in columns.items())
            raise ArgumentError(f"cases: lengths differ ({sizes}); give one value per case, or one for all") from None
        for name, values in zip(columns, arrays, strict=True):
            if values.ndim != 1:
                raise ArgumentError(f"{name}: shape {values.shape}; give one row with a value per case")
            object.__setattr__(self, name, values)
            above, signed = name in ("height", "b_over_h", "aspect"), name == "orientation_deg"
            wrong = ~np.isfinite(values) | (not signed) & ((values < 0.0) | above & (values == 0.0))
            if wrong.any():
                bound = "" if signed else f" and {'above' if above else 'at least'} 0"
                raise ArgumentError(f"{name}: {values[wrong][0]}; it must be finite{bound}")
        check_heights(self.height)
        check_count(self.size)

    @property
    def size(self) -> int:
        """Number of cases."""
        return int(np.asarray(self.orientation_deg).size)

    @property
    def table(self) -> FloatArray:
        """A row per case, its columns in the order of the parameters."""
        return np.stack([np.asarray(getattr(self, item.name)) for item in fields(self)], axis=1)


def sizes_of(shape: Shape, b_over_h: ArrayLike | None, height: ArrayLike | None) -> tuple[ArrayLike, ArrayLike]:
    """Slenderness and heights where they are the body's own; `ArgumentError` where one is missing or cannot be chosen."""
    if shape.sized:
        if b_over_h is None or height is None:
            raise ArgumentError(
                f"{'b_over_h' if b_over_h is None else 'height'}: not given; a {shape.name} has none of its own"
            )
        return b_over_h, height
    if b_over_h is not None:
        raise ArgumentError(f"b_over_h: a {shape.name} has its own; leave it out")
    own = getattr(shape, "height", 1.0)
    return shape.body(own, 1.0, 1.0).b_over_h, own if height is None else height
