"""Sentences of studies with few falls, earthquakes or predictions say no more than their numbers."""

import json
from typing import Any

import pytest

from overturning.findings.causes import LogisticCoefficient
from overturning.findings.collect import Findings
from overturning.report.render import LANGUAGES, render_template_as_markdown
from tests.report.by_hand import STUDY_MINUS_VARIANT_FALL_RATE_FINDINGS, estimate_entry, handwritten_findings_of_study
from tests.report.test_templates import report_text, report_text_of_handwritten_findings


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_survey_without_predicted_falls_is_not_called_worse_than_random(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("survey").model_dump_json())
    fits = {"en": ("random directions do", "Does the prediction fit?"), "ja": ("無作為な方向よりも", "予測は合うか")}[
        language
    ]
    text = report_text_of_handwritten_findings("survey", language)
    assert all(words in text for words in fits)
    data["surveys"][0]["falls_with_predicted_direction"] = 0
    text = report_text(Findings.model_validate(data), language)
    assert {"en": "predicts no direction", "ja": "方向は予測されない"}[language] in text
    assert not any(words in text for words in fits)


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_says_if_axes_differ_or_falls_are_only_partly_along_one_line(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    group = data["direction"]["groups"][0]
    differs = {"en": "differs from earthquake to earthquake", "ja": "地震ごとに異なる"}[language]
    partly = {"en": "fall only partly along one line", "ja": "一部のみが一つの軸に沿って"}[language]
    assert differs in report_text_of_handwritten_findings("direction", language)
    group["mean_axis_resultant_length_within_records"]["value"] = 0.14
    for with_axis, near_normal in ((1, 1), (3, 3), (3, 0)):
        group |= {"earthquakes_with_axis": with_axis, "fall_axes_within_45_deg_of_fault_normal": near_normal}
        text = report_text(Findings.model_validate(data), language)
        assert partly in text
        assert differs not in text
    group |= {"earthquakes_with_axis": 0, "fall_axes_within_45_deg_of_fault_normal": 0}
    assert partly not in report_text(Findings.model_validate(data), language)


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_calls_earthquakes_too_few_if_alignments_have_no_interval(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("reference").model_dump_json())
    few = {"en": "Too few earthquakes to say whether free stones", "ja": "地震の数が少なく、墓石がどの基準方向"}[
        language
    ]
    assert few not in report_text_of_handwritten_findings("reference", language)
    data["reference_alignments"][0]["alignment_with_best_reference_axis"] |= {"low": None, "high": None}
    assert few in report_text(Findings.model_validate(data), language)


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("study", ["direction", "no fault normal"])
def test_headline_states_the_primary_statistic_of_the_study(study: str, language: str) -> None:
    data = json.loads(handwritten_findings_of_study(study).model_dump_json())
    data["population"]["median_fall_rate"], data["cases"]["share_overturned"] = 0.37, 0.52
    data["published_agreement"] = [
        {
            "variant": "nominal",
            "blocks": 12,
            "fully_agreeing_block_count": 9,
            "heights_agreeing_at_some_friction_m": [0.4],
        }
    ]
    for statistic, words in (("share", "52 %"), ("fall_rate", "37 %"), ("published", "9")):
        data["study"]["primary_statistic"] = statistic
        headline = report_text(Findings.model_validate(data), language).splitlines()[2]
        assert words in headline.replace("\N{NO-BREAK SPACE}", " ")


def headline_and_text_of_comparison_report(study: str, language: str, **contrast: Any) -> tuple[str, str]:
    """Return headline and text of a report on handwritten findings; ``contrast`` replaces entries of its comparison."""
    data = json.loads(handwritten_findings_of_study(study).model_dump_json())
    data["study"]["primary_statistic"] = contrast.pop("primary_statistic", "share")
    data["contrasts"][0] |= contrast
    text = report_text(Findings.model_validate(data), language).replace("\N{NO-BREAK SPACE}", " ")
    return text.splitlines()[2], text


SMALL_OVERTURNED_SHARES = {
    "share_overturned_in_study": estimate_entry(0.046, 0.018, 0.074),
    "share_overturned_in_variant": estimate_entry(0.029, 0.008, 0.051),
}


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    ("difference", "words", "said"),
    [
        (
            estimate_entry(0.018, 0.006, 0.031),
            {"en": "More stones fall with", "ja": "転倒が多い"},
            ["4.6 %", "2.9 %"],
        ),
        (
            estimate_entry(-0.018, -0.031, -0.006),
            {"en": "Fewer stones fall with", "ja": "転倒が少ない"},
            ["4.6 %", "2.9 %"],
        ),
        (estimate_entry(0.018, -0.006, 0.031), {"en": "No clear difference", "ja": "明らかな差はない"}, ["1.8", "3.1"]),
        (
            estimate_entry(0.0, n=1),
            {"en": "(one earthquake, so no interval)", "ja": "一つの地震のため"},
            ["4.6 %", "2.9 %"],
        ),
        (estimate_entry(0.0, n=2), {"en": "(few earthquakes, so no interval)", "ja": "地震の数が少ない"}, ["4.6 %"]),
    ],
)
def test_headline_of_a_comparison_follows_from_its_interval(
    difference: dict[str, Any], words: dict[str, str], said: list[str], language: str
) -> None:
    headline, _ = headline_and_text_of_comparison_report(
        "vertical", language, primary_statistic_study_minus_variant=difference, **SMALL_OVERTURNED_SHARES
    )
    for one in (words[language], *said):
        assert one in headline


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("study", ["nothing falls", "vertical"])
def test_headline_that_no_stone_falls_is_limited_to_cases_with_an_outcome(study: str, language: str) -> None:
    """The headline does not speak for the cases without an outcome, which may be most of the study."""
    none = estimate_entry(0.0, 0.0, 0.26)
    data = json.loads(handwritten_findings_of_study(study).model_dump_json())
    for contrast in data["contrasts"]:
        contrast |= {"share_overturned_in_study": none, "share_overturned_in_variant": none}
    for missing in ({}, {"unstable": 7}):
        data["cases"]["cases_without_outcome_by_status"] = missing
        headline = report_text(Findings.model_validate(data), language).splitlines()[2]
        assert {"en": "No stone falls", "ja": "墓石は一つも転倒しない"}[language] in headline
        assert ({"en": "the cases with an outcome", "ja": "結果の得られたケース"}[language] in headline) is bool(
            missing
        )


