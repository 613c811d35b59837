"""What becomes of records is what has become of them: see tests/kept.py."""

import pytest

from tests.kept import check
from tests.records.answers import ANSWERS


@pytest.mark.parametrize("name", ANSWERS)
def test_the_same_becomes_of_records(name: str) -> None:
    check("records", name, ANSWERS)
