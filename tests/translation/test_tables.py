"""Tables of words: complete, with the placeholders of the English texts, and without English words left over."""

import re
from importlib import resources
from pathlib import Path

import pytest
import yaml

from overturning.errors import ArgumentError, MissingDataError
from overturning.figures import film_words
from overturning.records.pulses import PULSE_SHAPES
from overturning.records.record import processing_entry_text
from overturning.translation import texts
from overturning.translation.texts import (
    LANGUAGES,
    check_font_is_installed,
    read_translation_table,
    translate,
    translate_nested_texts_except_data,
    translate_whole_text_by_table,
    use_translation_language,
)
from tests.sources import shipped_files

REPOSITORY_ROOT = Path(__file__).parents[2]
LATIN_WORD = re.compile(r"[A-Za-z]{3,}")
UNTRANSLATED_WORDS = {
    *("PGA", "PGV", "Gal", "cos", "RotD", "Home", "End", "Shift", "Esc", "Rinaldi", "TTRH"),
}
"""Words that stay in every language: symbols, units, keys, stations."""

PLACEHOLDER = re.compile(r"\{(\w*)\}")


def untranslated_latin_words(text: str) -> set[str]:
    """Return the words of a text in Latin letters, without placeholders and symbols that are never translated."""
    return {word for word in LATIN_WORD.findall(PLACEHOLDER.sub("", text)) if word not in UNTRANSLATED_WORDS}


@pytest.mark.parametrize("name", ["labels", "figures", "explorer"])
def test_each_translation_keeps_the_placeholders_and_has_no_english_word(name: str) -> None:
    for english, translation in read_translation_table("ja", name).items():
        assert not untranslated_latin_words(translation), translation
        before, after = PLACEHOLDER.findall(english), PLACEHOLDER.findall(translation)
        if english in {"figure", "table"}:  # keys of words that have no English text of their own
            continue
        if name == "explorer" or any(one.isdigit() for one in after):
            numbers = [one for one in before if one == ""]
            expected = {str(place) for place in range(len(numbers))} or {one for one in before if one.isdigit()}
            assert {one for one in after if one.isdigit()} == expected, english
        else:
            assert sorted(before) == sorted(after), english


NOISE_LIMIT_TEXT = "3 times the noise of the first 3.5 s"


@pytest.mark.parametrize(
    "step",
    [
        *(
            {"step": "highpass", "corner_hz": 0.1, "order": 2, "chosen": reason}
            for reason in (
                "no noise of 2 s before the onset to compare with",
                f"signal nowhere {NOISE_LIMIT_TEXT}, so the highest corner is taken",
                f"signal less than {NOISE_LIMIT_TEXT} below it",
                "signal less than 3 times the offset that the shock leaves below it, kept within 0.03 to 1 Hz",
                f"signal more than {NOISE_LIMIT_TEXT} as far down as that tells",
                f"signal more than {NOISE_LIMIT_TEXT} as far down as that tells, 0.87 Hz",
                f"signal more than {NOISE_LIMIT_TEXT} as far down as that tells, kept within 0.03 to 1 Hz",
            )
        ),
        *(
            {
                "step": "baseline", "scheme": "boore-2001", "fit_from_s": 55.0,
                "chosen": f"nothing taken from {axes}, as the line is zero at no time before the fit",
            }
            for axes in ("north", "north and up", "north and east and up")
        ),
        *(
            {
                "step": "site", "layers": [{"thickness_m": 10.0, "velocity_m_s": 200.0}] * count,
                "rock": {"velocity_m_s": 400.0}, "motion": motion,
            } | chosen
            for count, motion, chosen in (
                (1, "outcrop", {}),
                (2, "within", {}),
                (2, "outcrop", {"chosen": "north converged, strain 0.12 %; east converged, strain 1e-05 %"}),
            )
        ),
        *(
            {"step": "common_window", "samples": samples, "kept": 90, "left_out_s": 1.1}
            for samples in ({"N-S": 200, "E-W": 90}, {"90": 200, "360": 90, "180: 0": 100})
        ),
    ],
)  # fmt: skip
def test_names_and_reasons_of_processing_steps_are_translated(step: dict[str, object]) -> None:
    text = processing_entry_text(step)
    assert not untranslated_latin_words(translate(text, "ja").replace("boore-2001", ""))
    assert translate(text.replace(" the ", "\nthe "), "ja") == translate(text, "ja")  # broken in a title


