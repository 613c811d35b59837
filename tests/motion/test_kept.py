"""Motions are measured as they were: see tests/kept.py."""

import pytest

from tests.kept import check
from tests.motion.answers import ANSWERS


@pytest.mark.parametrize("name", ANSWERS)
def test_motions_are_measured_as_they_were(name: str) -> None:
    check("motion", name, ANSWERS)
