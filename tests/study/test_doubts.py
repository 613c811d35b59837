"""`study check` doubts values in another unit, and none of the shipped studies."""

import json
import math
from pathlib import Path
from typing import Any

import pytest

from overturning.dem.polygon.prepare import reason_scene_moves_by_itself
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.study.doubts import implausible_setting_warnings, warnings_on_ranges_not_reaching_their_stop
from overturning.study.load import load_study, study_from_content
from tests.dem.test_polygon_fallen import arch_scene
from tests.expect import run_overturning_and_return_printed_text
from tests.sources import shipped_files

CONFIG_FOLDER = Path(__file__).parents[2] / "config"
PULSE_RECORD_SETTINGS = {"use": [], "pulses": {"p1": "sine amplitude_gal=300 period_s=1 azimuth_deg=60"}}
GRID = {"b_over_h": [0.3, 0.7], "height": [0.6, 0.9], "friction": [0.5, 0.9]}
"""The sizes of the default population."""
POPULATION_OF_ONE_SIZE = {"width": {"low": 0.25, "high": 0.25}, "height": {"low": 0.75, "high": 0.75}}
"""Sizes of a population of equal stones with B/H = 1/3."""


def soil_site_settings(velocity: float, rock_velocity: float = 760.0, **more: float) -> dict[str, Any]:
    """Return the settings of a soil layer of 20 m over rock, with velocities in m/s."""
    return {"layers": [{"thickness_m": 20, "velocity_m_s": velocity, **more}], "rock": {"velocity_m_s": rock_velocity}}


def warnings_on_study_settings(**keys: Any) -> list[str]:
    """Return the warnings on implausible settings of a study."""
    return list(
        implausible_setting_warnings(
            study_from_content({"name": "mine", "records": PULSE_RECORD_SETTINGS} | keys, "mine.yaml")
        )
    )


@pytest.mark.parametrize("path", shipped_files("config/*.yaml"), ids=lambda path: path.stem)
def test_no_shipped_study_gives_a_warning_on_its_settings(path: Path) -> None:
    assert list(implausible_setting_warnings(load_study(path))) == []


def test_variants_that_repeat_the_settings_of_others_give_a_warning() -> None:
    """A variant whose settings repeat those of the study or of an earlier variant gives a warning.

    Of five variants the first equals the study itself, the third repeats the second, and the fifth repeats the
    fourth, which is on soil.
    """
    variants = {
        "same": {"vertical": True}, "flat": {"vertical": False}, "level": {"vertical": False},
        "clay": {"vertical": False, "site": soil_site_settings(200)}, "soil": {"vertical": False,
        "site": soil_site_settings(200)},
    }  # fmt: skip
    assert [line.partition(" are those of ")[::2] for line in warnings_on_study_settings(variants=variants)] == [
        (f"variants.{name}: its settings", f"{whose}, and so are its outcomes; change or leave it out")
        for name, whose in (("same", "the study"), ("level", "the variant flat"), ("soil", "the variant clay"))
    ]


def test_a_range_that_does_not_reach_its_stop_gives_a_warning() -> None:
    content = {"name": "mine", "b_over_h": {"start": 0.1, "stop": 0.6, "step": 0.15}, "height": [0.6]}
    assert list(warnings_on_ranges_not_reaching_their_stop(content)) == [
        "b_over_h: steps of 0.15 end at 0.55, before stop 0.6; change step or stop"
    ]
    sound = {"b_over_h": {"start": 0.1, "stop": 0.6, "step": 0.05}, "azimuth": {"start": 0, "stop": 360, "step": 5}}
    assert list(warnings_on_ranges_not_reaching_their_stop(sound)) == []


def test_only_a_length_outside_the_grid_is_suspected_to_be_in_centimetres() -> None:
    """Frictions and heights of a population lie outside the grid of the study.

    Only for the heights does the warning suggest centimetres.
    """
    lines = warnings_on_study_settings(friction=[1.0], height=[0.3], b_over_h=[0.3, 0.7], population={})
    remedies = {line.partition(":")[0]: line.rpartition("; ")[2] for line in lines}
    assert remedies["population.friction"] == "those stones take the nearest value: add values to friction"
    assert remedies["population.height"].endswith("add values to height, or is a size in centimetres?")