@pytest.mark.parametrize("shape", PULSE_SHAPES)
def test_shapes_of_pulses_are_translated(shape: str) -> None:
    assert not untranslated_latin_words(translate(f"pulse, {shape} pulse: B/H = 0.4, H = 0.6 m, µ = 1", "ja"))


@pytest.mark.parametrize("path", shipped_files("config/*.yaml"), ids=lambda path: path.stem)
def test_titles_and_questions_of_shipped_studies_are_translated(path: Path) -> None:
    study = yaml.safe_load(path.read_text(encoding="utf-8"))
    table = read_translation_table("ja", "labels")
    for text in (study["title"], study["question"]):
        assert not untranslated_latin_words(translate_whole_text_by_table(text, table))


def test_every_language_has_words_for_figure_table_and_azimuth() -> None:
    for language in LANGUAGES:
        assert {"to", "figure", "table", "azimuth"} <= read_translation_table(language, "labels").keys()


def test_translation_table_lists_exactly_the_texts_of_the_explorer_scripts() -> None:
    folder = resources.files("overturning").joinpath("figures", "templates")
    scripts = [one for one in folder.iterdir() if one.name.startswith("explore") and one.name.endswith(".js")]
    script = re.sub(r'" \+\s*"', "", "\n".join(one.read_text(encoding="utf-8") for one in scripts))
    table = read_translation_table("ja", "explorer")
    said = {text for pair in re.findall(r'say\((?:[^"()]|\(\))*"([^"]*)"(?:\s*: "([^"]*)")?', script) for text in pair}
    assert said - {""} <= table.keys()
    literals = set(re.findall(r'"([^"]*)"', script))
    names = {"record", "height", "aspect", "friction", "element", "colour", "b_over_h", "azimuth", "orientation"}
    assert table.keys() - names <= literals


def test_texts_of_films_and_players_are_translated() -> None:
    several = (film_words.PLAYER_TEXTS, film_words.ACCELERATION_TRACE_LABELS)
    told = [text for table in several for text in table.values()]
    told += [
        film_words.KEYBOARD_HELP_TEXT,
        film_words.REFERENCE_FRAME_NOTE,
        film_words.VIEW_ROTATION_HINT,
        *film_words.NO_OUTCOME_SENTENCE_BY_STATUS.values(),
    ]
    told += [
        *film_words.STRIP_CAPTIONS_ALL_FALL,
        *film_words.STRIP_CAPTIONS_SOME_FALL,
        *film_words.STRIP_CAPTIONS_NONE_FALL,
    ]
    assert not set().union(*(untranslated_latin_words(translate(text, "ja")) for text in told))


