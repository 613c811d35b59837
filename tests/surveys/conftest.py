"""Fixtures for tests of surveys: synthetic cubes, as in the tests of statistics, and the library of motions."""

import pytest

from overturning.surveys.library import CandidateMotion, candidate_motions
from tests.statistics.conftest import make_cube_from_fall_rules, make_sector_fall_rule

__all__ = ["candidate_motions_of_package", "make_cube_from_fall_rules", "make_sector_fall_rule"]


@pytest.fixture(scope="package")
def candidate_motions_of_package() -> tuple[CandidateMotion, ...]:
    """Return the candidate motions of the package, whose 49 records take half a second to read: do not change them."""
    return tuple(candidate_motions())
