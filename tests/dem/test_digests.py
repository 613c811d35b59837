"""Outcomes have the bits of the last version."""

import json

import pytest

from tests.dem.digests import DIGEST_FILE, OUTCOME_FUNCTIONS, outcome_digest

STORED_DIGESTS = json.loads(DIGEST_FILE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", OUTCOME_FUNCTIONS)
def test_outcomes_are_bit_equal_to_the_last_version(name: str) -> None:
    assert outcome_digest(name) == STORED_DIGESTS[name], (
        "changed on purpose? Name it in CHANGELOG.md; python -m tests.dem.digests"
    )
