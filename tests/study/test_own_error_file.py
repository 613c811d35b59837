"""Outcomes of a verification that cannot be read."""

import json
from pathlib import Path
from typing import Any

import pytest

from overturning.errors import ResultError
from overturning.study.own_error_file import read_verification

COUNTS = {"element": "", "cases": 200, "flags": 2, "flags_undivided": 2, "fallen": 50, "sides": 0, "unanswered": 0}
FOUND = {
    "seed": 1, "wanted": 200, "chosen": 200, "at_rest": 0, "cells": 9000, "study_block_steps": 1000, "cost": 1.0,
    "finer_by": 8, "stiffer_by": 4.0, "finer": {"block_steps": 500, "outcomes": [COUNTS]},
    "stiffer": {"refused": "too stiff"},
    "settling": {"changed": 0, "looked_at": 0, "settled": 0, "chaotic": 0, "block_steps": 0},
}  # fmt: skip


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ({name: value for name, value in FOUND.items() if name != "seed"}, "seed is missing"),
        (FOUND | {"finer": {"outcomes": [COUNTS]}}, "finer.block_steps is missing"),
        (FOUND | {"finer": {"flags": 2}}, "finer.block_steps is missing"),
        (FOUND | {"finer": {"block_steps": 1, "outcomes": [{"element": ""}]}}, "finer.outcomes.0.cases is missing"),
        (FOUND | {"chosen": "many"}, "chosen input should be a valid integer"),
        (["old"], "input should be a valid dictionary"),
    ],
)
def test_the_outcome_of_an_older_version_is_refused_by_file_and_key(tmp_path: Path, written: Any, said: str) -> None:
    path = tmp_path / "verification.json"
    path.write_text(json.dumps(written), encoding="utf-8")
    with pytest.raises(ResultError, match="run the study again, which makes") as error:
        read_verification(path)
    assert str(error.value).startswith(f"{path}: {said}")
    assert "\n" not in str(error.value)
