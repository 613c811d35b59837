"""A part of a study run again: what is chosen, what is counted, and that it is the same each time."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binomtest

from overturning.dem.cases import Cases, run_cases
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.report.own_error import own_error
from overturning.study.config import Study, Verification
from overturning.study.load import check_study
from overturning.verification.comparison import Counts, compare
from overturning.verification.intervals import wilson
from overturning.verification.study import Cells, choose, repeat_cells, write_verification
from tests.dem.near_field import near_field


@pytest.mark.parametrize(("count", "total"), [(0, 200), (3, 200), (200, 200), (17, 40), (1, 1)])
def test_interval_is_scipys(count: int, total: int) -> None:
    expected = binomtest(count, total).proportion_ci(method="wilson")
    assert wilson(count, total) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_interval_without_cases_says_nothing() -> None:
    assert wilson(0, 0) == (0.0, 1.0)


def test_comparison_counts_each_kind_of_change_once() -> None:
    first = np.array([0, 0, 1, 1, -1, -1, -128, 1, -128], np.int8)
    second = np.array([0, 1, 0, -1, -1, 1, 0, -128, -128], np.int8)
    found = compare(first, second)
    assert found == Counts(cases=6, flags=2, fallen=3, sides=2, unanswered=3)
    assert found + Counts(flags=1) == Counts(cases=6, flags=3, fallen=3, sides=2, unanswered=3)


def test_choice_has_the_wanted_size_no_mirrored_cell_and_none_twice() -> None:
    computed = np.ones((10, 1, 20, 2), bool)
    computed[5:] = False
    chosen = choose(Verification(share=0.1, at_least=7), 3, computed)
    assert sum(map(len, chosen)) == round(0.1 * 3 * 400)
    for cells in chosen:
        assert computed[tuple(cells.T)].all()
        assert len(np.unique(cells, axis=0)) == len(cells)
    assert sum(map(len, choose(Verification(share=0.001, at_least=50), 3, computed))) == 50
    assert sum(map(len, choose(Verification(at_least=10_000), 3, computed))) == 600, "all of a small study"
    other = choose(Verification(share=0.1, seed=2), 3, computed)
    assert not all(np.array_equal(one, two) for one, two in zip(chosen, other, strict=True))


def record(motion: Motion, name: str) -> Record:
    return Record(
        record_id=name, north=motion.north, east=motion.east, up=None, sampling_interval=motion.sampling_interval
    )


def study(**more: object) -> Study:
    base = {
        "name": "small", "records": {"use": ["a", "b"]}, "azimuth": {"step": 60}, "b_over_h": [0.2, 0.3, 0.4],
        "height": [0.6], "friction": [0.58], "verification": {"at_least": 10},
    }  # fmt: skip
    return check_study(base | more, "small")


def short(number: int) -> Motion:
    """The strong part of a record."""
    motion, _, _ = near_field(number)
    peak = int(np.argmax(np.abs(motion.north) + np.abs(motion.east)))
    part = slice(max(peak - 200, 0), peak + 400)
    return Motion(motion.north[part], motion.east[part], sampling_interval=motion.sampling_interval)


def test_repetition_counts_against_the_studys_flags_and_does_not_depend_on_threads() -> None:
    settings, motions = study(), [short(7), short(8)]
    index = choose(settings.verification, 2, np.ones((6, 1, 3, 1), bool))
    axes = (np.array([0.0, 60, 120, 180, 240, 300]), np.array([0.6]), np.array([0.2, 0.3, 0.4]), np.array([0.58]))
    cells, work = [], 0
    for motion, chosen in zip(motions, index, strict=True):
        cases = Cases(*(axis[chosen[:, column]] for column, axis in enumerate(axes)))
        answer = run_cases(motion, cases)
        cells.append(Cells(chosen, answer.overturned, answer.status))
        work += int(answer.block_steps.sum())
    records = [record(motion, name) for motion, name in zip(motions, "ab", strict=True)]
    found = repeat_cells(settings, records, cells, 1000)
    assert found["finer"]["cases"] + found["finer"]["unanswered"] == 10
    assert 6 * work < found["finer"]["block_steps"] < 10 * work
    assert 1.5 * work < found["stiffer"]["block_steps"] < 3 * work, "the step follows the root of the stiffness"
    wrong = [Cells(part.index, np.where(part.overturned == 0, 1, 0).astype(np.int8), part.status) for part in cells]
    assert repeat_cells(settings, records, wrong, 1000)["finer"]["flags"] == 10 - found["finer"]["flags"]
    assert json.dumps(repeat_cells(settings, records, cells, 1000, threads=2)) == json.dumps(found)


def test_report_warns_from_one_percent_on_and_says_what_was_refused(tmp_path: Path) -> None:
    counts = {"cases": 200, "flags": 2, "fallen": 50, "sides": 0, "unanswered": 0, "block_steps": 500}
    found = {
        "seed": 1, "chosen": 200, "at_rest": 0, "cells": 9000, "study_block_steps": 1000, "finer_by": 8,
        "stiffer_by": 4.0, "finer": counts, "stiffer": {"refused": "too stiff"},
    }  # fmt: skip
    write_verification(found, tmp_path / "verification.json")
    shown = own_error(study(), tmp_path)
    assert shown is not None
    assert shown["warns"] == []
    assert shown["repetitions"][1].refused == "too stiff"
    assert shown["repetitions"][0].cost == 0.5
    write_verification(found | {"finer": counts | {"flags": 3}}, tmp_path / "verification.json")
    shown = own_error(study(), tmp_path)
    assert shown is not None
    assert shown["warns"] == ["steps 8 times finer"]
    assert own_error(study(verification="none"), tmp_path) is None