@pytest.mark.parametrize(
    ("english", "japanese"),
    [
        ("stands", "非転倒"),
        ("falls towards N60°E at 2.10 s", "2.10 s に N60°E へ転倒"),
        ("2 of 3 fall: shaft falls towards N at 1.00 s; cross falls towards S at 2.00 s",
         "3 個中 2 個が転倒：1.00 s に棹石が N へ転倒；2.00 s に石の十字架が S へ転倒"),
        ("1 of 3 falls: shaft falls towards N at 1.00 s", "3 個中 1 個が転倒：1.00 s に棹石が N へ転倒"),
        ("N30°E: falls", "N30°E：転倒"),
        ("Rinaldi, Northridge 1994", "Rinaldi, Northridge 1994"),
        ("A stone, Quake\nradius: slenderness B/H", "A stone, Quake\n半径：幅高さ比 B/H"),
        ("no fall in a\nknown direction", "方向の分かる転倒なし"),
        (
            "stands; leans to 91 % of the angle at which it would topple at rest",
            "転倒せず、静的な転倒角の 91 % まで傾く",
        ),
        ("A square stone 18 cm wide and 60 cm high, friction 0.7, facing N30°E, under the record of A, B 1994, "
         "without its vertical motion",
         "幅 18 cm、高さ 60 cm の正方形断面の墓石、摩擦係数 0.7、N30°E 向き、A, B 1994 の記録、上下動なし"),
        ("clay-10-m, vale: north not converged (last change 1.2 %), strain 0.1 %",
         "粘土層 10 m、vale：南北成分は収束せず(最終変化 1.2 %)、ひずみ 0.1 %"),
        ("pulse, sine pulse: B/H = 0.4, H = 0.6 m, µ = 1", "正弦波パルス：B/H = 0.4, H = 0.6 m, µ = 1"),
        ("pulse, ricker pulse, motion × 2: B/H = 0.4, H = 0.6 m", "リッカーパルス、地震動 × 2：B/H = 0.4, H = 0.6 m"),
        ("paper, sine pulse", "paper、正弦波パルス"),
        ("variant tall (H and B/H are those of the study's shaft; the cross has 1.85 times that height)",
         "設定 tall(H と B/H は本解析の棹石の値。石の十字架は高さがその 1.85 倍)"),
        ("variant tall (H and B/H are those of the study's shaft; the cross has a B/H of 0.463 whatever the shaft has)",
         "設定 tall(H と B/H は本解析の棹石の値。石の十字架の B/H は棹石によらず 0.463)"),
        ("variant tall (H and B/H are those of the study's shaft; the cross has 1.85 times that height and a B/H of "
         "0.463 whatever the shaft has)",
         "設定 tall(H と B/H は本解析の棹石の値。石の十字架は高さがその 1.85 倍、B/H は棹石によらず 0.463)"),
    ],
)  # fmt: skip
def test_texts_made_of_several_phrases_are_translated_phrase_by_phrase(english: str, japanese: str) -> None:
    assert translate(english, "ja") == japanese
    assert translate(english) == english


@pytest.mark.parametrize(
    "sentence",
    [
        "← W    E →      motion along E: "
        + film_words.standing_elements_sentence(0.62, None, has_several_free_stones=False),
        film_words.standing_elements_sentence(0.12, None, has_several_free_stones=True),
        film_words.standing_body_sentence((1.2, ""), (3.1, ""), (0.012, ""), still_moves=False),
        film_words.standing_body_sentence((1.2, "shaft"), (-3.1, "shaft"), (0.012, "upper-base"), still_moves=True),
        film_words.join_fall_sentences([film_words.fall_sentence(32.0, 2.2, "shaft"), "falls towards N at 3.14 s"], 3),
        "A stone 42 cm wide and 1.2 m high, friction 0.8, under the record of Karakyr, Gazli 1976, turned to N30°E",
    ],
)
def test_a_sentence_with_a_line_break_at_any_space_is_translated(sentence: str) -> None:
    """A sentence that is broken at any one space keeps no more English words than the unbroken one.

    Captions are wrapped into lines before they are translated.
    """
    names = untranslated_latin_words(translate(sentence, "ja"))
    for place, letter in enumerate(sentence):
        if letter == " " != sentence[place - 1]:
            broken = f"{sentence[:place]}\n{sentence[place:].lstrip()}"
            assert untranslated_latin_words(translate(broken, "ja")) == names, broken


def test_packed_data_and_numbers_of_a_film_are_not_translated() -> None:
    data = {"title": "stands", "rows": [{"data": "stands", "scale": 1.5}], "free": True}
    assert translate_nested_texts_except_data(data, "ja") == data | {"title": "非転倒"}


def test_language_is_changed_only_inside_the_with_block() -> None:
    with use_translation_language("ja"):
        assert translate("stands") == "非転倒"
    assert translate("stands") == "stands"
    with pytest.raises(ArgumentError, match="choose one of en, ja"), use_translation_language("de"):
        pass


def test_error_about_a_missing_font_names_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(texts, "installed_fonts_of_language", lambda _: [])
    check_font_is_installed("en", "a.png")
    with pytest.raises(MissingDataError, match=r"^a\.png: .*install the Debian package fonts-noto-cjk$"):
        check_font_is_installed("ja", "a.png")
