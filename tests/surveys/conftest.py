"""The synthetic cubes of the statistics."""

from tests.statistics.conftest import make_cube, sector

__all__ = ["make_cube", "sector"]
