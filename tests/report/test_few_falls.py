"""Sentences of studies with few falls, earthquakes or predictions say no more than their numbers."""

import json

import pytest

from overturning.findings.collect import Findings
from overturning.report.render import LANGUAGES
from tests.report.by_hand import findings_by_hand
from tests.report.test_templates import text_by_hand, text_of


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_survey_without_predicted_falls_is_not_called_worse_than_random(language: str) -> None:
    data = json.loads(findings_by_hand("survey").model_dump_json())
    fits = {"en": ("random directions do", "Does the prediction fit?"), "ja": ("無作為な方向よりも", "予測は合うか")}[
        language
    ]
    text = text_by_hand("survey", language)
    assert all(words in text for words in fits)
    data["surveys"][0]["never"] = data["surveys"][0]["octant_falls"]
    text = text_of(Findings.model_validate(data), language)
    assert {"en": "predicts no direction", "ja": "方向は予測されない"}[language] in text
    assert not any(words in text for words in fits)


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_common_line_is_stated_only_as_far_as_the_falls_agree(language: str) -> None:
    data = json.loads(findings_by_hand("direction").model_dump_json())
    group = data["direction"]["groups"][0]
    differs = {"en": "differs from earthquake to earthquake", "ja": "地震ごとに異なる"}[language]
    partly = {"en": "fall only partly along one line", "ja": "一部のみが一つの軸に沿って"}[language]
    assert differs in text_by_hand("direction", language)
    group["axis_resultant_within_record"]["value"] = 0.14
    for with_axis, near_normal in ((1, 1), (3, 3), (3, 0)):
        group |= {"earthquakes_with_axis": with_axis, "axes_within_45_of_normal": near_normal}
        text = text_of(Findings.model_validate(data), language)
        assert partly in text
        assert differs not in text
    group |= {"earthquakes_with_axis": 0, "axes_within_45_of_normal": 0}
    assert partly not in text_of(Findings.model_validate(data), language)


@pytest.mark.parametrize("language", LANGUAGES)
def test_reference_directions_without_an_interval_have_too_few_earthquakes(language: str) -> None:
    data = json.loads(findings_by_hand("reference").model_dump_json())
    few = {"en": "Too few earthquakes to say whether free stones", "ja": "地震の数が少なく、墓石がどの基準方向"}[
        language
    ]
    assert few not in text_by_hand("reference", language)
    data["reference_alignments"][0]["closest_alignment"] |= {"low": None, "high": None}
    assert few in text_of(Findings.model_validate(data), language)


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("study", ["direction", "no fault normal"])
def test_the_headline_has_the_statistic_that_the_study_chose(study: str, language: str) -> None:
    data = json.loads(findings_by_hand(study).model_dump_json())
    data["population"]["median_fall_rate"], data["cases"]["share_overturned"] = 0.37, 0.52
    data["published_agreement"] = [
        {"variant": "nominal", "blocks": 12, "blocks_that_agree": 9, "heights_that_agree_m": [0.4]}
    ]
    for statistic, words in (("share", "52 %"), ("fall_rate", "37 %"), ("published", "9")):
        data["study"]["primary_statistic"] = statistic
        headline = text_of(Findings.model_validate(data), language).splitlines()[2]
        assert words in headline.replace("\N{NO-BREAK SPACE}", " ")
