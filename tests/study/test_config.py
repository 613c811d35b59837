from pathlib import Path

import pytest
from pydantic import ValidationError

from overturning.commands.workflow import read_and_process_record
from overturning.errors import ArgumentError, ConfigError
from overturning.model.contact import ContactSettings
from overturning.quantities import parse_quantity
from overturning.settings import StonePopulation
from overturning.study.document import (
    WORKFLOW_CATALOGUE_SCHEMA_PATH,
    insert_study_key_and_record_column_tables,
    study_json_schema_as_yaml_text,
    study_json_schema_text,
)
from overturning.study.load import (
    load_study,
    load_study_from_file_or_json,
    read_record_table_rows_of_study,
    study_from_content,
)
from overturning.study.scenes import variant_contact_settings
from overturning.study.values import AzimuthRange, ValueRange
from tests.expect import expect_error
from tests.sources import shipped_files

CONFIG_FOLDER = Path(__file__).parents[2] / "config"
SMALL_STUDY = {"name": "small", "records": {"use": ["rinaldi"]}}
STUDY_IN_3D = {"body": {"aspect": [1, 2]}, "orientation": {"step": 45}, "b_over_h": [0.15, 0.25, 0.4]}


def test_a_range_in_a_study_includes_its_stop_without_rounding_errors() -> None:
    assert ValueRange(start=0.1, stop=0.6, step=0.05).expand_values() == tuple(n / 20 for n in range(2, 13))


def test_the_azimuths_of_a_study_exclude_360_and_include_additional_ones() -> None:
    assert AzimuthRange(step=90).expand_azimuths() == (0.0, 90.0, 180.0, 270.0)
    assert AzimuthRange(step=90, also=(330.0, 360.0, -45.0)).expand_azimuths() == (
        0.0,
        90.0,
        180.0,
        270.0,
        315.0,
        330.0,
    )


def test_the_default_study_has_the_number_of_cases_that_the_readme_states() -> None:
    study = load_study(CONFIG_FOLDER / "near-fault.yaml")
    assert len(study.records.use) * study.cases_per_record == 133_056


@pytest.mark.parametrize("name", ["near-fault.yaml", "tottori.yaml"])
def test_all_records_of_shipped_studies_are_in_the_record_table(name: str) -> None:
    study = load_study(CONFIG_FOLDER / name)
    assert list(read_record_table_rows_of_study(study, name, CONFIG_FOLDER.parent)) == list(study.records.use)


def test_the_study_schema_and_key_table_are_up_to_date() -> None:
    assert (CONFIG_FOLDER / "schema.json").read_text(encoding="utf-8") == study_json_schema_text(), (
        "run: overturning study document"
    )
    assert (CONFIG_FOLDER.parent / WORKFLOW_CATALOGUE_SCHEMA_PATH).read_text(
        encoding="utf-8"
    ) == study_json_schema_as_yaml_text()
    readme = (CONFIG_FOLDER / "README.md").read_text(encoding="utf-8")
    assert readme == insert_study_key_and_record_column_tables(readme), "run: overturning study document"


def test_a_study_with_all_defaults_is_read_back_equal_from_json() -> None:
    study = load_study(CONFIG_FOLDER / "tottori.yaml")
    assert load_study_from_file_or_json(study.model_dump_json()) == study
    assert load_study_from_file_or_json(str(CONFIG_FOLDER / "tottori.yaml")) == study
    with pytest.raises(ConfigError, match="not valid JSON"):
        load_study_from_file_or_json("{name:")


@pytest.mark.parametrize("path", shipped_files("config/*.yaml"), ids=lambda path: path.stem)
def test_each_shipped_study_states_its_question_and_primary_statistic(path: Path) -> None:
    assert {"primary", "question", "asks"} <= load_study(path).model_fields_set


SOIL = {"site": {"layers": [{"thickness_m": 20, "velocity_m_s": 150}], "rock": {"velocity_m_s": 760}}}
BOULDER_VERTICES = [[x, y, 0.0] for x in (-0.2, 0.2) for y in (-0.15, 0.15)] + [[0.05, 0.0, 0.7]]

