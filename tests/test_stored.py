"""A stored result is plain JSON, and is read back with its numbers, arrays and missing values."""

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from overturning.errors import ResultError
from overturning.stored import (
    StoredFloatArray,
    StoredFloatOrNan,
    StoredIntegerArray,
    read_json_result,
    write_result_as_json,
)


@dataclass(frozen=True)
class NestedResult:
    """Result that is a field of another result."""

    p_value: StoredFloatOrNan = math.nan


@dataclass(frozen=True)
class ResultWithNestedResultAndArrays:
    """Result with a nested result, arrays and an optional array."""

    name: str
    part: NestedResult
    shares: StoredFloatArray
    counts: StoredIntegerArray | None


@pytest.mark.parametrize("counts", [None, np.array([[1, 2], [3, 4]])])
def test_a_result_is_stored_as_plain_json_and_read_back_equal(tmp_path: Path, counts: np.ndarray | None) -> None:
    path, tenth = tmp_path / "folder" / "whole.json", 0.1 + 0.2
    write_result_as_json(ResultWithNestedResultAndArrays("µ", NestedResult(), np.array([tenth, 1e-12]), counts), path)
    plain = json.loads(path.read_text(encoding="utf-8"))
    rows = None if counts is None else [[1, 2], [3, 4]]
    assert plain == {"name": "µ", "part": {"p_value": None}, "shares": [tenth, 1e-12], "counts": rows}
    back = read_json_result(ResultWithNestedResultAndArrays, path, "test")
    assert (back.name, back.shares.tolist()) == ("µ", [tenth, 1e-12])
    assert math.isnan(back.part.p_value)
    assert (back.counts is None) if counts is None else np.array_equal(back.counts, counts)


def test_a_list_of_results_is_stored_on_one_line(tmp_path: Path) -> None:
    write_result_as_json([NestedResult(1.0), NestedResult()], tmp_path / "a.json", indent=None)
    assert (tmp_path / "a.json").read_text(encoding="utf-8") == '[{"p_value":1.0},{"p_value":null}]\n'
    first, second = read_json_result(list[NestedResult], tmp_path / "a.json", "test")
    assert first.p_value == 1.0
    assert math.isnan(second.p_value)
    write_result_as_json([], tmp_path / "none.json")
    assert read_json_result(list[NestedResult], tmp_path / "none.json", "test") == []


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("{", "Invalid JSON"),
        ('{"name": "a", "part": {}, "shares": [1]}', "counts: this key is needed"),
        ('{"name": "a", "part": {"p_value": "x"}, "shares": [1], "counts": null}', "part.p_value: a number is needed"),
        ('{"name": "a", "part": {}, "shares": ["x"], "counts": null}', "shares: "),
    ],
)
def test_an_invalid_result_file_is_refused_and_the_wrong_key_is_named(tmp_path: Path, text: str, why: str) -> None:
    path = tmp_path / "whole.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ResultError, match=r"run the study again to recreate the thing") as error:
        read_json_result(ResultWithNestedResultAndArrays, path, "thing")
    assert str(error.value).startswith(f"{path}: {why}")
    with pytest.raises(ResultError, match=r"none\.json: no result of the thing"):
        read_json_result(ResultWithNestedResultAndArrays, tmp_path / "none.json", "thing")
