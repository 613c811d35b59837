"""Sentences of the report about a single stone, case or record, or about few of them."""

import json
import re
from typing import Any

import pytest
from pydantic import BaseModel

from overturning.findings.causes import LogisticCoefficient
from overturning.findings.collect import Findings
from overturning.findings.lines import finding_text_lines
from overturning.findings.standing import StoneSurvivalUnderHazardFindings
from overturning.findings.survey_commands import ResultsPrintedBySurveyCommands
from overturning.findings.values import Estimate
from overturning.report.render import LANGUAGES
from overturning.statistics.criteria import SLENDERNESS_ONLY_RULE_NAME
from tests.report.by_hand import (
    INFERRED_MOTION,
    OBSERVED_SURVEY_FINDINGS,
    STUDY_FINDINGS,
    SURVEY_COMPARISON,
    SURVEY_DISPLACEMENTS,
    handwritten_findings_of_study,
)
from tests.report.test_templates import report_text

KEYS_OF_COUNTS_ABOVE_ONE = ("runs_per_cell_in_first_batch", "fewest_runs_per_cell", "most_runs_per_cell")
"""Counts of findings that are at least 2: runs of an ensemble."""

COUNTED_NOUNS = "stone|case|cell|record|range|interval|earthquake|motion|fall|block|stack|orientation|height|azimuth"

PLURAL_AFTER_ONE = re.compile(
    rf"(?<![\d.,−])1 (?:(?:of 1 )?(?:{COUNTED_NOUNS})s\b"  # 1 records; 1 of 1 cases
    rf"|(?:of [12] )?(?:(?:{COUNTED_NOUNS})s? )?(?:without (?:a height|B/H) )?"
    r"(?:are|were|have|stand|do|exclude)\b"
    r"|[^.;|\n]* and are\b)"
)
"""The number 1 with a noun or a verb in the plural."""


def copy_with_whole_numbers_set_to_1(part: Any, key: str = "") -> Any:
    """Return a copy of findings in which every whole number, but for `KEYS_OF_COUNTS_ABOVE_ONE`, is 1."""
    if isinstance(part, dict):
        return {name: copy_with_whole_numbers_set_to_1(value, name) for name, value in part.items()}
    if isinstance(part, list):
        return [copy_with_whole_numbers_set_to_1(value) for value in part]
    return 1 if isinstance(part, int) and not isinstance(part, bool) and key not in KEYS_OF_COUNTS_ABOVE_ONE else part


SURVIVAL_FINDINGS_OF_ONE_STONE = {
    "exposure_time_years": 800.0, "classes_without_fragility_curve": [], "survival_of_stone_classes": [],
    "hazard_unit_warnings": [],
    "survey_stone_counts": {"stood": 1, "fell": 0, "total": 1, "fall_rate_upper_bound_per_year": 0.0037,
    "confidence_of_fall_rate_bound": 0.95,
               "standing_share": 1.0, "standing_share_low": 0.05, "standing_share_high": 1.0},
}  # fmt: skip
SURVIVAL_FINDINGS_IF_ONE_OF_TWO_STONES_FELL = SURVIVAL_FINDINGS_OF_ONE_STONE | {
    "survey_stone_counts": SURVIVAL_FINDINGS_OF_ONE_STONE["survey_stone_counts"]
    | {"fell": 1, "total": 2, "fall_rate_upper_bound_per_year": None, "standing_share": 0.5}  # type: ignore[operator]
}


def findings_with_counts_of_one() -> list[tuple[str, str, BaseModel]]:
    """Return (name, template, findings) for each kind of study and for each command, with all counts set to 1."""
    studies = [
        (
            name,
            "report",
            Findings.model_validate(
                copy_with_whole_numbers_set_to_1(json.loads(handwritten_findings_of_study(name).model_dump_json()))
            ),
        )
        for name in STUDY_FINDINGS
    ]
    commands = {
        "survey": {"surveys": [SURVEY_COMPARISON]},
        "survey_summary": {"observed_surveys": [OBSERVED_SURVEY_FINDINGS]},
        "displacements": {"survey_displacements": [SURVEY_DISPLACEMENTS]},
        "motions": {"inferred_motions": [INFERRED_MOTION]},
    }
    return [
        *studies,
        *(
            (name, name, ResultsPrintedBySurveyCommands.model_validate(copy_with_whole_numbers_set_to_1(part)))
            for name, part in commands.items()
        ),
        *(
            ("stood", "stood", StoneSurvivalUnderHazardFindings.model_validate(one))
            for one in (SURVIVAL_FINDINGS_OF_ONE_STONE, SURVIVAL_FINDINGS_IF_ONE_OF_TWO_STONES_FELL)
        ),
    ]