WRONG_2D_SETTINGS = [
    ({"frictoin": [1.0]}, "mine.yaml: frictoin: unknown key; did you mean friction?"),
    ({"contact": {"dampingratio": 1}}, "mine.yaml: contact.dampingratio: unknown key; did you mean damping_ratio?"),
    ({"b_over_h": [0.2, 0.0]}, "mine.yaml: b_over_h.1: 0.0 – it should be greater than 0"),
    ({"b_over_h": {"start": 0.5, "stop": 0.4, "step": 0.1}}, "empty range: stop 0.4 lies below start 0.5"),
    ({"friction": []}, "mine.yaml: friction: [] – empty list; give at least one value"),
    ({"friction": [-0.1]}, "mine.yaml: friction.0: -0.1 – it should be greater than or equal to 0"),
    ({"friction": [0.5, 0.5]}, "a value stands twice"),
    # True is 1 in Python: YAML has it for `yes`, and it is no number.
    ({"friction": [True]}, "mine.yaml: friction.0: true – a number is needed"),
    ({"b_over_h": {"start": True, "stop": 2, "step": 1}}, "mine.yaml: b_over_h.start: true – a number is needed"),
    ({"ensemble": {"members": False}}, "mine.yaml: ensemble.members: false – a whole number is needed"),
    ({"site": SOIL["site"] | {"rock": {"velocity_m_s": True}}}, "site.rock.velocity_m_s: true – a number is needed"),
    ({"height": ["60 kg"]}, "mine.yaml: height.0: \"60 kg\" – unit 'kg' does not fit; use m"),
    ({"contact": {"damping": 3500, "damping_ratio": 1}}, "damping_ratio and damping are both given"),
    ({"azimuth": {"start": 90, "stop": 90}}, "empty range: stop 90 does not lie above start 90"),
    ({"name": "Near Fault"}, 'mine.yaml: name: "Near Fault"'),
    ({"variants": {"nominal": {}}}, "choose another"),
    ({"contact": {"damping": 9}, "variants": {"same": {}}}, "variants.same: it changes nothing; give contact"),
    ({"records": {"use": ["rinaldi", "rinaldi"]}}, "rinaldi stands twice"),
    ({"records": {}}, "mine.yaml: records.use: [] – at least 1 value needed, not 0"),
    (
        {"surveys": [{"stones": "a.csv", "rekord": "x"}]},
        "mine.yaml: surveys.0.rekord: unknown key; did you mean record?",
    ),
    ({"surveys": [{"stones": "a.csv", "record": "x"}]}, "surveys.0.record: 'x' is not in records.use"),
    (
        {"records": {"use": ["a", "b"]}, "surveys": [{"stones": "a.csv"}]},
        "surveys.0.record: 2 records; name the one",
    ),
    ({"azimuth": {"step": 7}}, "azimuth: step 7° does not close the circle; take 6 or 8"),
    ({"azimuth": 5}, "mine.yaml: azimuth: 5 – it has keys of its own; write azimuth: {step: 5}; known: start, stop"),
    ({"ensemble": 8}, "ensemble: 8 – it has keys of its own; write ensemble: {members: 8}"),
    ({"azimuth": {"step": 1e-9}}, "azimuth: more than 36,000 azimuths"),
    ({"height": [60]}, "60 m; a stone is 0.01 to 50 m high; is that in centimetres"),
    ({"height": [0.001]}, "0.001 m; a stone is 0.01 to 50 m high; heights are in m"),
    ({"population": {"height": {"low": 0.6, "high": 90}}}, "90 m; a stone is 0.01 to 50 m high"),
    ({"records": {"use": "rinaldi"}}, 'records.use: "rinaldi" – a list is needed: [rinaldi]'),
    ({"name": "A b"}, 'name: "A b" – only small letters, digits and hyphens are allowed'),
    ({"name": 101 * "a"}, "a letter or digit first, at most 100 in all"),
    ({"variants": {101 * "a": {"vertical": False}}}, "a letter or digit first, at most 100 in all"),
    ({"records": {"use": [], "pulses": {101 * "p": "sine amplitude_gal=1 period_s=1"}}}, "at most 100 in all"),
    ({"corner": 1}, "corner: unknown key; known are "),
    ({"contact": {"stiffness": 0}}, "stiffness 0 N/m; it must be above 0, or auto"),
    ({"ensemble": {"members": 7}}, "ensemble.members: 7 – an even number is needed"),
    ({"amplitude": [0.5, 2]}, "amplitude: [0.5, 2] – 1 is missing"),
    ({"population": {"face_spread": 30}}, "population: face_spread 30° is about `face`, which is not given"),
    ({"population": {"rotated": 20}}, "population.rotated: only 3-D stones have shifts and rotations"),
    ({"population": {"width": {"low": 0.2, "high": 0.1}}}, "high 0.1 lies below low 0.2"),
    (SOIL | {"variants": {"soft": SOIL}}, "variants.soft.site: the study has a site too"),
    (
        SOIL | {"surveys": [{"stones": "a.csv", "sites": {"River": SOIL["site"]}}]},
        "surveys.0.sites.River: the study has a site too, whose layers would come twice; give the layers at each",
    ),
    (
        {"surveys": [{"stones": "a.csv", "site": {"layers": [{"thickness_m": 0, "velocity_m_s": 150}]}}]},
        "surveys.0.site.layers.0.thickness_m: 0 – it should be greater than 0",
    ),
    ({"surveys": [{"stones": "a.csv", "sites": {"River": {"rock": {}}}}]}, "surveys.0.sites.River.layers: this key is"),
    ({"site": SOIL["site"] | {"layers": [{"thickness_m": 20, "velocity_m_s": -1}]}}, "site.layers.0.velocity_m_s: -1"),
    ({"site": SOIL["site"] | {"rock": {"velocity_m_s": 760, "density_kg_m3": 2.2}}}, "site.rock.density_kg_m3: 2.2"),
    ({"variants": {"one": {"scene": "monolith"}}}, "only a study with a scene"),
    ({"primary": {"statistic": "mood"}}, "primary.statistic"),
    ({"primary": {"statistic": "published"}}, "primary.statistic: nothing is published to compare with"),
    ({"primary": {"statistic": "fall_rate"}}, "primary.statistic: there are no stones whose rate it is"),
    ({"primary": {"statistic": "share", "against": "soft"}}, "'soft' is none of the variants; the study has none"),
    (
        {"primary": {"statistic": "share", "against": "sand"}, "variants": {"soft": SOIL}},
        "primary.against: 'sand' is none of the variants; known: soft",
    ),
    ({"primary": {"against": "soft"}, "variants": {"soft": SOIL}}, "primary.against: alignment is that of the study"),
    ({"figures": {"height": 0.7}}, "figures.height: 0.7 is not computed; add it to height, or name one of them"),
    ({"asks": "survey"}, "asks: survey, and there is nothing to compare with; give `surveys` or `published`"),
    ({"asks": "reference"}, "asks: reference, which only a 3-D body is free to follow"),
    (
        {"asks": "site", "variants": {"soft": SOIL}},
        "asks: site, compared with which variant? name one in primary.against",
    ),
    (
        {"asks": "vertical", "primary": {"statistic": "share", "against": "soft"}, "variants": {"soft": SOIL}},
        "asks: vertical, but variant 'soft' has none of its own",
    ),
]
SCENE_WITH_ITS_OWN_FRICTION = {
    "name": "icy",
    "contacts": [{"between": ["stone", "stone"], "friction": 0.1}],
    "elements": [
        {"name": "ground", "kind": "driven", "width": 40, "height": 1, "at": [0, -1]},
        {"name": "stone", "width": 0.24, "height": 0.6, "stands_on": "ground"},
    ],
}
GRAVESTONE_WITH_STACK_VARIANT = {"scene": "gravestone", "variants": {"stack": {"scene": "three-tier"}}}
WRONG_SCENE_SETTINGS = [
    ({"scene": "three-teir"}, "no file"),
    ({"contact": {"damping_ratio": 0.5}}, "contact: the scene has contact laws of its own"),
    ({"density": 2000}, "density: the scene's materials have it"),
    ({"ensemble": {"members": 4, "initial_tilt": 0.01}}, "ensemble.initial_tilt: a scene starts at rest"),
    ({"population": {}}, "population: its stones are single blocks"),
    (
        {"scene": SCENE_WITH_ITS_OWN_FRICTION, "friction": [0.2, 1.0]},
        "friction: the scene has coefficients of its own; leave it out",
    ),
    (
        GRAVESTONE_WITH_STACK_VARIANT | {"variants": {"stack": {"scene": "three-tier", "contact": {"damping": 9}}}},
        "variants.stack.contact: the scene has contact laws of its own",
    ),
    (
        GRAVESTONE_WITH_STACK_VARIANT | {"ensemble": {"initial_tilt": 0.01}},
        "a scene starts at rest (variants.stack.scene)",
    ),
    (
        GRAVESTONE_WITH_STACK_VARIANT | {"population": {}},
        "population: its stones are single blocks; leave out variants.stack.scene",
    ),
]
WRONG_3D_SETTINGS = [
    (
        {"orientation": {"step": 4}},
        "orientation: a step of 4° does not divide 90°, after which the body looks the same",
    ),
    ({"orientation": {"step": 45, "start": 50}}, "orientation.start: 50°; it must lie below the step, 45°"),
    ({"body": {"plan": 6}, "orientation": {"step": 25}}, "does not divide 60°"),
    ({"body": None}, "orientation: only a 3-D body or a stack has one"),
    ({"body": {"plan": "circle", "aspect": [2]}}, "only a rectangle has one"),
    (
        {"body": {"plan": "oval"}},
        "mine.yaml: body.plan: \"oval\" – it should be 'rectangle' or 'circle'; or a whole number is needed",
    ),
    ({"body": {"aspekt": [2]}}, "body.aspekt: unknown key; did you mean aspect?"),
    ({"body": {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}}, "body"),
    (
        {"body": {"vertices": [[1000 * x for x in vertex] for vertex in BOULDER_VERTICES]}, "b_over_h": None},
        "millimetres",
    ),
    ({"body": {"vertices": BOULDER_VERTICES}}, "b_over_h: the body of these vertices has its own"),
    (
        {
            "body": {"vertices": BOULDER_VERTICES},
            "b_over_h": None,
            "orientation": {"step": 90},
            "ensemble": {"b_over_h": 0.2},
        },
        "ensemble.b_over_h: the body of these vertices keeps its own",
    ),
    ({"body": {"vertices": BOULDER_VERTICES, "plan": "circle"}, "b_over_h": None}, "the body has vertices of its own"),
    ({"body": {"vertices": BOULDER_VERTICES, "mesh": "a.obj"}}, "body: vertices and mesh are both given; keep one"),
    ({"height": [60]}, "60 m; a stone is 0.01 to 50 m high; is that in centimetres"),
    ({"azimuth": {"step": 30}}, "azimuth: a 3-D body or stack moves in all directions at once; give orientation"),
    ({"scene": {"name": "x"}}, "scene"),
    (GRAVESTONE_WITH_STACK_VARIANT, "variants.stack.scene: only a study with a scene can have a variant"),
    ({"density": 2000}, "density: nothing depends on it in 3-D"),
    ({"contact": {"stiffness": 1e6}}, "in 3-D the stiffness is auto"),
    ({"variants": {"hard": {"contact": {"damping": 3500}}}}, "variants.hard.contact: in 3-D the stiffness is auto"),
    ({"ensemble": {"initial_tilt": 0.01}}, "a 3-D body starts at rest"),
    ({"simulation": {"scheme": "cundall"}}, "simulation.scheme: a 3-D body supports 'centred' only"),
    ({"population": {}, "body": {"plan": "circle"}}, "of square plan; give body"),
    ({"population": {}, "body": {"aspect": [2]}}, "of square plan; give body"),
]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        *WRONG_2D_SETTINGS,
        *(({"scene": "three-tier"} | change, expected) for change, expected in WRONG_SCENE_SETTINGS),
        *((STUDY_IN_3D | change, expected) for change, expected in WRONG_3D_SETTINGS),
    ],
)
def test_each_wrong_key_or_value_of_a_study_gives_a_line_with_the_remedy(
    change: dict, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(CONFIG_FOLDER.parent)  # from where scenes are named
    with pytest.raises(ConfigError) as caught:
        study_from_content(
            {key: value for key, value in (SMALL_STUDY | change).items() if value is not None}, "mine.yaml"
        )
    text = str(caught.value)
    assert expected in text
    assert all(line.strip().startswith("mine.yaml: ") for line in text.split("\n"))
    assert not {"^", "constrained"} & set(text.replace("-", " ").split()), "the file has no such key"


def test_all_incompatible_settings_of_a_study_are_named_at_once() -> None:
    published = [{"record": "x", "azimuth": 31, "b_over_h": 0.25, "overturns": True}]
    planes = {
        "figures": {"height": 0.7}, "primary": {"statistic": "fall_rate", "against": "soft"}, "published": published,
        "asks": "vertical",
    }  # fmt: skip
    space = {"orientation": {"step": 7}, "density": 2000, "contact": {"damping": 9}}
    for change, keys in (
        (
            planes,
            ["primary.statistic", "primary.against", "figures.height", "published", "published", "published"],
        ),
        (STUDY_IN_3D | space, ["density", "orientation", "contact"]),
    ):
        with pytest.raises(ConfigError) as caught:
            study_from_content(SMALL_STUDY | change, "mine.yaml")
        lines = str(caught.value).split("\n       ")
        assert [line.split(": ")[:3] for line in lines] == [["mine.yaml", "the study", key] for key in keys]


def test_a_record_missing_from_the_record_table_is_named_with_a_suggestion() -> None:
    study = study_from_content({"name": "small", "records": {"use": ["rinaldy"]}}, "mine.yaml")
    with pytest.raises(ConfigError, match=r"mine.yaml: records.use: 'rinaldy' is not in .*did you mean rinaldi\?"):
        read_record_table_rows_of_study(study, "mine.yaml", CONFIG_FOLDER.parent)


def test_error_outside_the_project_says_where_to_run_the_study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    study = study_from_content({"name": "small", "records": {"use": ["my-own"]}}, "mine.yaml")
    with pytest.raises(ConfigError, match="there is none here but the package's: run in the study's project"):
        read_record_table_rows_of_study(study, "mine.yaml")


def test_an_unreadable_study_file_gives_a_plain_error(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none\.yaml: cannot be read \(.*\); check its name and permissions$"):
        load_study(tmp_path / "none.yaml")
    for text, expected in (("name: [", "line 1"), ("- 1", "a study is a mapping"), ("name: \udcff", "UTF-8")):
        path = tmp_path / "bad.yaml"
        path.write_bytes(text.encode("utf-8", "surrogateescape"))
        with pytest.raises(ConfigError, match=expected):
            load_study(path)


def test_settings_of_a_study_cannot_be_changed() -> None:
    study = study_from_content(SMALL_STUDY, "mine.yaml")
    with pytest.raises(ValidationError):
        study.density = 1.0


def test_compatible_settings_of_a_study_are_accepted() -> None:
    """A study may have a population of blocks or square prisms, soil in a variant, and any stiffness above 0.

    Variants with another scene or contact are accepted, too.
    """
    assert (
        study_from_content(
            SMALL_STUDY | {"population": {"width": {"low": 0.2, "high": 0.3}}}, "x"
        ).population.height.high
        == 0.9
    )
    assert study_from_content(SMALL_STUDY | {"body": {}, "population": {}}, "x").population.rotated == 5.0
    assert study_from_content(SMALL_STUDY | {"variants": {"soft": SOIL}}, "x").variants["soft"].site.motion == "outcrop"
    assert study_from_content(SMALL_STUDY | {"contact": {"stiffness": 0.5}}, "x").contact.stiffness == 0.5
    block = {"block": {"scene": "gravestone", "contact": {"damping_ratio": 0.5}}}
    both = {
        "scene": SCENE_WITH_ITS_OWN_FRICTION,
        "friction": [0.2, 1.0],
        "variants": {"stack": {"scene": "three-tier"}},
    }
    assert study_from_content(SMALL_STUDY | both, "x").friction == (0.2, 1.0)
    assert (
        study_from_content(SMALL_STUDY | {"scene": "three-tier", "variants": block}, "x").variants["block"].contact
        is not None
    )


def test_missing_contact_keys_of_a_variant_default_to_the_study() -> None:
    variants = {"ringing": {"contact": {"damping": 9}}, "hard": {"contact": {"stiffness": "auto"}}}
    own = {"stiffness": 1e7, "stiffness_ratio": 0.5, "damping_ratio": 1.0}
    study = study_from_content(SMALL_STUDY | {"contact": own, "variants": variants}, "x")
    assert variant_contact_settings(study, "ringing") == ContactSettings(stiffness=1e7, stiffness_ratio=0.5, damping=9)
    assert variant_contact_settings(study, "hard") == ContactSettings(stiffness_ratio=0.5, damping_ratio=1.0)
    for left_out in ((), {"contact"}):  # as a step of the workflow may be given it
        part = study_from_content(study.model_dump(mode="json", exclude=left_out), "x")
        assert part.variants == study.variants


@pytest.mark.parametrize("key", ["[]", "../../etc/passwd", "", "<b>"])
def test_an_unknown_key_unlike_any_other_is_named_without_a_suggestion(key: str) -> None:
    with pytest.raises(ConfigError, match="unknown key; known are ") as problem:
        study_from_content({"name": "a", "records": {"use": ["b"]}, key: 1}, "mine.yaml")
    assert str(problem.value).startswith(f'mine.yaml: "{key}": unknown key')


def test_malformed_or_huge_yaml_values_of_a_study_give_a_short_error(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    twice = "a: &a [x,x,x,x,x,x,x,x,x]\n" + "".join(
        f"{name}: &{name} [{','.join([f'*{last}'] * 9)}]\n" for last, name in zip("abcdefgh", "bcdefghi", strict=True)
    )
    for text in (
        "name: 2001-02-30",
        "name: " + "9" * 5000,
        "name: !!bool x",
        "[" * 600,
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
def test_a_value_with_a_unit_is_converted_to_the_unit_of_its_key(value: object, unit: str, expected: float) -> None:
    assert parse_quantity(value, unit) == expected


def test_lengths_of_a_population_may_have_units_but_frictions_may_not() -> None:
    given = {"width": {"low": "30 cm", "high": 0.4}, "height": {"low": "0.6 m", "high": "900 mm"}}
    population = StonePopulation.model_validate(given)
    assert (population.width.low, population.height.low, population.height.high) == (0.3, 0.6, 0.9)
    with pytest.raises(ValueError, match=r"friction\.low"):
        StonePopulation.model_validate({"friction": {"low": "0.5 m", "high": 0.9}})


@pytest.mark.parametrize("value", ["60 kg", "0.6 ft", "60 cm 3", "tall", None, True, [1.0]])
def test_a_value_with_a_wrong_unit_or_without_a_number_is_refused(value: object) -> None:
    with pytest.raises(ValueError, match="m"):
        parse_quantity(value, "m")


def test_reading_a_record_that_the_study_lacks_is_refused(tmp_path: Path) -> None:
    study = '{"name": "small", "records": {"use": ["rinaldi"]}}'
    with expect_error(ArgumentError, "--record gone: not in the study small; it has rinaldi"):
        read_and_process_record(study, "gone", tmp_path / "gone.nc")


@pytest.mark.parametrize(
    "timed",
    [{"step": "cut", "start_s": 5}, {"step": "baseline", "fit_from_s": 5}, {"step": "remove_mean", "first_s": 5}],
)
def test_processing_steps_with_a_time_are_refused_after_a_filter_with_automatic_corner(
    timed: dict[str, object],
) -> None:
    auto = {"step": "highpass", "corner_hz": "auto"}
    with expect_error(
        ConfigError, "processing", f"{timed['step']} after highpass with corner_hz auto", "before it, or give"
    ):
        study_from_content(SMALL_STUDY | {"processing": [auto, {"step": "detrend"}, timed]}, "small.yaml")
    for steps in ([timed, auto], [auto | {"corner_hz": 0.1}, timed], [auto, {"step": "remove_mean"}]):
        assert len(study_from_content(SMALL_STUDY | {"processing": steps}, "small.yaml").processing or ()) == 2
