"""Figures and films in Japanese: every visible word is translated, at the place of the English one."""

import json
import re
import warnings
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from overturning.figures.backwards import inferred_motion_posterior_figure
from overturning.figures.fall_rate import fragility_curves_figure, overturned_fraction_by_intensity_figure
from overturning.figures.film_movie import write_film_as_gif_or_mp4
from overturning.figures.film_strip import film_strip_figure
from overturning.figures.history import record_before_and_after_processing_figure
from overturning.figures.maps import fall_map_figure
from overturning.figures.observed_rose import observed_fall_roses_figure
from overturning.figures.page import film_page_html
from overturning.figures.response import tilt_path_and_hodographs_figure
from overturning.figures.rose import fall_roses_by_group_figure
from overturning.figures.scene import draw_scenes_side_by_side
from overturning.figures.style import use_package_matplotlib_settings
from overturning.figures.svg_translation import break_lines_and_widen_to_max_line_count, translate_svg
from overturning.figures.write import remove_layout_engine_and_check_if_text_cut_or_overlaps, save_figure_files
from overturning.model.scene import gravestone
from overturning.records.processing import process_record
from overturning.records.record import Record
from overturning.statistics.fragility import FittedFragilityCurve
from overturning.translation import texts
from overturning.translation.texts import MissingDataError, use_translation_language
from tests.figures import test_answer_figures as answers
from tests.figures.films import film_of_one_falling_and_one_rocking_block, trajectory_of_3d_body
from tests.figures.test_explore import random_3d_cube
from tests.figures.test_further_figures import (
    FUNCTIONS_MAKING_FIGURES_BY_NAME,
    OBSERVED_ROSE,
    cube_of_falls_around_azimuth_40,
    draw_observed_and_computed_survey_falls,
    motion_with_one_pulse,
)
from tests.figures.test_history import SharedFolderMaker, random_record, write_time_history_page_of_offset_record
from tests.figures.test_roses import fall_axis_summary_of_five_earthquakes
from tests.translation.test_tables import untranslated_latin_words

UNTRANSLATED_NAMES = {
    *("Station", "earthquake", "script", "long", "station", "name", "with", "and", "Here", "Then", "StationOnMap"),
    *("Western", "Tottori", "ttrh", "survey", "csv", "block", "pulse", "without", "Test", "ruin", "rinaldi", "frame"),
    *("The", "moves", "the", "base", "normal", "Quake"),
}
"""Names of the tests' stations, earthquakes, surveys and films, which no table translates."""


def noise_record() -> Record:
    """Return noise without vertical motion; the reason for its corner frequency takes two lines of a title."""
    wave = np.random.default_rng(0).normal(size=(2, 3000)) * np.hanning(3000) * 0.3
    return Record("r", *wave, np.zeros(3000), 0.01, station="Here")


def draw_3d_fall_map() -> Figure:
    return fall_map_figure(random_3d_cube().isel(record=0).drop_vars("station", errors="ignore"), "Station")


def draw_motion_posterior() -> Figure:
    value = np.linspace(0.1, 1, 20)
    strength = {"PGV, cm/s": (value, value, value, (0.2, np.inf))}
    return inferred_motion_posterior_figure("survey.csv", np.full(36, 1 / 36), (20.0, 40.0), {"rinaldi": 1.0}, strength)


def draw_overturned_fraction_by_intensity() -> Figure:
    curve = FittedFragilityCurve("all stones", "PGV", "cm/s", 50.0, 0.5, (40.0, 60.0), 10.0, 100.0)
    level = np.geomspace(10, 100, 12).reshape(4, 3)
    return overturned_fraction_by_intensity_figure(level / 100, level, curve, 4.6 + level / 50)


def draw_fragility_curves() -> Figure:
    curve = FittedFragilityCurve("all stones", "SA(0.5)", "g", 0.5, 0.5, (0.4, 0.6), 0.1, 1.0)
    level = np.geomspace(0.1, 1, 12).reshape(4, 3)
    return fragility_curves_figure(level, {"SA(0.5)": level}, [curve])


FIGURES_TO_TRANSLATE: dict[str, Callable[[], Figure]] = FUNCTIONS_MAKING_FIGURES_BY_NAME | {
    "alignments": answers.figure_of_sorted_fall_alignments,
    "references": answers.figure_of_fall_alignment_with_reference_axes,
    "contrast": answers.figure_of_two_overturned_shares,
    "history of noise": lambda: record_before_and_after_processing_figure(
        noise_record(), process_record(noise_record(), None)
    ),
    "history as read": lambda: record_before_and_after_processing_figure(
        random_record(up=False), random_record(up=False)
    ),
    "mean axis": lambda: fall_roses_by_group_figure(
        cube_of_falls_around_azimuth_40(), {"all records": fall_axis_summary_of_five_earthquakes(20.0, 10.0)}
    ),
    "map in space": draw_3d_fall_map,
    "axis": lambda: tilt_path_and_hodographs_figure(
        trajectory_of_3d_body(motion_with_one_pulse()), motion_with_one_pulse(), "Station"
    ),
    "strip": lambda: film_strip_figure(film_of_one_falling_and_one_rocking_block()),
    "fragility": draw_fragility_curves,
    "scenes": lambda: draw_scenes_side_by_side([gravestone()]),
    "posterior": draw_motion_posterior,
    "surveys": lambda: draw_observed_and_computed_survey_falls(2),
    "observed roses": lambda: observed_fall_roses_figure(
        [replace(OBSERVED_ROSE, name=name) for name in ("all sites", "S$1")]
    ),
}


