from pathlib import Path

import pytest
from pydantic import ValidationError

from overturning.errors import ConfigError
from overturning.study.document import CATALOGUE, catalogue_schema_text, schema_text, with_tables
from overturning.study.load import check_study, entries_of, load_study, study_from
from overturning.study.values import AzimuthRange, Range, parse_quantity

CONFIG = Path(__file__).parents[2] / "config"
SMALL = {"name": "small", "records": {"use": ["rinaldi"]}}


def message(data: dict) -> str:
    with pytest.raises(ConfigError) as caught:
        check_study(data, "mine.yaml")
    return str(caught.value)


def test_range_includes_its_stop_without_rounding_dust() -> None:
    assert Range(start=0.1, stop=0.6, step=0.05).values() == (
        0.1,
        0.15,
        0.2,
        0.25,
        0.3,
        0.35,
        0.4,
        0.45,
        0.5,
        0.55,
        0.6,
    )


def test_azimuths_exclude_the_full_turn_and_take_others_in() -> None:
    assert AzimuthRange(step=90).values() == (0.0, 90.0, 180.0, 270.0)
    assert AzimuthRange(step=90, also=(330.0, 360.0, -45.0)).values() == (0.0, 90.0, 180.0, 270.0, 315.0, 330.0)


def test_default_study_has_the_cases_that_the_readme_states() -> None:
    study = load_study(CONFIG / "near-fault.yaml")
    assert len(study.records.use) * study.cases == 133_056


@pytest.mark.parametrize("name", ["near-fault.yaml", "tottori.yaml"])
def test_shipped_studies_name_records_of_the_table(name: str) -> None:
    study = load_study(CONFIG / name)
    assert list(entries_of(study, name, CONFIG.parent)) == list(study.records.use)


def test_schema_and_key_table_are_those_of_the_model() -> None:
    assert (CONFIG / "schema.json").read_text(encoding="utf-8") == schema_text(), "run: overturning study document"
    assert (CONFIG.parent / CATALOGUE).read_text(encoding="utf-8") == catalogue_schema_text()
    readme = (CONFIG / "README.md").read_text(encoding="utf-8")
    assert readme == with_tables(readme), "run: overturning study document"


def test_filled_in_study_reads_back_equal() -> None:
    study = load_study(CONFIG / "tottori.yaml")
    assert study_from(study.model_dump_json()) == study
    assert study_from(str(CONFIG / "tottori.yaml")) == study
    with pytest.raises(ConfigError, match="not valid JSON"):
        study_from("{name:")


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"frictoin": [1.0]}, "mine.yaml: frictoin: unknown key; did you mean friction?"),
        ({"contact": {"dampingratio": 1}}, "mine.yaml: contact.dampingratio: unknown key; did you mean damping_ratio?"),
        ({"b_over_h": [0.2, 0.0]}, "mine.yaml: b_over_h.1: 0.0 – it should be greater than 0"),
        ({"b_over_h": {"start": 0.5, "stop": 0.4, "step": 0.1}}, "empty range: stop 0.4 lies below start 0.5"),
        ({"friction": []}, "mine.yaml: friction: [] – empty list; give at least one value"),
        ({"friction": [-0.1]}, "mine.yaml: friction.0: -0.1 – it should be greater than or equal to 0"),
        ({"friction": [0.5, 0.5]}, "a value stands twice"),
        ({"height": ["60 kg"]}, "mine.yaml: height.0: \"60 kg\" – unit 'kg' does not fit; use m"),
        ({"contact": {"damping": 3500, "damping_ratio": 1}}, "damping_ratio and damping are both given"),
        ({"azimuth": {"start": 90, "stop": 90}}, "empty range: stop 90 does not lie above start 90"),
        ({"name": "Near Fault"}, 'mine.yaml: name: "Near Fault"'),
        ({"variants": {"nominal": {}}}, "choose another"),
        ({"records": {"use": ["rinaldi", "rinaldi"]}}, "rinaldi stands twice"),
        ({"records": {}}, "mine.yaml: records.use: this key is needed"),
        (
            {"surveys": [{"stones": "a.csv", "rekord": "x"}]},
            "mine.yaml: surveys.0.rekord: unknown key; did you mean record?",
        ),
        ({"surveys": [{"stones": "a.csv", "record": "x"}]}, "surveys.0.record: 'x' is not in records.use"),
        (
            {"records": {"use": ["a", "b"]}, "surveys": [{"stones": "a.csv"}]},
            "surveys.0.record: 2 records; name the one",
        ),
    ],
)
def test_wrong_key_or_value_is_one_line_that_says_what_to_write(change: dict, expected: str) -> None:
    text = message(SMALL | change)
    assert expected in text
    assert "\n" not in text
    assert text.startswith("mine.yaml: ")


def test_record_that_is_not_in_the_table() -> None:
    study = check_study({"name": "small", "records": {"use": ["rinaldy"]}}, "mine.yaml")
    with pytest.raises(ConfigError, match=r"mine.yaml: records.use: 'rinaldy' is not in .*did you mean rinaldi\?"):
        entries_of(study, "mine.yaml", CONFIG.parent)


