"""A survey's comparison as a file, so that the report can show it without working it out again."""

import hashlib
import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.statistics.circular import TestResult
from overturning.surveys.comparison import SurveyComparison

_TESTS = ("fit_octants", "fit_octants_watson", "fit_exact", "uniform_octants")
_ARRAYS = ("octant_observed", "octant_predicted", "confusion")


@dataclass(frozen=True)
class SurveyResult:
    """A comparison with the name of the survey's file, the hash of its bytes, and the id of the site's record."""

    stones: str
    sha256: str
    record: str
    comparison: SurveyComparison


def survey_result(stones: Path, record: str, comparison: SurveyComparison) -> SurveyResult:
    """A comparison with the name and hash of its survey's file."""
    return SurveyResult(stones.name, hashlib.sha256(stones.read_bytes()).hexdigest(), record, comparison)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return None if isinstance(value, float) and math.isnan(value) else value


def write_survey(result: SurveyResult, path: Path) -> None:
    """Write a comparison as JSON; numbers that are not known become null."""
    with atomic_write(path) as part:
        part.write_text(json.dumps(_plain(asdict(result)), ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


def _number(value: Any) -> Any:
    return math.nan if value is None else value


def read_survey_result(path: Path) -> SurveyResult:
    """Read a comparison that `write_survey` has written; `ResultError` if it is missing or of another version."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        comparison = data["comparison"]
        for name in _TESTS:
            comparison[name] = TestResult(**{key: _number(value) for key, value in comparison[name].items()})
        for name in _ARRAYS:
            comparison[name] = None if comparison[name] is None else np.array(comparison[name])
        known = {key: value if key == "confusion" else _number(value) for key, value in comparison.items()}
        return SurveyResult(data["stones"], data["sha256"], data["record"], SurveyComparison(**known))
    except OSError:
        raise ResultError(f"{path}: no such comparison; run the study again") from None
    except (KeyError, TypeError, ValueError) as error:
        raise ResultError(f"{path}: not a comparison of this version ({error}); run the study again") from None
