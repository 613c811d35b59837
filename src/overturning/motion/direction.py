"""Directions in the horizontal plane, as the simulation uses them; the readers turn components by the same formula."""

from overturning.records.direction import along, direction_cosines

__all__ = ["along", "direction_cosines"]
