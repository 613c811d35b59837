"""Outcomes have the bits of the last version."""

import json

import pytest

from tests.dem.digests import FILE, OUTCOMES, digest

KNOWN = json.loads(FILE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", OUTCOMES)
def test_outcomes_are_bit_equal_to_the_last_version(name: str) -> None:
    assert digest(name) == KNOWN[name], "changed on purpose? Name it in CHANGELOG.md; python -m tests.dem.digests"
