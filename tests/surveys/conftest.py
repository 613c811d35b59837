"""The synthetic cubes of the statistics, and the library of candidate motions."""

import pytest

from overturning.surveys.library import CandidateMotion, candidate_motions
from tests.statistics.conftest import make_cube, sector

__all__ = ["library_motions", "make_cube", "sector"]


@pytest.fixture(scope="package")
def library_motions() -> tuple[CandidateMotion, ...]:
    """Return the candidate motions of the package, whose 49 records take half a second to read: do not change them."""
    return tuple(candidate_motions())