@pytest.mark.parametrize(
    ("keys", "sound", "line"),
    [
        (
            {"azimuth": {"start": 60, "stop": 120, "step": 20}},
            {"azimuth": {"start": 60, "stop": 240, "step": 20}},
            "azimuth: planes along 60, 80, 100 (degrees); falls lie in these planes whatever the motion",
        ),
        ({"azimuth": {"start": 32, "stop": 33}}, {}, "azimuth: 32 only (degrees); falls lie in these planes"),
        (
            {
                "asks": "vertical",
                "primary": {"statistic": "share", "against": "flat"},
                "variants": {"flat": {"vertical": False, "contact": {"damping_ratio": 0.3}}},
            },
            {
                "asks": "vertical",
                "primary": {"statistic": "share", "against": "flat"},
                "variants": {"flat": {"vertical": False}},
            },
            "primary.against: the variant flat differs from the study in contact and vertical; no difference can be",
        ),
        (
            {"site": soil_site_settings(0.2)},
            {"site": soil_site_settings(30)},
            "site.layers.0.velocity_m_s: 0.2 m/s below 30 m/s; km/s? Give 200",
        ),
        (
            {"site": soil_site_settings(150, 0.76)},
            {"site": soil_site_settings(150)},
            "site.rock.velocity_m_s: 0.76 m/s below 30 m/s; km/s?",
        ),
        (
            {"surveys": [{"stones": "a.csv", "sites": {"River": soil_site_settings(0.15)}}]},
            {"surveys": [{"stones": "a.csv", "sites": {"River": soil_site_settings(150)}}]},
            "surveys.0.sites.River.layers.0.velocity_m_s: 0.15 m/s below 30 m/s; km/s? Give 150",
        ),
        (
            {"variants": {"soft": {"site": soil_site_settings(0.15)}}},
            {"variants": {"soft": {"site": soil_site_settings(150)}}},
            "variants.soft.site.layers.0.velocity_m_s: 0.15 m/s below 30 m/s; km/s? Give 150",
        ),
        (
            {"site": soil_site_settings(150, density_kg_m3=180)},
            {"site": soil_site_settings(150)},
            "site.layers.0.density_kg_m3: 180 kg/m³ outside",
        ),
        (
            {"friction": [0.5, 30]},
            {"friction": [3]},
            "friction: 30 above 3. An angle of friction in degrees?",
        ),
        ({"b_over_h": [0.4, 2.5]}, {"b_over_h": [1.5]}, "b_over_h: 2.5 above 1.5; H/B? Give width over height: 0.4"),
        ({"amplitude": [1, 50]}, {"amplitude": [1, 10]}, "amplitude: 50 above 10; per cent, or a peak?"),
        (  # 2650 kg/m³ · 0.6 m · 9.80665 m/s² / (2 · 1 N/m), and the stiffness at which that is 0.1
            {"contact": {"stiffness": 1}, "height": [0.3, 0.6]},
            {"contact": {"stiffness": 8e4}, "height": [0.3, 0.6]},
            "contact.stiffness: 1 N/m; a block 0.6 m high sinks by 7.8e+03 of its width; give at least 7.8e+04",
        ),
        ({"density": 2.65}, {"density": 1000}, "density: 2.65 kg/m³ outside 1,000 to 8,000 kg/m³; g/cm³? Times 1000"),
        ({"density": 26}, {"density": 8000}, "density: 26 kg/m³ outside 1,000 to 8,000 kg/m³; kN/m³? Times 102"),
        (
            GRID | {"population": {"height": {"low": 6, "high": 9}, "width": {"low": 3, "high": 4}}},
            GRID | {"population": {}},
            "population.height: 6.03 to 8.97, of which 100 % outside the study's height, 0.6 to 0.9",
        ),
        (
            GRID | {"population": {"width": {"low": 0.05, "high": 0.1}}},
            GRID | {"population": {"width": {"low": 0.3, "high": 0.4}}},
            "population.width over height: 0.0563 to 0.165, of which 100 % outside the study's b_over_h, 0.3 to 0.7",
        ),
        (
            GRID | {"friction": [1.0], "population": {}},
            GRID | {"population": {}},
            "population.friction: 0.504 to 0.896, of which 100 % outside the study's friction, 1",
        ),
        (  # 1/3 is 0.33, but not 0.32
            GRID | {"b_over_h": [0.32], "population": POPULATION_OF_ONE_SIZE},
            GRID | {"b_over_h": [0.33], "population": POPULATION_OF_ONE_SIZE},
            "population.width over height: 0.333 to 0.333, of which 100 % outside the study's b_over_h, 0.32",
        ),
    ],
)
def test_values_that_seem_to_be_in_another_unit_give_a_warning(
    keys: dict[str, Any], sound: dict[str, Any], line: str
) -> None:
    """A value at the bound of what is plausible gives no warning, and a value beyond the bound gives one."""
    assert warnings_on_study_settings(**sound) == []
    (doubt,) = warnings_on_study_settings(**keys)
    assert doubt.startswith(line)


def test_implausible_materials_and_contacts_of_a_scene_give_a_warning() -> None:
    scene: dict[str, Any] = {
        "name": "mine",
        "materials": {"stone": {"density": 2.65}},
        "contacts": [{"between": ["stone", "stone"], "friction": 40}],
        "elements": [
            {"name": "ground", "kind": "driven", "vertices": [[-5, -1], [5, -1], [5, 0], [-5, 0]], "material": "stone"},
            {"name": "shaft", "vertices": [[-0.1, 0], [0.1, 0], [0.1, 0.6], [-0.1, 0.6]], "material": "stone"},
        ],
    }
    density, friction = warnings_on_study_settings(scene=scene)
    assert density.startswith("scene.materials.stone.density: 2.65 kg/m³")
    assert friction.startswith("scene.contacts.0.friction: 40 above 3. An angle of friction in degrees?")
    assert friction.endswith("Give its tangent: 0.839")


