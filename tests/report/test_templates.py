"""Every number that the templates print is in the findings, and their sentences follow the findings."""

import json
import re
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel
from syrupy.assertion import SnapshotAssertion

from overturning.findings.collect import Findings
from overturning.findings.population import JMA_DEGREES_WITH_INTENSITY_RANGES
from overturning.findings.survey_commands import ResultsPrintedBySurveyCommands
from overturning.model.status import CaseStatus
from overturning.report.render import (
    LANGUAGES,
    ReportMedia,
    create_template_environment,
    parse_markdown_and_number_figures_and_tables,
    read_label_translations,
    render_template_as_markdown,
    translate_whole_text_by_table,
)
from overturning.report.terminal import plain_text_of_uncollapsed_paragraphs, terminal_lines_of_markdown
from overturning.statistics.criteria import SLENDERNESS_ONLY_RULE_NAME
from overturning.statistics.criteria_limits import OVERTURNING_CRITERIA
from overturning.statistics.falls import BLOCK_SELECTION_RULES_IN_REPORT
from overturning.translation.texts import translate
from tests.report.by_hand import (
    INFERRED_MOTION,
    OBSERVED_SURVEY_FINDINGS,
    REMARK,
    STUDY_FINDINGS,
    SURVEY_COMPARISON,
    SURVEY_DISPLACEMENTS,
    handwritten_findings_of_study,
)

NUMBERS_ALLOWED_IN_TEMPLATES = {"0", "1", "−1", "2", "15", "30", "45", "50", "95", "10", "180"}
"""Numbers of the templates themselves: ends of a scale, angles and levels that define a statistic."""

NUMBER_IN_TEXT = re.compile(r"(?<![\w.-])[−-]?\d+(?:[.,]\d+)*", re.ASCII)
"""Number of a text; letters of other scripts may stand next to it."""

BLOCK_SELECTION_RULE_NAMES = [
    one.description_template.format(word)
    for one in BLOCK_SELECTION_RULES_IN_REPORT
    for word in ("plane", "orientation")
]
CRITERION_NAMES = [*(one.name for one in OVERTURNING_CRITERIA), SLENDERNESS_ONLY_RULE_NAME]
STATUS_NAMES = [one.name.lower().replace("_", " ") for one in CaseStatus]


def numeric_values_of_findings(part: Any) -> Iterator[float]:
    """Yield every numeric value of findings; strings do not count."""
    if isinstance(part, dict):
        part = list(part.values())
    if isinstance(part, list):
        for one in part:
            yield from numeric_values_of_findings(one)
    elif isinstance(part, int | float) and not isinstance(part, bool):
        yield float(part)


def numbers_not_in_findings(printed: list[str], found: BaseModel) -> list[str]:
    """Return the printed numbers that, within rounding, equal neither a value of the findings nor 100 times one."""
    known = np.array(list(numeric_values_of_findings(found.model_dump(mode="json"))))
    known = np.concatenate([known, 100.0 * known])
    lost: list[str] = []
    for text in dict.fromkeys(one for one in printed if one not in NUMBERS_ALLOWED_IN_TEMPLATES):
        number = text.replace("−", "-").replace(",", "")
        # Two or three significant digits: the last printed digit is the last that counts.
        step = 10.0 ** -len(number.partition(".")[2])
        near = np.abs(float(number) - known) <= np.maximum(0.5000001 * step, 1e-9 * np.abs(known))
        lost += [] if near.any() else [text]
    return lost


NOTE_BLOCKS = re.compile(r"^::: note\n.*?^:::$", re.DOTALL | re.MULTILINE)
"""Container of the notes on records, whose texts with their numbers are texts of the findings."""


def report_text(found: Any, language: str, name: str = "report") -> str:
    """Render findings as the text that a reader sees, with figure captions and without notes on records."""
    return plain_report_text_without_record_notes(render_template_as_markdown(found, language, template_name=name))


def plain_report_text_without_record_notes(markdown: str) -> str:
    """Return the plain text of a Markdown report, with figure captions and without notes on records."""
    markdown = NOTE_BLOCKS.sub("", markdown)
    captions = re.findall(r"!\[(.*?)\]\(.*?\"(.*)\"\)", markdown)
    return "\n".join(
        [
            *terminal_lines_of_markdown(parse_markdown_and_number_figures_and_tables(markdown)),
            *(" ".join(pair) for pair in captions),
        ]
    )


