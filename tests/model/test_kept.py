"""The model says what it has said: see tests/kept.py."""

import pytest

from tests.kept import check
from tests.model.answers import ANSWERS


@pytest.mark.parametrize("name", ANSWERS)
def test_the_model_says_what_it_has_said(name: str) -> None:
    check("model", name, ANSWERS)
