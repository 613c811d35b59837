"""Fixtures for tests of surveys: synthetic cubes, as in the tests of statistics, and the library of motions."""

import pytest

from overturning.surveys.library import CandidateMotion, candidate_motions
from tests.statistics.conftest import falls_in_sector, make_cube

__all__ = ["falls_in_sector", "library_motions", "make_cube"]


@pytest.fixture(scope="package")
def library_motions() -> tuple[CandidateMotion, ...]:
    """Return the candidate motions of the package, whose 49 records take half a second to read: do not change them."""
    return tuple(candidate_motions())