@cache
def markdown_report_of_handwritten_findings(study: str, language: str) -> str:
    """Render the hand-written findings of one kind of study as a Markdown report."""
    return render_template_as_markdown(handwritten_findings_of_study(study), language)


@cache
def report_text_of_handwritten_findings(study: str, language: str) -> str:
    """Render the hand-written findings of one kind of study as the text that a reader sees."""
    return plain_report_text_without_record_notes(markdown_report_of_handwritten_findings(study, language))


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("study", STUDY_FINDINGS)
def test_every_printed_number_is_a_numeric_value_of_the_findings(study: str, language: str) -> None:
    found = handwritten_findings_of_study(study)
    printed = NUMBER_IN_TEXT.findall(report_text_of_handwritten_findings(study, language))
    assert len(printed) >= 20
    assert numbers_not_in_findings(printed, found) == []


def non_empty_strings_in_findings(part: Any) -> Iterator[str]:
    """Yield every non-empty string among the values of findings."""
    if isinstance(part, dict | list):
        for one in part.values() if isinstance(part, dict) else part:
            yield from non_empty_strings_in_findings(one)
    elif isinstance(part, str) and part:
        yield part


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("study", STUDY_FINDINGS)
def test_notes_on_records_print_all_texts_of_the_findings_unchanged(study: str, language: str) -> None:
    """Notes on records have numbers (in Japanese reports also English words) only in texts from the findings.

    These texts are printed unchanged.
    """
    found = handwritten_findings_of_study(study)
    parts = NOTE_BLOCKS.findall(markdown_report_of_handwritten_findings(study, language))
    items = [one for part in parts for one in re.findall("^- .*$", part, re.M)]
    shown = [
        line
        for item in items
        for line in terminal_lines_of_markdown(parse_markdown_and_number_figures_and_tables(item))
    ]
    for record in found.records:
        assert record.processing is not None
        given = record.processing
        drift, steps = translate(given.drift_evidence, language), [translate(step, language) for step in given.steps]
        own = [
            *non_empty_strings_in_findings(record.model_dump()),
            drift,
            *steps,
            "; ".join(given.user_declared_properties),
        ]
        for text in (given.first_sample_time, given.agency_processing, *steps, own[-1],
        *given.contradictions_trusted_by_user,
        *given.notes,
                     drift):  # fmt: skip
            assert [line for line in shown if line.startswith(record.id) and line.endswith(text)], text
        for line in (one for one in shown if one.startswith(record.id)):
            rest = line
            for text in sorted(own, key=len, reverse=True):
                rest = rest.replace(text, "")
            assert not NUMBER_IN_TEXT.search(rest), line
            assert language == "en" or not re.search("[A-Za-z]", rest), line
    assert len(shown) >= 8 * len(found.records)


