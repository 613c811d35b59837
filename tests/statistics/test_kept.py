"""The statistics find again what is kept of them: see tests/kept.py."""

import pytest

from tests.kept import check
from tests.statistics.answers import ANSWERS


@pytest.mark.parametrize("name", ANSWERS)
def test_the_statistics_find_what_they_have_found(name: str) -> None:
    check("statistics", name, ANSWERS)