@pytest.mark.parametrize("language", LANGUAGES)
def test_two_settings_without_falls_are_not_compared(language: str) -> None:
    none = estimate_entry(0.0, 0.0, 0.26)
    shares = dict.fromkeys(
        ("share_overturned_in_study", "share_overturned_in_variant", "share_overturned_in_both"), none
    )
    same = {
        "share_overturned_only_in_study": none,
        "share_overturned_only_in_variant": none,
        "primary_statistic_study_minus_variant": estimate_entry(0.0, 0.0, 0.0),
    }
    headline, text = headline_and_text_of_comparison_report("vertical", language, **shares, **same)
    assert {"en": "No stone falls, neither with vertical", "ja": "墓石は一つも転倒しない"}[language] in headline
    assert {"en": "No case falls in either setting", "ja": "どちらの条件でも転倒するケースがない"}[language] in text
    assert {"en": "the difference (", "ja": "上下動なしを引いた値"}[language] not in text


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("primary", [True, False])
def test_settings_are_not_compared_if_no_case_has_an_outcome_in_both(primary: bool, language: str) -> None:
    none = estimate_entry(0.0, n=0) | {"value": None}
    data = json.loads(handwritten_findings_of_study("vertical").model_dump_json())
    other = {name: none for name, value in data["contrasts"][0].items() if isinstance(value, dict)}
    data["contrasts"].append(
        data["contrasts"][0] | other | {"share_over_45_deg_apart_if_both_fall": None, "is_primary_comparison": False}
    )
    if primary:
        data["contrasts"] = [data["contrasts"][1] | {"is_primary_comparison": True}]
    text = report_text(Findings.model_validate(data), language)
    headline = {"en": "No case has an outcome in both settings", "ja": "両方の条件で結果が得られたケースがない"}[
        language
    ]
    assert (headline in text) is primary
    assert (
        {"en": "no case has an outcome in both.", "ja": "両方で結果が得られたケースはない。"}[language] in text
    ) is not primary
    assert {"en": "– of the cases", "ja": "全ケースの –"}[language] not in text


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(("elements", "same_time"), [(1, 0.0), (3, 0.0), (1, 1.0)])
def test_report_states_simultaneous_falls_and_order_of_elements_where_they_exist(
    elements: int, same_time: float, language: str
) -> None:
    data = json.loads(handwritten_findings_of_study("scene").model_dump_json())
    data["study_counts"]["free_elements"] = elements
    data["element_outcomes"][0] |= {
        "variant": "nominal",
        "element": data["study_counts"]["reported_element"],
        "share_of_falls_with_no_earlier_fall": 0.97,
    }
    data["contrasts"][0]["share_falling_simultaneously_if_both_fall"] = estimate_entry(same_time)
    text = report_text(Findings.model_validate(data), language)
    assert ({"en": "counts half", "ja": "半分と数える"}[language] in text) is (same_time > 0)
    order = {"en": "Within it the shaft falls before", "ja": "ではほかの石より先に"}[language]
    assert (order in text) is (elements > 1)


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    ("settings", "named"),
    [
        (["vertical"], {"en": ["with vertical motion"], "ja": ["上下動あり"]}),
        (["contact"], {"en": ["contact of the variant “other”"], "ja": ["条件「other」の接触条件"]}),
        (["contact", "vertical"], {"en": ["vertical motion", "with the contact"], "ja": ["上下動あり", "接触条件"]}),
        (["scene", "vertical"], {"en": ["vertical motion", "monolith scene"], "ja": ["上下動あり", "「一体の墓石」"]}),
    ],
)
def test_report_names_every_setting_that_differs_between_the_variants(
    settings: list[str], named: dict[str, list[str]], language: str
) -> None:
    """The study asks about vertical motion, and its primary statistic is a fall rate."""
    rates = STUDY_MINUS_VARIANT_FALL_RATE_FINDINGS | {"differing_settings": settings, "primary_statistic": "fall_rate"}
    headline, text = headline_and_text_of_comparison_report("vertical", language, **rates)
    for one in named[language]:
        assert one in headline
    assert {"en": "Fewer stones fall", "ja": "墓石が少ない"}[language] in headline
    soil = {"en": ("soft ground", "unless the ground is known"), "ja": ("軟弱地盤", "地盤が分からなければ")}[language]
    assert not any(one in text for one in soil)
    several = {"en": "no difference between them can be credited", "ja": "いずれか一つによるものとはいえない"}[language]
    assert (several in text) is (len(settings) > 1)


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    ("every", "share", "said"),
    [
        (
            False,
            0.47,
            {"en": "near a change of outcome (47 % of all) was", "ja": "境界付近のケース(全体の 47 %)は"},
        ),
        (True, 1.0, {"en": "Each case was run", "ja": "すべてのケースは、"}),
        (
            True,
            0.75,
            {
                "en": "Each case whose runs have an outcome (75 % of all) was",
                "ja": "計算結果のあるすべてのケース(全体の 75 %)は",
            },
        ),
        (False, 1.0, {"en": "Each case near a change of outcome was", "ja": "境界付近のケースは、"}),
    ],
)
def test_report_states_whether_all_cases_or_only_borderline_ones_were_rerun(
    every: bool, share: float, said: dict[str, str], language: str
) -> None:
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    data["ensemble"] |= {"repeats_every_cell": every, "share_of_cells_repeated": share}
    text = report_text(Findings.model_validate(data), language).replace("\N{NO-BREAK SPACE}", " ")
    assert said[language] in text


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("study", ["direction", "reference"])
def test_report_states_that_disagreement_shares_are_those_of_8_runs(study: str, language: str) -> None:
    """Both shares hold for the first 8 of up to 24 runs; in 3-D the second is of the cases in which all runs fall."""
    (line,) = (
        one
        for one in report_text_of_handwritten_findings(study, language).splitlines()
        if "47\N{NO-BREAK SPACE}%" in one
    )
    spaces = line.replace("\N{NO-BREAK SPACE}", " ")
    first = {"en": "Of 8 such runs some fall and others stand in 16 %", "ja": "16 % のケースでは、8 回の計算で"}
    planes = {"en": "In 26 % most of 8 runs fall", "ja": "26 % のケースでは、8 回の大部分で"}
    space = {"en": "Where all runs of a case fall", "ja": "すべての計算で転倒するケースのうち 26 %"}
    assert first[language] in spaces
    assert (planes if study == "direction" else space)[language] in spaces


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    ("note", "fitted", "words"),
    [
        ("", True, {"en": "from chance: the interval of each coefficient", "ja": "どの回帰係数の信頼区間も 0 を含む"}),
        (
            "no interval: fewer than 8 earthquakes",
            True,
            {"en": "from chance (no interval: fewer", "ja": "偶然と区別できない（"},
        ),
        ("no fit: everything falls", False, {"en": "cannot be told: everything falls", "ja": "すべて転倒する"}),
    ],
)
def test_report_states_no_effect_of_predictors_that_may_be_chance(
    note: str, fitted: bool, words: dict[str, str], language: str
) -> None:
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    even = {"en": "even chance of falling", "ja": "転倒確率 50 % の墓石"}[language]
    assert even in report_text_of_handwritten_findings("direction", language)
    row = {"predictor": "ln B/H", "value": 1.2, "low": None, "high": None, "data_minimum": 0.1, "data_maximum": 0.6,
           "odds_factor_per_doubling": 2.3, "odds_factor_per_doubling_low": None,
           "odds_factor_per_doubling_high": None}  # fmt: skip
    data["logistic_fit"] |= {
        "fall_probabilities_after_doubling": [],
        "coefficients": [row] if fitted else [],
        "reason_for_missing_fit_or_interval": note,
        "earthquake_count": 1,
    }
    found = Findings.model_validate(data)
    text, page = (
        report_text(found, language),
        render_template_as_markdown(found, language),
    )  # the page with titles of tables
    assert even not in text
    assert words[language] in text
    jackknife = {"en": "of 1 earthquake; intervals by leaving out", "ja": "ジャックナイフ法"}[language]
    assert (jackknife in page) == (fitted and not note)