@pytest.mark.parametrize(
    ("template", "found"), [pytest.param(*one[1:], id=one[0]) for one in findings_with_counts_of_one()]
)
def test_count_of_one_is_printed_in_the_singular(template: str, found: BaseModel) -> None:
    text = report_text(found, "en", template)
    assert re.search(r"\b1 ", text)
    assert [match.group() for match in PLURAL_AFTER_ONE.finditer(text)] == []
    assert "their rate" not in text
    assert "share their earthquakes" not in text


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    ("study", "part", "few", "many", "words"),
    [  # a number of each list belongs to one sentence or the other
        ("direction", "study_counts", {"records": 1}, {"records": 2},
         {"en": ["Under the record as it is, the fall rate is", "the median fall rate is"],
          "ja": ["、転倒率は ", "、転倒率の中央値は"]}),
        ("reference", "twist_of_moved_standing_stones", {"moved_standing_stone_count": 9},
        {"moved_standing_stone_count": 10},
         {"en": ["The largest turn about the vertical is 88.0°", "nine tenths by at most 6.2°"],
          "ja": ["最大で 88.0°", "九割が 6.2° 以下"]}),
        ("reference", "study", {"azimuth_or_orientation_count": 1}, {"azimuth_or_orientation_count": 18},
         {"en": [", in 1 orientation", ", each in 18 orientations"], "ja": ["1 通りの向き", "18 通りの向き"]}),
        ("scene", "study_counts", {"free_elements": 1}, {"free_elements": 3},
         {"en": ["the azimuth that the scene faces", "the azimuth that the stack faces"],
          "ja": ["シーンの正面", "積石の正面"]}),
    ],
)  # fmt: skip
def test_wording_differs_for_few_and_many_records_stones_and_orientations(
    study: str, part: str, few: dict[str, int], many: dict[str, int], words: dict[str, list[str]], language: str
) -> None:
    for place, values in enumerate((few, many)):
        data = json.loads(handwritten_findings_of_study(study).model_dump_json())
        data[part] |= values
        text = report_text(Findings.model_validate(data), language).replace("\N{NO-BREAK SPACE}", " ")
        assert [one in text for one in words[language]] == [place == 0, place == 1]


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_prints_a_90th_percentile_twist_of_zero(language: str) -> None:
    """If nine tenths of the stones twist by 0.0°, the report prints this 0.0° and does not omit it.

    If all fallen stones slid off their base, the report does not speak of stones that tip.
    """
    data = json.loads(handwritten_findings_of_study("stack in 3-D").model_dump_json())
    for one in data["element_displacements"]:
        one |= {"percentile_90_abs_twist_if_standing_deg": 0.0, "share_of_falls_by_sliding_off": 1.0}
    text = report_text(Findings.model_validate(data), language)
    assert {"en": "by at most 0.0° in nine tenths", "ja": "九割のケースで 0.0° 以下"}[language] in text
    assert {"en": "otherwise it tips", "ja": "残りは傾いて"}[language] not in text


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("slope", [1.2, None])
def test_figure_caption_mentions_the_regression_only_if_it_is_drawn(slope: float | None, language: str) -> None:
    """The figure caption mentions the logistic regression only if it has a coefficient for PGV/PGA.

    If PGV/PGA is the same for all motions, it has none and the figure shows no line.
    """
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    row = dict.fromkeys(LogisticCoefficient.model_fields) | {"predictor": "ln PGV/PGA", "value": slope}
    data["logistic_fit"]["coefficients"] = [row, row | {"predictor": "ln B/H", "value": 1.0}]
    text = report_text(Findings.model_validate(data), language)
    assert ({"en": "and the fit to this study", "ja": "本計算への回帰"}[language] in text) is (slope is not None)


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("several", [True, False])
def test_report_omits_the_slenderness_only_criterion_for_a_single_b_over_h(several: bool, language: str) -> None:
    """The report omits the criterion of slenderness alone if the list of scores does not end with it.

    With a single B/H, slenderness alone cannot separate falls from stands.
    """
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    scores = data["criteria_scores"]["scores"]
    names = [one["criterion"] for one in scores]
    assert names[-1] == SLENDERNESS_ONLY_RULE_NAME
    data["criteria_scores"]["scores"] = scores if several else scores[:-1]
    text = report_text(Findings.model_validate(data), language)
    assert ({"en": "Guessing by slenderness alone", "ja": "幅高さ比だけによる判定"}[language] in text) is several


class FindingsWithSingleEstimate(BaseModel):
    """Findings that consist of a single estimate."""

    alignment: Estimate


@pytest.mark.parametrize(
    ("value", "earthquakes", "shown"),
    [(None, 1, "not defined; 1 earthquake"), (None, 2, "not defined; 2 earthquakes"), (0.5, 1, "0.5; 1 earthquake,")],
)
def test_printed_findings_write_one_earthquake_in_the_singular(
    value: float | None, earthquakes: int, shown: str
) -> None:
    estimate = Estimate(statistic="by hand", value=value, low=None, high=None, earthquake_count=earthquakes)
    (line,) = finding_text_lines(FindingsWithSingleEstimate(alignment=estimate))
    assert f"{line},".startswith(f"alignment: {shown}")