def svg_texts(svg: str) -> str:
    """Return all texts of an SVG file."""
    return " ".join(unescape(one) for one in re.findall(r"<text [^>]*>([^<]*)</text>", svg))


@pytest.mark.parametrize("name", [*FIGURES_TO_TRANSLATE, "history"])
def test_japanese_figures_have_no_english_word(name: str, tmp_path: Path, make_folder_once: SharedFolderMaker) -> None:
    if name == "history":
        path = make_folder_once("history-page", write_time_history_page_of_offset_record) / "page.svg"
    else:
        path = tmp_path / "en.svg"
        with use_package_matplotlib_settings():
            save_figure_files(FIGURES_TO_TRANSLATE[name](), path)
    english = path.read_text(encoding="utf-8")
    japanese = translate_svg(english, "ja")
    assert not untranslated_latin_words(svg_texts(japanese)) - UNTRANSLATED_NAMES
    assert re.search("[ぁ-んァ-ン一-龥]", svg_texts(japanese))
    assert translate_svg(japanese, "ja") == japanese
    # Nothing but texts differs.
    drawing = re.compile(r"<(?:path|use|image) [^>]*>")
    assert drawing.findall(english) == drawing.findall(japanese)


def test_a_figure_is_drawn_in_the_language_of_the_with_statement(tmp_path: Path) -> None:
    with use_package_matplotlib_settings():
        save_figure_files(answers.figure_of_two_overturned_shares(), tmp_path / "en.svg")
        with use_translation_language("ja"):
            save_figure_files(answers.figure_of_two_overturned_shares(), tmp_path / "ja.svg")
    english, japanese = ((tmp_path / f"{one}.svg").read_text(encoding="utf-8") for one in ("en", "ja"))
    assert japanese == translate_svg(english, "ja") != english