def scene_of_overhanging_slab(overhang_over_half_width: float) -> dict[str, Any]:
    """Return a scene: a slab overhangs a block by `overhang_over_half_width` half-widths; with 1 it is about to tip."""
    return {
        "name": "mine",
        "elements": [
            {"name": "ground", "kind": "driven", "vertices": [[-5, -1], [5, -1], [5, 0], [-5, 0]]},
            {"name": "block", "width": 0.5, "height": 1.0, "stands_on": "ground"},
            {
                "name": "slab",
                "width": 0.5,
                "height": 0.1,
                "stands_on": "block",
                "at": [overhang_over_half_width * 0.25, 0.0],
            },
        ],
    }


def scene_of_cube_overhanging_its_foot(foot_height: float) -> dict[str, Any]:
    """Return a scene of a cube of 0.6 m that overhangs each side of its foot by 0.1 m."""
    ground = {"name": "ground", "kind": "driven", "width": 20, "height": 1, "at": [0, -1]}
    foot = {"name": "foot", "width": 0.4, "depth": 0.4, "height": foot_height, "stands_on": "ground"}
    cube = {"name": "cube", "width": 0.6, "depth": 0.6, "height": 0.6, "stands_on": "foot"}
    return {"name": "lantern", "reference": "cube", "elements": [ground, foot, cube]}


def scene_of_block_on_slope(tangent: float) -> dict[str, Any]:
    """Return a scene of a block on a slope whose angle has the given tangent."""
    ground = {"name": "slope", "kind": "driven", "vertices": [[-5, 0], [5, 0], [5, 10 * tangent]]}
    lean = math.degrees(math.atan(tangent))
    block = {"name": "block", "width": 0.5, "height": 0.5, "at": [0, 5 * tangent], "rotation_deg": -lean}
    return {"name": "mine", "elements": [ground, block]}


def test_a_scene_that_moves_without_an_earthquake_gives_a_warning() -> None:
    assert warnings_on_study_settings(scene=scene_of_overhanging_slab(0.98)) == []
    (doubt,) = warnings_on_study_settings(scene=scene_of_overhanging_slab(1.02))
    assert doubt.startswith("scene: at B/H 0.5, the scene has no equilibrium at rest: an element falls or slides")


def test_the_warning_names_the_tilt_at_which_an_overhang_meets_the_ground() -> None:
    """The warning names the tilts at which an overhanging cube meets the ground and tips over its foot.

    Along the diagonal the cube overhangs the foot by 0.1 √2 m; it balances on the foot's corner at atan(0.2 √2 /
    0.3) = 43.3°.
    """
    assert warnings_on_study_settings(scene=scene_of_cube_overhanging_its_foot(0.1), orientation={"step": 45}) == []
    (doubt,) = warnings_on_study_settings(scene=scene_of_cube_overhanging_its_foot(0.05), orientation={"step": 45})
    assert doubt.startswith(
        "scene: at B/H 1, element cube overhangs, and would meet the ground at a tilt of 20.7°, before it tips over "
        "the rim of the stone below at 43.3°. The simulation does not have this contact"
    )
    assert warnings_on_study_settings(scene=scene_of_cube_overhanging_its_foot(0.05)) == [], "2-D has the contact"


def test_a_block_on_a_slope_steeper_than_its_friction_gives_a_warning() -> None:
    assert warnings_on_study_settings(scene=scene_of_block_on_slope(0.3), friction=[0.31, 0.6]) == []
    (doubt,) = warnings_on_study_settings(scene=scene_of_block_on_slope(0.3), friction=[0.29, 0.6])
    assert doubt.startswith("scene: at B/H 1, an element slides down its face without an earthquake")


def test_frictionless_level_block_and_arch_are_stable_at_rest() -> None:
    """A level block without friction and an arch with steep, but compressed joints do not move by themselves."""
    assert warnings_on_study_settings(scene=scene_of_overhanging_slab(0.0), friction=[0.0]) == []
    assert (
        reason_scene_moves_by_itself(arch_scene(), None, reference_element_height_and_b_over_h(arch_scene())[1], 0.7)
        == ""
    )


def test_study_check_prints_warnings_and_succeeds(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    keys = {"name": "mine", "records": PULSE_RECORD_SETTINGS, "b_over_h": [2.5], "density": 2.65}
    path.write_text(json.dumps(keys), encoding="utf-8")
    text = run_overturning_and_return_printed_text("study", "check", path)
    assert f"{path}: b_over_h: 2.5 above 1.5; H/B? Give width over height: 0.4\n" in text
    assert f"{path}: density: 2.65 kg/m³ outside" in text
    assert "study 'mine', 1 record" in text
