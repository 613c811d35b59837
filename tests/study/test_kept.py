"""The same comes of studies as before: see tests/kept.py."""

import pytest

from tests.kept import check
from tests.study.answers import ANSWERS


@pytest.mark.parametrize("name", ANSWERS)
def test_the_same_comes_of_studies(name: str) -> None:
    check("study", name, ANSWERS)