@pytest.mark.parametrize("kind", ["png", "pdf"])
def test_japanese_png_and_pdf_need_a_japanese_font(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(texts, "installed_fonts_of_language", lambda _: [])
    path = tmp_path / f"a.{kind}"
    with use_package_matplotlib_settings(), use_translation_language("ja"):
        with pytest.raises(MissingDataError, match=rf"^a\.{kind}: .* install the Debian package fonts-noto-cjk"):
            save_figure_files(answers.figure_of_two_overturned_shares(), path)
        assert not path.exists()
        save_figure_files(answers.figure_of_two_overturned_shares(), tmp_path / "a.svg")  # the page needs none


def figure_showing_text(name: str) -> Figure:
    """Return a small figure that shows only a name."""
    figure = Figure(figsize=(1.0, 1.0))
    figure.text(0.5, 0.5, name, size=30)
    return figure


def test_japanese_names_in_english_figures_are_legible(tmp_path: Path) -> None:
    """Without a Japanese font, Matplotlib would draw 一 and 川 as the same box, with a warning for each."""
    if not texts.installed_fonts_of_language("ja"):
        pytest.skip("no Japanese font")
    with use_package_matplotlib_settings(), warnings.catch_warnings(action="error"):
        for name in ("一", "川"):
            save_figure_files(figure_showing_text(name), tmp_path / f"{name}.png", tmp_path / f"{name}.svg")
        drawn = figure_showing_text("川")
        FigureCanvasAgg(drawn)
        assert not remove_layout_engine_and_check_if_text_cut_or_overlaps(drawn)
    assert (tmp_path / "一.png").read_bytes() != (tmp_path / "川.png").read_bytes()
    assert "川" in (tmp_path / "川.svg").read_text(encoding="utf-8")


def test_japanese_names_in_english_figures_need_a_font(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(texts, "installed_fonts_of_language", lambda _: [])
    with use_package_matplotlib_settings():
        with pytest.raises(MissingDataError, match=r"^a\.png: .* install the Debian package fonts-noto-cjk"):
            save_figure_files(figure_showing_text("川"), tmp_path / "a.png")
        assert not (tmp_path / "a.png").exists()
        save_figure_files(figure_showing_text("Hill"), tmp_path / "a.png")


def test_warnings_other_than_missing_glyphs_are_passed_on(tmp_path: Path) -> None:
    figure = figure_showing_text("川")
    draw = figure.draw

    def draw_after_unrelated_warning(renderer: object) -> None:
        warnings.warn("something else", UserWarning, stacklevel=1)
        draw(renderer)  # type: ignore[arg-type]

    figure.draw = draw_after_unrelated_warning  # type: ignore[method-assign]
    with use_package_matplotlib_settings(), pytest.warns(UserWarning, match="something else"):
        save_figure_files(figure, tmp_path / "a.svg")


def test_a_png_with_japanese_letters_has_the_size_of_the_english_one(tmp_path: Path) -> None:
    from PIL import Image

    if not texts.installed_fonts_of_language("ja"):
        pytest.skip("no Japanese font")
    with use_package_matplotlib_settings():
        save_figure_files(answers.figure_of_two_overturned_shares(), tmp_path / "en.png")
        with use_translation_language("ja"):
            save_figure_files(answers.figure_of_two_overturned_shares(), tmp_path / "ja.png", tmp_path / "ja.pdf")
    with Image.open(tmp_path / "en.png") as english, Image.open(tmp_path / "ja.png") as japanese:
        assert np.abs(np.subtract(english.size, japanese.size)).max() <= 1
    assert (tmp_path / "ja.pdf").read_bytes().startswith(b"%PDF")


def test_centred_text_stays_centred_in_japanese(tmp_path: Path) -> None:
    one = '<text style="font-size: 10px; fill: #222222" transform="translate(50 100) rotate(-90)">time, s</text>'
    two = "".join(
        f'<text style="font-size: 10px; fill: #222222" transform="translate({x} {y})">{text}</text>'
        for x, y, text in ((18.0, 10, "along"), (10.0, 22, "the fault"))
    )
    rotated, lines = translate_svg(one, "ja"), translate_svg(two, "ja")
    assert "text-anchor: middle" in rotated
    assert float(re.findall(r"translate\(50\.00 ([\d.]+)\) rotate\(-90\)", rotated)[0]) < 85
    assert lines.count("<text") == 1
    assert "text-anchor: middle" in lines


def test_japanese_lines_break_anywhere_but_not_before_a_full_stop() -> None:
    assert break_lines_and_widen_to_max_line_count(["転倒する墓石。N60°E へ"], 6.0, 5) == ["転倒する墓石。", "N60°E へ"]
    assert break_lines_and_widen_to_max_line_count(["あ" * 30], 10.0, 2) == ["あ" * 16, "あ" * 14]


def test_film_page_in_japanese_has_no_english_word(tmp_path: Path) -> None:
    film = film_of_one_falling_and_one_rocking_block(
        title="A stone 24 cm wide and 60 cm high, friction 0.7, under the record of Station, Quake"
    )
    with use_translation_language("ja"):
        page = film_page_html(film)
    data = json.loads(re.findall(r'<script type="application/json">(.*?)</script>', page, flags=re.DOTALL)[0])
    told = json.dumps([data["title"], data["words"], [(one["title"], one["outcome"]) for one in data["panels"]]])
    assert (
        not untranslated_latin_words(re.sub(r'"\w+":', "", json.dumps(json.loads(told), ensure_ascii=False)))
        - UNTRANSLATED_NAMES
    )
    assert '<html lang="ja">' in page
    assert not untranslated_latin_words(re.findall(r'<p class="film-note">(.*?)</p>', page)[-1])
    assert '<html lang="en">' in film_page_html(film)


def test_movie_in_japanese_uses_a_japanese_font(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if texts.installed_fonts_of_language("ja"):
        with use_translation_language("ja"):
            write_film_as_gif_or_mp4(film_of_one_falling_and_one_rocking_block(0.0), tmp_path / "a.gif")
        assert (tmp_path / "a.gif").read_bytes().startswith(b"GIF")
    monkeypatch.setitem(texts.FONT_PACKAGE_AND_NAMES_BY_LANGUAGE, "ja", ("fonts-noto-cjk", ("No such font",)))
    with use_translation_language("ja"), pytest.raises(MissingDataError, match="fonts-noto-cjk"):
        write_film_as_gif_or_mp4(film_of_one_falling_and_one_rocking_block(0.0), tmp_path / "b.gif")
    with pytest.raises(MissingDataError, match=r"^c\.gif: .*fonts-noto-cjk"):
        write_film_as_gif_or_mp4(
            replace(film_of_one_falling_and_one_rocking_block(0.0), title="上野, 熊本地震"), tmp_path / "c.gif"
        )


def test_a_japanese_title_of_an_english_gif_film_is_legible(tmp_path: Path) -> None:
    if not texts.installed_fonts_of_language("ja"):
        pytest.skip("no Japanese font")
    with warnings.catch_warnings(action="error"):
        for name in ("一", "川"):
            write_film_as_gif_or_mp4(
                replace(film_of_one_falling_and_one_rocking_block(0.0), title=name), tmp_path / f"{name}.gif"
            )
    assert (tmp_path / "一.gif").read_bytes() != (tmp_path / "川.gif").read_bytes()


def test_japanese_readme_images_are_translations_of_the_english_ones() -> None:
    images = Path(__file__).parents[2] / "docs" / "images"
    for name in ("rinaldi", "rinaldi-in-space"):
        english = (images / f"{name}.svg").read_text(encoding="utf-8")
        japanese = (images / f"{name}.ja.svg").read_text(encoding="utf-8")
        assert japanese == translate_svg(english, "ja"), f"{name}: run write_japanese_picture of verification.answers"
