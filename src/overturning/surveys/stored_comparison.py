"""Comparison of a survey with a study, as stored beside the results."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from overturning.stored import (
    read_json_result,
)
from overturning.surveys.comparison import SurveyPredictionComparison
from overturning.surveys.field_table import read_text_table
from overturning.surveys.ground import SoilBelowSurveySite
from overturning.surveys.template import remarks_without_template_text


@dataclass(frozen=True)
class StoredSurveyComparison:
    """Content of a result file: comparison of a survey with a prediction, and the names of survey file and record.

    ``survey_file_name`` and ``sha256`` are name and hash of the survey file; ``record`` is the record of the site.

    ``survey_warnings`` are the warnings of `overturning.surveys.stones.SurveyTable`; ``survey_file_comments`` are the
    comment lines that the user wrote at the start of the survey file. ``comparisons_by_site`` are pairs of a site's
    name and the comparison for its stones only; none if the survey has one site. ``soil_by_site`` are pairs of a site's
    name ("" for all sites not named) and its soil layers; none if the record is used unchanged at all sites.
    """

    survey_file_name: str
    sha256: str
    record: str
    comparison: SurveyPredictionComparison
    survey_warnings: tuple[str, ...] = ()
    survey_file_comments: tuple[str, ...] = ()
    comparisons_by_site: tuple[tuple[str, SurveyPredictionComparison], ...] = ()
    soil_by_site: tuple[tuple[str, SoilBelowSurveySite], ...] = ()


def make_stored_survey_comparison(
    survey_path: Path,
    record_id: str,
    whole_survey_comparison: SurveyPredictionComparison,
    azimuth_unit_warnings: Sequence[str] = (),
    comparison_by_site: Mapping[str, SurveyPredictionComparison] | None = None,
    soil_by_site: Mapping[str, SoilBelowSurveySite] | None = None,
) -> StoredSurveyComparison:
    """Add the survey file's name and hash, record id and warnings to the comparison of a survey with a prediction."""
    sha256, remarks = survey_file_hash_and_user_comments(survey_path)
    sites = tuple((comparison_by_site or {}).items())
    return StoredSurveyComparison(
        survey_path.name,
        sha256,
        record_id,
        whole_survey_comparison,
        tuple(azimuth_unit_warnings),
        remarks,
        sites,
        tuple((soil_by_site or {}).items()),
    )


def survey_file_hash_and_user_comments(survey_path: Path) -> tuple[str, tuple[str, ...]]:
    """Return the SHA-256 hash of a survey file, and the comment lines that the user wrote at its start."""
    sha256 = hashlib.sha256(survey_path.read_bytes()).hexdigest()
    return sha256, remarks_without_template_text(read_text_table(survey_path, "survey").leading_comments)


def read_survey_comparison(path: Path) -> StoredSurveyComparison:
    """Read the stored comparison of a survey with a prediction; a `ResultError` if missing or from another version."""
    return read_json_result(StoredSurveyComparison, path, "comparison with a survey")
