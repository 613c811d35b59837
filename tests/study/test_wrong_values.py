"""A wrong value of any key of a study, scene or table is answered in plain words, never in pydantic's."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import pytest
import yaml
from pydantic import BaseModel

from overturning import read
from overturning.errors import ArgumentError, ConfigError, OverturningError
from overturning.model.scene import Scene, parse_scene_content
from overturning.records.catalogue import RecordTableRow
from overturning.study.load import study_from_content
from overturning.study.schema import Study
from overturning.surveys.hazard import FragilityCurveParametersRow, HazardCurveRow
from overturning.surveys.stones import SurveyRow
from overturning.tables import read_table_rows

PYDANTIC_WORDS = re.compile(
    r"discriminator|tag:|tags:|Tuple|List should|String should|Dictionary|Input |instance of|a valid |unable to|"
    r"should have|Field required|Extra inputs|Keys should|after validation|pydantic|constrained|function-|zero time"
)
"""Words that only pydantic uses."""

WRONG_VALUES: tuple[Any, ...] = (
    None, True, 3, -7.5, 1e400, float("nan"), "", "nonsense", "60 in", [], [None], [[]], ["nonsense"], [1, "a"], {},
    {"nonsense": 1}, {"step": "nonsense"}, [{"stp": 1}], [{"step": "detrnd"}], {3: 4},
)  # fmt: skip
"""A value of each kind; most keys take none of them."""

VALID_STUDY_SETTINGS: dict[str, Any] = {"name": "mine", "records": {"use": ["rinaldi"]}}
BLOCK = {"name": "stone", "width": 0.3, "height": 0.6}
SCENE = {"name": "mine", "elements": [{"name": "ground", "kind": "driven", "width": 9, "height": 1}, BLOCK]}


def key_paths_of_model(model: type[BaseModel], *before: str) -> Iterator[tuple[str, ...]]:
    """Yield the paths of the keys of a model, also inside nested settings; a list or mapping is one key."""
    for name, field in model.model_fields.items():
        yield (*before, name)
        forms = (field.annotation, *get_args(field.annotation))
        for form in forms:
            if isinstance(form, type) and issubclass(form, BaseModel) and form is not Scene:
                yield from key_paths_of_model(form, *before, name)


def copy_with_value_at_path(base: dict[str, Any], path: tuple[str, ...], value: Any) -> dict[str, Any]:
    """Return a mapping with another value at the path of a key."""
    first, *rest = path
    inside = base.get(first)
    new = copy_with_value_at_path(inside if isinstance(inside, dict) else {}, tuple(rest), value) if rest else value
    return base | {first: new}


def error_lines_for_wrong_values(check: Any, base: dict[str, Any], path: tuple[str, ...]) -> list[str]:
    """Return the lines of the errors for each wrong value of a key."""
    lines: list[str] = []
    for value in WRONG_VALUES:
        try:
            check(copy_with_value_at_path(base, path, value))
        except ConfigError as error:
            lines += str(error).split("\n       ")
    return lines


@pytest.mark.parametrize("path", list(key_paths_of_model(Study)), ids=".".join)
def test_error_for_a_wrong_study_value_has_no_pydantic_words(path: tuple[str, ...]) -> None:
    lines = error_lines_for_wrong_values(lambda data: study_from_content(data, "mine.yaml"), VALID_STUDY_SETTINGS, path)
    assert lines, "no value of WRONG is wrong there"
    assert [line for line in lines if PYDANTIC_WORDS.search(line)] == []
    assert [line for line in lines if not line.startswith("mine.yaml: ")] == []


@pytest.mark.parametrize("settings", ["published", "surveys", "processing", "variants", "pulses", "layers"])
def test_error_for_a_wrong_list_or_mapping_entry_has_no_pydantic_words(settings: str) -> None:
    lines = []
    for value in WRONG_VALUES:
        data = {
            "variants": {"variants": {"soft": value}},
            "pulses": {"records": {"use": ["rinaldi"], "pulses": {"p1": value}}},
            "layers": {"site": {"layers": [value], "rock": {"velocity_m_s": 700}}},
        }.get(settings, {settings: [value]})
        try:
            study_from_content(VALID_STUDY_SETTINGS | data, "mine.yaml")
        except ConfigError as error:
            lines += str(error).split("\n")
    assert len(lines) >= len(WRONG_VALUES) // 2
    assert [line for line in lines if PYDANTIC_WORDS.search(line)] == []


def test_error_for_a_wrong_scene_value_has_no_pydantic_words() -> None:
    lines = []
    for path in key_paths_of_model(Scene):
        lines += error_lines_for_wrong_values(parse_scene_content, SCENE, path)
    for name in BLOCK | {"kind": 1, "vertices": 1, "at": 1, "stands_on": 1, "pieces": 1}:
        lines += error_lines_for_wrong_values(
            lambda one: parse_scene_content(SCENE | {"elements": [SCENE["elements"][0], one]}), BLOCK, (name,)
        )
    assert len(lines) > 100
    assert [line for line in lines if PYDANTIC_WORDS.search(line)] == []


@pytest.mark.parametrize("model", [RecordTableRow, SurveyRow, FragilityCurveParametersRow, HazardCurveRow])
def test_error_for_a_wrong_table_cell_has_no_pydantic_words(model: type[BaseModel], tmp_path: Path) -> None:
    lines, needed = [], {name: "x" for name, field in model.model_fields.items() if field.is_required()}
    for column in model.model_fields:
        for cell in ("nonsense", "-7.5", "1e400", "nan", "1;2", "60 cm", "x y", "Z"):
            row = needed | {column: cell}
            (tmp_path / "table.csv").write_text(f"{','.join(row)}\n{','.join(row.values())}\n", encoding="utf-8")
            try:
                list(
                    read_table_rows(
                        tmp_path / "table.csv", model, delimiter=",", error_class=ConfigError, table_kind="table"
                    )
                )
            except ConfigError as error:
                lines.append(str(error))
    assert len(lines) > len(model.model_fields)
    assert [line for line in lines if PYDANTIC_WORDS.search(line)] == []


@pytest.mark.parametrize(
    ("processing", "message"),
    [
        ([{"step": "detrnd"}], "processing.0: unknown step 'detrnd'; did you mean detrend?"),
        ([{"stp": "detrend"}], "processing.0: the key step is needed, one of remove_mean, detrend, "),
        (["detrend"], 'processing.0: "detrend" – write {step: detrend}'),
        ([{"step": "highpass", "corner": 3}], "processing.0.corner: unknown key; did you mean corner_hz?"),
        ("detrend", 'processing: "detrend" – a list is needed: [detrend]'),
    ],
)
def test_the_error_for_a_wrong_processing_step_names_the_remedy(processing: Any, message: str, tmp_path: Path) -> None:
    """The error is the same for a processing step in a study file and for one given to `read` in Python."""
    with pytest.raises(ConfigError, match=re.escape(f"mine.yaml: {message}")):
        study_from_content(VALID_STUDY_SETTINGS | {"processing": processing}, "mine.yaml")
    with pytest.raises(ArgumentError, match=re.escape(message)):
        read(tmp_path / "none.V2A", processing=processing)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("records: {use: []}", "mine.yaml: records.use: [] – at least 1 value needed, not 0"),
        ("records: {use: [1]}", "mine.yaml: records.use.0: 1 – a text is needed; put it in quotes"),
        ("site: {layers: [], rock: {velocity_m_s: 700}}", "mine.yaml: site.layers: [] – at least 1 value needed"),
        ("primary: share", "mine.yaml: primary: \"share\" – it has keys of its own; write primary: {statistic: share}"),
        ("surveys: [stones.csv]", 'surveys.0: "stones.csv" – it has keys of its own; write {stones: stones.csv}'),
        ("asks: directon", "or 'survey'; did you mean direction?"),
        ("scene: 3", "mine.yaml: scene: 3 – it has keys of its own"),
        ("scene: nosuch", "mine.yaml: scene: \"nosuch\" – scene nosuch: no file"),
        ("scene: {name: a, elements: []}", "mine.yaml: scene.elements: [] – at least 2 values needed, not 0"),
        ("scene: {elements: [{name: b, width: 1, height: 1}]}", 'scene.elements: [{"name": "b", "width": 1'),
        ("site: {layers: [{thicknes_m: 3}]}", "site.layers.0.thicknes_m: unknown key; did you mean thickness_m?"),
        ("contact: {stiffness: aut}", "\"aut\" – it should be 'auto'; or give a number in N/m"),
        ("verification: maybe", "verification: \"maybe\" – it should be 'none', or keys with values: share, "),
        ("verification: no", "verification: false – it should be 'none', or keys with values: share, at_least, "),
        ("crate: {date: 5}", "mine.yaml: crate.date: 5 – a date is needed, as in 2026-11-21"),
    ],
)  # fmt: skip
def test_the_error_for_a_wrong_value_of_a_study_names_the_remedy(text: str, message: str) -> None:
    with pytest.raises(OverturningError) as found:
        study_from_content(VALID_STUDY_SETTINGS | yaml.safe_load(text), "mine.yaml")
    assert message in str(found.value)
    assert len(str(found.value).splitlines()) <= 4