@pytest.mark.parametrize("language", LANGUAGES)
def test_doubts_about_records_are_shown_outside_collapsed_sections(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    kinds = [one["doubt"] for one in data["record_notes"]["doubts"]]
    assert len(kinds) == 3
    data["records"] += [data["records"][0] | {"id": "weak", "too_weak_to_move_any_block": True}]

    def text_outside_collapsed_sections(data: Any) -> str:
        return "\n".join(
            plain_text_of_uncollapsed_paragraphs(
                parse_markdown_and_number_figures_and_tables(
                    render_template_as_markdown(Findings.model_validate(data), language)
                )
            )
        )

    labels, text = read_label_translations(language), text_outside_collapsed_sections(data)
    (line,) = (one for one in text.splitlines() if translate_whole_text_by_table(kinds[0], labels) in one)
    assert all(translate_whole_text_by_table(kind, labels) in line for kind in kinds)
    assert line.count("vale") == 3
    assert "weak" in text
    data["record_notes"]["doubts"][0] |= {"record_count": 40, "records": [f"station{number}" for number in range(40)]}
    assert "station5" in text_outside_collapsed_sections(data)
    assert "station6" not in text_outside_collapsed_sections(data)
    data["record_notes"] = {"record_count_with_notes_or_doubts": 0, "doubts": []}
    assert translate_whole_text_by_table(kinds[0], labels) not in text_outside_collapsed_sections(data)


@pytest.mark.parametrize("language", LANGUAGES)
def test_criterion_is_called_best_only_if_its_lead_is_significant(language: str) -> None:
    """Overturning criteria whose skill does not differ significantly are named in the order of the table.

    Their difference has a confidence interval that includes 0; none of them is then said to score highest.
    """
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    highest = {"en": "scores highest", "ja": "スキルが最も高い。"}[language]
    paragraphs = [
        one for one in report_text_of_handwritten_findings("direction", language).splitlines() if "−0.03" in one
    ]
    assert len(paragraphs) == 1
    assert highest not in paragraphs[0]
    names = [translate_whole_text_by_table(name, read_label_translations(language)) for name in ("West", "Ishiyama")]
    assert 0 < paragraphs[0].index(names[0]) < paragraphs[0].index(names[1])
    data["criteria_scores"] |= {"significantly_best_criterion": "West", "insignificant_differences_from_best_skill": []}
    assert highest in report_text(Findings.model_validate(data), language)


@pytest.mark.parametrize("language", LANGUAGES)
def test_reference_axis_is_called_closest_only_if_its_lead_is_significant(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("reference").model_dump_json())
    closest = {"en": "closest to the axis", "ja": "の軸に最も近く"}[language]
    assert report_text_of_handwritten_findings("reference", language).count(closest) == 2
    data["reference_alignments"][0]["best_minus_second_alignment"] |= {"value": 0.083, "low": -0.06, "high": 0.22}
    text = report_text(Findings.model_validate(data), language)
    assert text.count(closest) == 1
    assert {"en": "0.08 (−0.06 to 0.22)", "ja": "0.08 (−0.06～0.22)"}[language] in text


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_says_if_a_reference_direction_is_known_for_one_earthquake(language: str) -> None:
    """Alignment with a reference direction known for few earthquakes is stated separately, with their number."""
    said = {
        "en": "which is known for 1 earthquake only, it is 0.82",
        "ja": "断層直交方向(既知は 1 地震のみ)との一致度は 0.82",
    }
    data = handwritten_findings_of_study("reference").model_dump()
    data["reference_alignments"][0]["alignment_with_fault_normal"] |= {
        "value": 0.82,
        "low": None,
        "high": None,
        "earthquake_count": 1,
    }
    text = report_text(Findings.model_validate(data), language)
    assert said[language] in re.sub(r"\s+", " ", text)
    assert said[language].split(" 1 ")[0] not in re.sub(
        r"\s+", " ", report_text_of_handwritten_findings("reference", language)
    )


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_omits_the_twist_of_stones_that_never_stand(language: str) -> None:
    twisted = {"en": "it has twisted by", "ja": "の回転は、九割の"}[language]
    name = next(name for name in STUDY_FINDINGS if handwritten_findings_of_study(name).element_displacements)
    data = handwritten_findings_of_study(name).model_dump()
    for one, left in ((1, 1), (0, 0)):
        data["element_displacements"][one]["percentile_90_abs_twist_if_standing_deg"] = None
        text = report_text(Findings.model_validate(data), language)
        assert "–°" not in text
        assert text.count(twisted) == left, text
    assert report_text_of_handwritten_findings(name, language).count(twisted) == 1


@pytest.mark.parametrize(("model", "said"), [("planes", "to the other side"), ("space", "more than 45° apart")])
def test_headline_says_more_than_45_degrees_apart_for_opposite_falls_in_3d_only(model: str, said: str) -> None:
    name = next(
        name for name in STUDY_FINDINGS if handwritten_findings_of_study(name).study.question_kind == "vertical"
    )
    data = handwritten_findings_of_study(name).model_dump()
    data["study"]["model_kind"] = model
    data["contrasts"][0]["share_over_45_deg_apart_if_both_fall"] = 0.27
    headline = re.search(r"^# .*", render_template_as_markdown(Findings.model_validate(data), "en"), re.MULTILINE)
    assert headline is not None
    assert headline[0].endswith(f"of those that fall in both settings fall {said}")


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_survey_is_called_small_only_if_it_has_few_falls(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("survey").model_dump_json())
    data["surveys"][0] |= {"falls_in_known_direction": 23, "survey_file_comments": ["First line,", "second line."]}
    small = {"en": "has only 23 falls of known direction", "ja": "転倒方向の分かる墓石が 23 基しかなく"}[language]
    text = report_text(Findings.model_validate(data), language)
    assert small in text
    assert "First line, second line." in text
    data["surveys"][0] |= {"has_few_falls_in_known_direction": False, "survey_file_comments": []}
    text = report_text(Findings.model_validate(data), language)
    assert small not in text
    assert {"en": "Its file says", "ja": "調査ファイルの注記"}[language] not in text


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_names_the_soil_below_cemeteries_and_its_effect(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("survey").model_dump_json())
    ground = {"soil_thickness_m": 12.5, "mean_shear_wave_velocity_m_s": 183.4, "has_equivalent_linear_layer": True,
    "rock_pga_g": 0.31,
              "strain_exceeds_curve": False}  # fmt: skip
    upper = ground | {
        "site": "upper",
        "equivalent_linear_iteration_converged": False,
        "strain_exceeds_curve": True,
        "surface_pga_g": 0.47,
    }
    data["surveys"][0]["cemetery_soil_findings"] = [
        ground | {"site": "", "equivalent_linear_iteration_converged": True, "surface_pga_g": 0.52},
        upper,
    ]
    text = report_text(Findings.model_validate(data), language)
    assert text.count("12.5\u00a0m" if "12.5\u00a0m" in text else "12.5 m") == 2
    for words in ("183", "0.52", "0.47", {"en": "The other sites", "ja": "その他の墓地"}[language]):
        assert words in text
    assert text.count({"en": "did not converge", "ja": "収束しなかった"}[language]) == 1
    assert text.count({"en": "exceeds the curve of a layer", "ja": "曲線の範囲を超え"}[language]) == 1
    assert {"en": "at the surface of the soil of each cemetery", "ja": "地盤の層を与えた墓地では地表"}[language] in text
    data["surveys"][0]["cemetery_soil_findings"] = [
        ground | {"site": "", "equivalent_linear_iteration_converged": True, "surface_pga_g": 0.52}
    ]
    assert {"en": "The stones: motion", "ja": "墓石：厚さ"}[language] in report_text(
        Findings.model_validate(data), language
    )


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_counts_earthquakes_with_and_without_pulses_once_if_any(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    both = {"en": "6 have records with and without", "ja": "うち 6 地震は"}[language]
    assert report_text_of_handwritten_findings("direction", language).count(both) == 1
    data["study_counts"]["earthquakes_in_several_groups"] = 0
    assert both not in report_text(Findings.model_validate(data), language)


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_mentions_stones_fixed_to_their_base_in_four_places(language: str) -> None:
    """The report mentions in four places the stones that are fixed to their base.

    The places are the figure, the peak velocity at which half of the stones fall, the fragility curves and the rules
    for surveys.
    """
    found = handwritten_findings_of_study("direction")
    assert found.population is not None
    some = found.model_copy(update={"population": found.population.model_copy(update={"share_fixed": 0.3})})
    word = {"en": "fixed", "ja": "固定され"}[language]
    before = markdown_report_of_handwritten_findings("direction", language).splitlines()
    lines = [line for line in render_template_as_markdown(some, language).splitlines() if line not in before]
    assert [word in line for line in lines] == [True] * 4, lines
    assert any("30\u00a0%" in line for line in lines), lines


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_states_missing_outcomes_and_records_without_vertical_motion(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    data["cases"] |= {"cases_at_other_amplitudes": 720, "other_amplitude_cases_without_outcome": 10}
    data["population"] |= {
        "max_share_of_stones_without_outcome_at_any_factor": 0.19,
        "records_without_vertical_motion": 5,
    }
    text = render_template_as_markdown(Findings.model_validate(data), language).replace("\u00a0", " ")
    for words in {
        "en": ("10 of 720 cases are without", "up to 19 %.", "(horizontal motion in 5 of 28 records)"),
        "ja": ("720 ケースのうち 10 件", "最大 19 %", "(28 記録中 5 記録は水平動による)"),
    }[language]:
        assert words in text
        assert words not in markdown_report_of_handwritten_findings("direction", language).replace("\u00a0", " ")


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_record_without_an_earthquake_is_named_by_its_station_alone(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    comma = {"en": ", ", "ja": "、"}[language]
    media = ReportMedia(figure_names_by_record={"vale": ("polar/vale",)})
    with_event = render_template_as_markdown(Findings.model_validate(data), language, media)
    assert with_event.count(f"Vale{comma}Upper Vale") >= 2
    for one in (*data["maps"]["records"], *data["records"]):
        one["event"] = ""
    without = render_template_as_markdown(Findings.model_validate(data), language, media)
    assert without.replace(" ", "") == with_event.replace(f"{comma}Upper Vale", "").replace("Upper Vale", "").replace(
        " ", ""
    )


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_prints_the_p_value_of_the_common_axis_test(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    groups = data["direction"]["groups"]
    groups[0] |= {
        "no_common_axis_p_value": 0.013,
        "fall_axis_from_fault_normal_deg": 21.0,
        "axis_interval_half_width_deg": 17.0,
    }
    groups[1] |= {"no_common_axis_p_value": 0.38}
    given, withheld = (
        one for one in report_text(Findings.model_validate(data), language).splitlines() if "(p = " in one
    )
    assert "p = 0.013" in given
    assert "21° ± 17°" in given
    assert "p = 0.38" in withheld
    refusal = {"en": "does not reject", "ja": "を棄却しない"}[language]
    assert refusal in withheld


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    ("study", "path", "value", "shown"),
    [
        ("direction", ("direction", "groups", 0, "mean_cos_2_angle_to_fault_normal", "value"), 0.8765, "0.88"),
        ("direction", ("convergence", "comparisons", 0, "fall_side_changes", "value"), 0.432, "43.2"),
        ("reference", ("reference_alignments", 0, "alignment_with_best_reference_axis", "value"), 0.8765, "0.88"),
        ("scene", ("contrasts", 0, "share_overturned_in_study", "value"), 0.7654, "76.5"),
        ("survey", ("surveys", 0, "fell"), 8765, "8,765"),
        ("direction", ("records", 0, "pgv_cm_s"), 765.4, "765"),
    ],
)
def test_changed_value_in_the_findings_changes_the_report(
    study: str, path: tuple[str | int, ...], value: float, shown: str, language: str
) -> None:
    data = json.loads(handwritten_findings_of_study(study).model_dump_json())
    part: Any = data
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = value
    after = report_text(Findings.model_validate(data), language)
    assert shown not in NUMBER_IN_TEXT.findall(report_text_of_handwritten_findings(study, language))
    assert shown in NUMBER_IN_TEXT.findall(after)


ENGLISH_SENTENCE = re.compile(r"[A-Za-z]{2,}[,;]? [a-z]{2,}[,;]? [A-Za-z]{2,}")
"""Three English words in a row, the second one in small letters: part of a sentence, and no name."""


@pytest.mark.parametrize("study", STUDY_FINDINGS)
def test_a_japanese_report_has_no_english_sentence(study: str) -> None:
    assert ENGLISH_SENTENCE.search("the mean axis of falls")
    assert not ENGLISH_SENTENCE.search("計算には overturning を用いた Upper Vale")
    text = report_text_of_handwritten_findings(study, "ja").replace(REMARK, "")  # text of a file is quoted as it is
    assert ENGLISH_SENTENCE.findall(text) == []


@pytest.mark.parametrize("study", STUDY_FINDINGS)
def test_paragraphs_of_a_japanese_report_contain_no_line_breaks(study: str) -> None:
    """A line break would be shown as a space, which Japanese text does not use."""
    for node in parse_markdown_and_number_figures_and_tables(
        markdown_report_of_handwritten_findings(study, "ja")
    ).walk():
        if node.type == "inline":
            assert not any(one.type == "softbreak" for one in node.children), node.content
            # "**" next to a closing bracket and a letter does not end the bold text.
            assert not any("**" in one.content for one in node.children if one.type == "text"), node.content


def names_passed_to_the_label_filter() -> set[str]:
    """Return the names in the hand-written findings that the English templates pass to their label filter."""
    names: set[str] = set()
    usual = create_template_environment("en").filters["label"]

    def collect_and_translate_label(text: str) -> str:
        names.add(text)
        return str(usual(text))

    try:
        create_template_environment("en").filters["label"] = collect_and_translate_label
        for study in STUDY_FINDINGS:
            render_template_as_markdown(handwritten_findings_of_study(study))
    finally:
        create_template_environment("en").filters["label"] = usual
    return names


UNTRANSLATED_USER_NAMES = {"other", "By hand", "Which way?", "vale"}
"""Names of the user of a study, which no language translates."""


def test_every_name_passed_to_the_label_filter_has_a_japanese_label() -> None:
    names = names_passed_to_the_label_filter() - UNTRANSLATED_USER_NAMES
    assert len(names) >= 15
    labels = read_label_translations("ja")
    assert [
        name for name in names if translate_whole_text_by_table(name, labels) == name and re.search("[A-Za-z]{4}", name)
    ] == []
    assert {
        *BLOCK_SELECTION_RULE_NAMES,
        *CRITERION_NAMES,
        *STATUS_NAMES,
        *(d for d, *_ in JMA_DEGREES_WITH_INTENSITY_RANGES if " " in d),
    } <= {*labels}


def test_japanese_label_keeps_the_numbers_of_a_name() -> None:
    labels = {"B/H {} to {}": "B/H {}～{}"}
    assert translate_whole_text_by_table("B/H 0.1 to 0.25", labels) == "B/H 0.1～0.25"
    assert translate_whole_text_by_table("{odd} 7 {name}", labels) == "{odd} 7 {name}"


def test_all_languages_print_the_same_numbers() -> None:
    for study in STUDY_FINDINGS:
        printed = [
            set(NUMBER_IN_TEXT.findall(report_text_of_handwritten_findings(study, language)))
            - NUMBERS_ALLOWED_IN_TEMPLATES
            for language in LANGUAGES
        ]
        assert all(one == printed[0] for one in printed), study


def test_headline_differs_for_alignment_intervals_above_below_and_around_0() -> None:
    """Intervals above 0, below 0 and around 0 give three different headlines.

    Another mean whose interval is also above 0 gives the same headline.
    """
    headlines = []
    for value, low, high in ((0.5, 0.2, 0.7), (0.3, 0.1, 0.6), (-0.5, -0.7, -0.2), (0.1, -0.2, 0.4)):
        data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
        data["direction"]["groups"][0]["mean_cos_2_angle_to_fault_normal"] |= {"value": value, "low": low, "high": high}
        text = render_template_as_markdown(Findings.model_validate(data))
        headlines.append(re.findall(r"^# (.*)$", text, flags=re.MULTILINE))
    assert [len(one) for one in headlines] == [1, 1, 1, 1]
    assert headlines[0] == headlines[1]
    assert len({one[0] for one in headlines}) == 3


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_says_no_interval_for_an_alignment_of_few_earthquakes(language: str) -> None:
    data = json.loads(handwritten_findings_of_study("direction").model_dump_json())
    data["direction"]["groups"][0]["mean_cos_2_angle_to_fault_normal"] |= {
        "value": 0.417,
        "low": None,
        "high": None,
        "earthquake_count": 3,
    }
    text = report_text(Findings.model_validate(data), language)
    assert {"en": "0.42 (no interval; 3 earthquakes)", "ja": "0.42 (信頼区間なし、3 地震)"}[language] in text
    data = json.loads(handwritten_findings_of_study("reference").model_dump_json())
    data["reference_alignments"][0]["alignment_with_best_reference_axis"] |= {"value": 0.417, "low": None, "high": None}
    text = report_text(Findings.model_validate(data), language)
    assert {"en": "0.42 (no interval", "ja": "0.42 (信頼区間なし"}[language] in text


@pytest.mark.parametrize("study", STUDY_FINDINGS)
def test_english_report_on_handwritten_findings_equals_its_snapshot(study: str, snapshot: SnapshotAssertion) -> None:
    """The snapshot lets a reviewer read in a diff how the prose of the report changes.

    Other tests check its correctness.
    """
    assert markdown_report_of_handwritten_findings(study, "en") == snapshot


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    ("template", "parts"),
    [
        ("survey", {"surveys": [SURVEY_COMPARISON]}),
        ("survey_summary", {"observed_surveys": [OBSERVED_SURVEY_FINDINGS]}),
        ("displacements", {"survey_displacements": [SURVEY_DISPLACEMENTS]}),
        ("motions", {"inferred_motions": [INFERRED_MOTION]}),
    ],
)
def test_survey_commands_print_only_numbers_of_their_findings(
    template: str, parts: dict[str, Any], language: str
) -> None:
    found = ResultsPrintedBySurveyCommands.model_validate(parts)
    printed = NUMBER_IN_TEXT.findall(report_text(found, language, template))
    assert len(printed) >= 8
    assert numbers_not_in_findings(printed, found) == []


@pytest.mark.parametrize(("language", "doubt"), [("en", "lists no stone that stood"), ("ja", "記載が省かれている場合")])
def test_report_warns_of_a_motion_inferred_from_fallen_stones_alone(language: str, doubt: str) -> None:
    for every in (True, False):
        found = ResultsPrintedBySurveyCommands.model_validate(
            {"inferred_motions": [INFERRED_MOTION | {"everything_fell": every}]}
        )
        assert (doubt in report_text(found, language, "motions")) == every
