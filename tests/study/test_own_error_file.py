"""What the report says of a verification, and outcomes that it cannot read."""

import json
from pathlib import Path
from typing import Any

import pytest

from overturning.errors import ResultError
from overturning.report.own_error import own_error
from overturning.study.own_error_file import write_verification
from tests.study.small_study import study

COUNTS = {"element": "", "cases": 200, "flags": 2, "fallen": 50, "sides": 0, "unanswered": 0}
FOUND = {
    "seed": 1, "wanted": 200, "chosen": 200, "at_rest": 0, "cells": 9000, "study_block_steps": 1000, "cost": 1.0,
    "finer_by": 8, "stiffer_by": 4.0, "finer": {"block_steps": 500, "outcomes": [COUNTS]}, "stiffer": {"refused": "too stiff"},
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
    with pytest.raises(ResultError, match="remove it and run the study again") as error:
        own_error(study(), tmp_path)
    assert str(error.value).startswith(f"{path}: {said}")
    assert "\n" not in str(error.value)


def test_report_warns_from_one_percent_on_and_says_what_was_refused(tmp_path: Path) -> None:
    counts, found = COUNTS, FOUND
    finer = {"block_steps": 500, "outcomes": [counts]}
    write_verification(found, tmp_path / "verification.json")
    shown = own_error(study(), tmp_path)
    assert shown is not None
    assert shown["warns"] == []
    assert shown["text"].startswith("200 of the 9000 cases, drawn at random, were run again; 0 of them")
    assert shown["repetitions"][1].refused == "too stiff"
    assert shown["repetitions"][0].cost == 0.5
    write_verification(found | {"finer": finer | {"outcomes": [counts | {"flags": 3}]}}, tmp_path / "verification.json")
    shown = own_error(study(), tmp_path)
    assert shown is not None
    assert shown["warns"] == ["steps 8 times finer"]
    assert own_error(study(verification="none"), tmp_path) is None
    with_variant = own_error(study(variants={"bouncy": {"contact": {"damping_ratio": 0.1}}}), tmp_path)
    assert with_variant is not None
    assert "variants were not run again" in with_variant["text"]
