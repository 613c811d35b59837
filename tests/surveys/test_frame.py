"""The pandas table of a survey, the template, and the schema of a row."""

import csv
import io
import json
import math
from pathlib import Path

import jsonschema
import pytest

import overturning
from overturning.errors import RecordError
from overturning.surveys.row import SURVEY_COLUMNS, SurveyRow, survey_row_json_schema_text
from overturning.surveys.template import TEMPLATE_COLUMNS, survey_table_template_text

DOCS_FOLDER = Path(__file__).parents[2] / "docs"


def test_pandas_table_of_a_survey_has_the_expected_columns_units_and_notes(tmp_path: Path) -> None:
    path = tmp_path / "stones.csv"
    path.write_text(
        "site;stone;outcome;azimuth_deg;face_azimuth_deg;height_m;lat;lon;mood\n"
        "A;1;fell;S40E;N20W;0,6;35,4;133,3;calm\n"
        "A;2;shifted 25 mm, twisted -8;;;;;;\n"
        "B;3;fixed;;;;;;\n",
        encoding="utf-8",
    )
    stones = overturning.read_survey(str(path), declination_deg=-7.5)
    assert list(stones) == [
        "site", "stone", "kind", "outcome", "counted_as", "azimuth_deg", "azimuth_half_width_deg", "count", "b_over_h",
        "b_over_h_side", "face_azimuth_deg", "height_m", "round", "shift_m", "twist_deg", "lat", "lon", "x", "y",
        "note", "photo", "line",
    ]  # fmt: skip
    assert list(stones["counted_as"]) == ["fell", "stands", "not counted"]
    assert list(stones["outcome"]) == ["fell", "shifted, twisted", "fixed"]
    first, second = stones.iloc[0], stones.iloc[1]
    assert (first["azimuth_deg"], first["face_azimuth_deg"], first["height_m"]) == (132.5, 332.5, 0.6)
    assert (first["lat"], first["lon"], first["azimuth_half_width_deg"]) == (35.4, 133.3, 0)
    assert (second["shift_m"], second["twist_deg"], second["line"]) == (0.025, -8, 3)
    assert math.isnan(second["azimuth_deg"])
    assert stones.attrs["notes"] == [
        "stones.csv: not used: column mood",
        "stones.csv: not counted as fallen or standing: 1 (outcomes: 1 fixed)",
    ]
    with pytest.raises(RecordError, match="no such survey"):
        overturning.read_survey(tmp_path / "none.csv")


def test_survey_template_is_accepted_as_soon_as_it_has_a_stone(tmp_path: Path) -> None:
    template, path = survey_table_template_text(), tmp_path / "stones.csv"
    assert template.isascii()
    assert all(f"# {name}: " in template for name in SURVEY_COLUMNS if name != "magnetic_declination_deg")
    path.write_text(template)
    with pytest.raises(RecordError, match="no stone; write one row per stone"):
        overturning.read_survey(path)
    examples = [line[2:] for line in template.partition("# Examples:\n")[2].splitlines() if line.startswith("# ")]
    path.write_text(template + "\n".join(examples))
    stones = overturning.read_survey(path)
    assert list(stones["outcome"]) == ["fell", "fell", "shifted, twisted"]
    assert [round(one, 3) for one in stones["azimuth_deg"][:1]] == [132.5]
    assert stones.attrs == {"notes": [], "warnings": []}


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_survey_template_saved_by_a_spreadsheet_is_read(tmp_path: Path, separator: str) -> None:
    # A spreadsheet splits comment lines into cells, pads them, and puts quotes around cells with separators.
    rows = list(csv.reader(io.StringIO(survey_table_template_text())))
    rows.append(["A", "1", "", "fell SE"])
    with (tmp_path / "stones.csv").open("w", encoding="utf-8-sig", newline="") as file:
        writer = csv.writer(file, delimiter=separator)
        writer.writerows([*row, *[""] * (max(map(len, rows)) - len(row))] for row in rows if row)
    stones = overturning.read_survey(tmp_path / "stones.csv")
    assert [*stones["site"], *stones["azimuth_deg"], *stones["azimuth_half_width_deg"]] == ["A", 135, 22.5]


def test_survey_row_schema_is_current_and_agrees_with_the_pydantic_model() -> None:
    assert (DOCS_FOLDER / "survey.schema.json").read_text(encoding="utf-8") == survey_row_json_schema_text(), (
        "run: overturning study document"
    )
    schema = json.loads(survey_row_json_schema_text())
    assert list(schema["properties"]) == list(SURVEY_COLUMNS)
    assert set(TEMPLATE_COLUMNS) - {"declination"} <= set(SURVEY_COLUMNS)
    jsonschema.Draft202012Validator.check_schema(schema)
    for azimuth, valid in {
        "S40E": True, "n 25° w": True, "nne": True, "12,5": True, 30: True, "NNNE": False, "E40S": False, 400: False,
    }.items():  # fmt: skip
        row = {"azimuth_deg": azimuth, "fell": "yes"}
        assert jsonschema.Draft202012Validator(schema).is_valid(row) == valid, azimuth
        try:
            SurveyRow.model_validate(row)
        except ValueError:
            assert not valid, azimuth
        else:
            assert valid, azimuth
    assert not jsonschema.Draft202012Validator(schema).is_valid({"count": 0})
