"""The kernels find again what is kept of them: see tests/kept.py."""

import pytest

from tests.dem.answers import ANSWERS
from tests.kept import check


@pytest.mark.parametrize("name", ANSWERS)
def test_the_kernels_find_what_they_have_found(name: str) -> None:
    check("dem", name, ANSWERS)