def test_unreadable_files(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be read"):
        load_study(tmp_path / "none.yaml")
    for text, expected in (("name: [", "line 1"), ("- 1", "a study is a mapping"), ("name: \udcff", "UTF-8")):
        path = tmp_path / "bad.yaml"
        path.write_bytes(text.encode("utf-8", "surrogateescape"))
        with pytest.raises(ConfigError, match=expected):
            load_study(path)


def test_overrides_go_below_the_key_they_name(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("name: mine\nrecords: {use: [rinaldi]}\nazimuth: {step: 10, start: 20}\n", encoding="utf-8")
    assert load_study(path, {"azimuth": {"step": 30}}).azimuth == AzimuthRange(start=20, step=30)


def test_studies_are_frozen() -> None:
    study = check_study(SMALL, "mine.yaml")
    with pytest.raises(ValidationError):
        study.density = 1.0


def test_a_population_is_of_single_blocks():
    study = {"name": "x", "records": {"use": ["rinaldi"]}, "population": {"width": {"low": 0.2, "high": 0.3}}}
    assert check_study(study, "x.yaml").population.height.high == 0.9
    with pytest.raises(ConfigError, match="population: its stones are single blocks"):
        check_study(study | {"scene": "three-tier"}, "x.yaml")
    with pytest.raises(ConfigError, match=r"high 0.1 lies below low 0.2"):
        check_study(study | {"population": {"width": {"low": 0.2, "high": 0.1}}}, "x.yaml")


def test_a_population_in_space_is_of_square_prisms():
    study = {"name": "x", "records": {"use": ["rinaldi"]}, "population": {}}
    assert check_study(study | {"body": {}}, "x.yaml").population.rotated == 5.0
    for body in ({"plan": "circle"}, {"aspect": [2]}):
        with pytest.raises(ConfigError, match="of square plan; give body"):
            check_study(study | {"body": body, "orientation": {"step": 90}}, "x.yaml")


def test_soil_is_of_the_study_or_of_its_variants():
    soil = {"site": {"layers": [{"thickness_m": 20, "velocity_m_s": 150}], "rock": {"velocity_m_s": 760}}}
    assert check_study(SMALL | {"variants": {"soft": soil}}, "x.yaml").variants["soft"].site.motion == "outcrop"
    with pytest.raises(ConfigError, match=r"variants.soft.site: the study has a site too"):
        check_study(SMALL | soil | {"variants": {"soft": soil}}, "x.yaml")
    with pytest.raises(ConfigError, match=r"site.layers.0.velocity_m_s: -1"):
        check_study(SMALL | {"site": {**soil["site"], "layers": [{"thickness_m": 20, "velocity_m_s": -1}]}}, "x.yaml")


@pytest.mark.parametrize("key", ["[]", "../../etc/passwd", "", "<b>"])
def test_a_key_that_looks_like_none_is_named_all_the_same(key: str) -> None:
    with pytest.raises(ConfigError, match="unknown key; known here: ") as problem:
        check_study({"name": "a", "records": {"use": ["b"]}, key: 1}, "mine.yaml")
    assert str(problem.value).startswith(f'mine.yaml: "{key}": unknown key')


def test_what_yaml_or_python_stumbles_over_is_refused_in_a_line(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    twice = "a: &a [x,x,x,x,x,x,x,x,x]\n" + "".join(
        f"{name}: &{name} [{','.join([f'*{last}'] * 9)}]\n" for last, name in zip("abcdefgh", "bcdefghi", strict=True)
    )
    for text in (
        "name: 2001-02-30",
        "name: " + "9" * 5000,
        "name: !!bool x",
        "[" * 5000,
        twice,
        twice + "name: *i",
        "x: " + "y" * 600_000,
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(ConfigError) as problem:
            load_study(path)
        assert max(map(len, str(problem.value).split("\n"))) < 700
        assert str(path) in str(problem.value)


@pytest.mark.parametrize(
    ("value", "unit", "expected"),
    [
        (0.6, "m", 0.6),
        (1, "m", 1.0),
        ("0.6", "m", 0.6),
        ("60 cm", "m", 0.6),
        ("600mm", "m", 0.6),
        ("2.65 g/cm³", "kg/m³", 2650.0),
        ("3.5 kN·s/m", "N·s/m", 3500.0),
        ("1e9 N/m", "N/m", 1e9),
        ("60°", "°", 60.0),
    ],
)
def test_number_in_the_unit_of_the_key(value: object, unit: str, expected: float) -> None:
    assert parse_quantity(value, unit) == expected


@pytest.mark.parametrize("value", ["60 kg", "0.6 ft", "60 cm 3", "tall", None, True, [1.0]])
def test_wrong_unit_or_no_number_is_refused(value: object) -> None:
    with pytest.raises(ValueError, match="m"):
        parse_quantity(value, "m")