CONCLUSION_PHRASES_BY_LANGUAGE = {
    "en": ("two dimensions are enough", "of the borderline cases", "set up to test the fault normal",
           "with the fault normal it", "largest alignment was not predicted", "it is –"),
    "ja": ("二次元モデルは転倒の有無には十分", "転倒の境界付近では", "事前に定めた問い", "断層直交方向との一致度は",
           "事後に見いだした", "一致度は –"),
}  # fmt: skip


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    ("planar", "reference", "shown"),
    [
        ({}, {}, [True, True, True, True, True]),
        ({"same_fall_edge_share": 1.0, "same_outcome_share": 1.0}, {}, [False, True, True, True, True]),
        (
            {"same_outcome_share_if_b_over_h_neighbour_differs": None, "same_fall_edge_share": None},
            {},
            [False, False, True, True, True],
        ),
        ({}, {"alignment_with_fault_normal": estimate_entry(None, n=0)}, [True, True, False, False, True]),
        ({}, {"alignment_with_fault_normal": None}, [True, True, False, False, True]),
        ({}, {"best_aligned_references": ["fault normal", "pulse"]}, [True, True, False, False, False]),
    ],
)
def test_conclusions_about_reference_directions_follow_from_their_numbers(
    planar: dict[str, Any], reference: dict[str, Any], shown: list[bool], language: str
) -> None:
    data = json.loads(handwritten_findings_of_study("reference").model_dump_json())
    data["planar_model_agreement"] |= planar
    data["reference_alignments"] = [data["reference_alignments"][0] | reference]
    text = report_text(Findings.model_validate(data), language)
    *sentences, missing = CONCLUSION_PHRASES_BY_LANGUAGE[language]
    assert [one in text for one in sentences] == shown
    assert missing not in text


NO_VALUE = {"value": None, "low": None, "high": None}
INTERCEPT_COEFFICIENT = dict.fromkeys(LogisticCoefficient.model_fields) | {"predictor": "intercept", "value": -1.8}
NO_INTERVAL = {"low": None, "high": None}
KEY_PATH_OF_FRAGILITY_CURVE = ("population", "fragility_curves", 0)


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    ("study", "changes", "gone", "shown"),
    [
        (
            "direction",
            {("direction", "groups", 1, "mean_cos_2_angle_to_fault_normal"): NO_VALUE | {"earthquake_count": 0}},
            {"en": "without one –", "ja": "含まない記録で –"},
            {
                "en": "without one no record has both falls and a known fault normal.",
                "ja": "含まない記録では求められない",
            },
        ),
        (
            "direction",
            {
                ("direction", "groups", 0, "mean_cos_2_angle_to_fault_normal"): NO_INTERVAL,
                ("direction", "groups", 1, "mean_cos_2_angle_to_fault_normal"): NO_INTERVAL,
            },
            {"en": "over earthquakes with its 95 % interval", "ja": "平均値とその 95 % 信頼区間"},
            {"en": "over earthquakes; too few earthquakes", "ja": "平均値。地震の数が少ない"},
        ),
        (
            "reference",
            {("reference_alignments", 0, "alignment_with_best_reference_axis"): NO_INTERVAL},
            {"en": "mean over earthquakes with its 95 %", "ja": "地震についての平均値と 95 %"},
            {"en": "mean over earthquakes, too few of them", "ja": "平均値(地震の数が少ない"},
        ),
        (
            "direction",
            {("criteria_scores", "scores", 1, "skill"): NO_VALUE},
            {"en": "already scores", "ja": "スキルは –"},
            {"en": "Among blocks of one size", "ja": "同じ寸法のブロック"},
        ),
        (
            "direction",
            {("convergence", "result"): {"rerun_case_count": 1, "wanted_case_count": 1}},
            {"en": "(1 cases", "ja": "(1 cases"},
            {"en": "(1 case, drawn", "ja": "(1 ケース"},
        ),
        (
            "survey",
            {("published_agreement", 0): {"blocks": 1, "fully_agreeing_block_count": 0}},
            {"en": "0 of 1 blocks", "ja": "1 blocks"},
            {"en": "0 of 1 block ", "ja": "1 ブロックのうち 0"},
        ),
        (
            "direction",
            {("direction", "groups", 0): {"no_common_axis_p_value": 0.0002}},
            {"en": "p = <", "ja": "p = <"},
            {"en": "(p < 0.001)", "ja": "(p < 0.001)"},
        ),
        (
            "survey",
            {("inferred_motions", 0): {"any_motion_fits": False, "fit_p_value": 0.0002}},
            {"en": "p = <", "ja": "p = <"},
            {"en": "p < 0.001)", "ja": "p < 0.001)"},
        ),
        (
            "direction",
            {KEY_PATH_OF_FRAGILITY_CURVE: NO_INTERVAL},
            {"en": "95 % band", "ja": "95 % 信頼帯"},
            {"en": "Line: lognormal fragility curve", "ja": "フラジリティ曲線"},
        ),
        (
            "direction",
            {("population",): {"fragility_curves": []}},
            {"en": "fragility curve", "ja": "フラジリティ曲線"},
            {
                "en": "a point for each record and factor.",
                "ja": "点は各記録と各倍率、最大速度は全方位についての中央値(RotD50)。",
            },
        ),
        (
            "direction",
            {(): {"ensemble": None}},
            {"en": "runs", "ja": "条件を変えた計算"},
            {"en": "The black line encloses the falls.", "ja": "黒線は転倒する範囲を囲む。"},
        ),
        (
            "direction",
            {("convergence", "comparisons", 0, "fall_side_changes"): {"changed_count": 0, "value": 0.0}},
            {"en": "0.0 % of the falls", "ja": "転倒のうち 0.0 %"},
            {"en": "0.8 % of the outcomes change between", "ja": "結果のうち 0.8 % は転倒と非転倒が"},
        ),
        (
            "direction",
            {
                ("convergence", "comparisons", 0): {
                    "more_exact_computation_kind": "rigid",
                    "step_count_or_stiffness_factor": None,
                }
            },
            {"en": "exact rigid block |", "ja": "剛体の厳密解 |"},
            {"en": "exact rigid block (400 cases) |", "ja": "剛体の厳密解(400 ケース) |"},
        ),
        (
            "direction",
            {("logistic_fit",): {"earthquake_count": 1, "coefficients": [INTERCEPT_COEFFICIENT]}},
            {"en": "1 earthquakes", "ja": "1 earthquake"},
            {"en": "of 1 earthquake;", "ja": "(1 地震、"},
        ),
        (
            "vertical",
            {},
            {"en": "cover other", "ja": "ほかの地震には及ばない"},
            {"en": "not a random sample.", "ja": "無作為抽出ではない。"},
        ),
        (
            "direction",
            {("study_counts",): {"other_amplitude_factor_count": 2}},
            {"en": "66,528 were computed and the others follow by symmetry.", "ja": "(残りは対称性による)。一つ"},
            {"en": "cases under the records as they are; 66,528", "ja": "ほかの 2 通りの倍率"},
        ),
        (
            "uneven planes",
            {},
            {"en": "in steps of 20°;", "ja": "記録は 20° 刻み"},
            {"en": "in steps of 20° from 60° to 100°;", "ja": "60° から 100° まで 20° 刻み"},
        ),
        (
            "unknown outcomes",
            {},
            {"en": "no fault normal is known", "ja": "断層直交方向は不明"},
            {
                "en": "Under vale, ford the unknown outcomes are spread unevenly",
                "ja": "vale、ford では結果の得られなかったケースの方位が偏って",
            },
        ),
        (
            "no fault normal",
            {
                ("study_counts",): {
                    "azimuth_or_orientation_step_deg": None,
                    "smallest_azimuth_or_orientation_deg": 32.0,
                },
                ("study",): {"azimuth_or_orientation_count": 1},
            },
            {"en": "1 azimuth", "ja": "1 通りの方位"},
            {"en": "turned to the azimuth 32°;", "ja": "記録は方位 32° の成分"},
        ),
    ],
)
def test_sentences_of_small_studies_mention_only_numbers_that_exist(
    study: str,
    changes: dict[tuple[str | int, ...], dict[str, Any]],
    gone: dict[str, str],
    shown: dict[str, str],
    language: str,
) -> None:
    data = json.loads(handwritten_findings_of_study(study).model_dump_json())
    for path, values in changes.items():
        part: Any = data
        for key in path:
            part = part[key]
        part |= values
    found = Findings.model_validate(data)  # captions of tables are in the Markdown only
    text = (report_text(found, language) + render_template_as_markdown(found, language)).replace(
        "\N{NO-BREAK SPACE}", " "
    )
    assert gone[language] not in text
    assert shown[language] in text


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(("cases", "angle"), [(0, None), (120, None), (120, 14.0)])
def test_2d_and_3d_fall_axes_are_compared_only_if_blocks_fall_in_both_models(
    cases: int, angle: float | None, language: str
) -> None:
    data = json.loads(handwritten_findings_of_study("reference").model_dump_json())
    data["planar_model_agreement"] |= {
        "compared_case_count": cases,
        "mean_angle_between_fall_axes_deg": angle,
        "only_3d_overturns_share": 0.0,
    }
    text = report_text(Findings.model_validate(data), language)
    alone, apart = {"en": ("in a plane alone", "apart on average"), "ja": ("は二次元でのみ", "転倒軸の差は平均")}[
        language
    ]
    assert [alone in text, apart in text] == [cases > 0, angle is not None]


@pytest.mark.parametrize("language", LANGUAGES)
def test_headline_of_a_survey_study_without_outcomes_states_their_absence(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("survey").model_dump_json())
    data["surveys"], data["published_agreement"] = [], []
    data["cases"]["share_overturned"] = None
    text = report_text(Findings.model_validate(data), language)
    assert text.splitlines()[2] == {"en": "No outcome was found", "ja": "結果が得られなかった"}[language]
