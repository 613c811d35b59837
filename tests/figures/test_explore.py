"""The data of the explorer page match the cube."""

import base64
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from overturning.figures import explore
from overturning.figures.explore import explorer_page_data, write_explorer
from overturning.model.status import CaseStatus
from overturning.study.load import study_from_content
from overturning.translation.texts import use_translation_language

DIMENSIONS = ("record", "azimuth", "height", "b_over_h", "friction")
SCRIPT_AS_NAME = "</script><script>window.hurt = 1</script>"


def random_planar_cube(
    records: int = 2, step: int = 30, ratios: int = 3, heights: int = 2, frictions: int = 2
) -> xr.Dataset:
    """Return a 2-D cube with an ensemble and random outcomes, some of which are missing."""
    random = np.random.Generator(np.random.PCG64(1))
    azimuth = np.arange(0, 360, step)
    shape = (records, azimuth.size, heights, ratios, frictions)
    flags = random.integers(-1, 2, shape).astype(np.float32)
    flags[random.random(shape) < 0.05] = np.nan
    towards = np.where(np.isnan(flags), np.nan, np.clip(flags, 0, 1) * 0.75)
    values = {
        "overturned": flags,
        "probability_towards": towards,
        "probability_away": np.where(np.isnan(flags), np.nan, np.clip(-flags, 0, 1) * 0.5),
        "peak_rotation": random.random(shape) * 3,
        "overturning_time": np.where(np.abs(flags) == 1, random.random(shape) * 20, np.nan),
    }
    return xr.Dataset(
        {name: (DIMENSIONS, part) for name, part in values.items()},
        coords={
            "azimuth": azimuth,
            "height": 0.6 * (1 + np.arange(heights)),
            "b_over_h": np.linspace(0.1, 0.6, ratios),
            "friction": np.linspace(0.3, 1.0, frictions),
            "record_id": ("record", [f"r{n}" for n in range(records)]),
            "station": ("record", [SCRIPT_AS_NAME] * records),
            "event": ("record", [f"E {n}" for n in range(records)]),
            "fault_normal": ("record", [np.nan, *[30.0] * (records - 1)]),
        },
        attrs={"title": SCRIPT_AS_NAME},
    )


def random_3d_cube() -> xr.Dataset:
    """Return a 3-D cube of random outcomes without an ensemble, with falls at the first two B/H only."""
    random = np.random.Generator(np.random.PCG64(2))
    shape = (2, 6, 1, 5, 2, 2)
    fell = random.random(shape) < 0.6
    fell[:, :, :, 2:] = False
    values = {
        "overturned": fell.astype(np.float32),
        "fall_azimuth": np.where(fell, random.random(shape) * 360, np.nan),
        "peak_tilt": np.where(fell, 90.0, random.random(shape) * 20),
        "overturning_time": np.where(fell, random.random(shape) * 20, np.nan),
    }
    dimensions = ("record", "orientation", "height", "b_over_h", "aspect", "friction")
    return xr.Dataset(
        {name: (dimensions, part) for name, part in values.items()},
        coords={
            "orientation": np.arange(0, 90, 15), "height": [0.6], "b_over_h": 0.1 * np.arange(1, 6),
            "aspect": [1.0, 2.0], "friction": [0.5, 1.0],
            "record_id": ("record", ["r0", "r1"]), "station": ("record", ["S", "S"]),
            "event": ("record", ["E", "F"]), "fault_normal": ("record", [np.nan, 30.0]),
        },
        attrs={"title": "in space"},
    )  # fmt: skip


def decode_outcome_variable_of_page(data: dict[str, Any], name: str, kind: str, shape: tuple[int, ...]) -> np.ndarray:
    """Decode one variable of the explorer page for all records, with NaN for missing values."""
    parts = [np.frombuffer(base64.b64decode(record["cells"][name]), kind) for record in data["records"]]
    values = np.concatenate(parts).reshape(shape)
    missing = 2 if kind == "i1" else np.iinfo(kind).max
    return np.where(values == missing, np.nan, values)


def test_explorer_page_data_match_the_cube() -> None:
    whole = random_planar_cube()
    runs = np.resize([share for n in (8, 16, 24) for share in np.arange(n + 1) / n], whole["overturned"].shape)
    whole["probability_towards"][:] = runs
    whole["probability_towards"][0, 1:4] = np.nan  # of neighbourhoods that were not run nothing is known
    data = explorer_page_data(whole)
    shape = tuple(whole.sizes[name] for name in DIMENSIONS)
    np.testing.assert_array_equal(decode_outcome_variable_of_page(data, "flag", "i1", shape), whole["overturned"])
    time, towards = (
        decode_outcome_variable_of_page(data, "time", "<u2", shape),
        decode_outcome_variable_of_page(data, "towards", "u1", shape),
    )
    np.testing.assert_allclose(time * 0.01, whole["overturning_time"], atol=0.00501)
    np.testing.assert_allclose(towards * data["steps"]["chance"], whole["probability_towards"], rtol=1e-6)


def test_the_flag_of_a_case_without_an_outcome_encodes_the_reason() -> None:
    whole = random_planar_cube(records=1, heights=1, frictions=1)
    status = xr.full_like(whole["overturned"], CaseStatus.SIMULATED, dtype=np.int8)
    for place, reason in enumerate((CaseStatus.UNDECIDED, CaseStatus.UNSTABLE, CaseStatus.OVER_BUDGET, 0)):
        whole["overturned"][0, place] = np.nan
        status[0, place] = reason
    shape = tuple(whole.sizes[name] for name in DIMENSIONS)
    found = decode_outcome_variable_of_page(explorer_page_data(whole.assign(status=status)), "flag", "i1", shape)
    assert found[0, :3, 0, 0, 0].tolist() == [12, 13, 15]
    assert np.isnan(found[0, 3]).all()
    np.testing.assert_array_equal(found[0, 4:], whole["overturned"][0, 4:])


def test_late_fall_in_a_long_record_keeps_its_time_in_the_explorer() -> None:
    """The page stores times in 16 bits: with a fixed step of 0.01 s, times would end at 655.34 s."""
    whole = random_planar_cube()
    whole["overturning_time"][1] *= 180.0
    data, shape = explorer_page_data(whole), tuple(whole.sizes[name] for name in DIMENSIONS)
    steps = [record["cells"]["timeStep"] for record in data["records"]]
    found = decode_outcome_variable_of_page(data, "time", "<u2", shape) * np.reshape(steps, (2, 1, 1, 1, 1))
    assert found[1].max(initial=0.0, where=np.isfinite(found[1])) > 3000.0
    np.testing.assert_allclose(found[0], whole["overturning_time"][0], atol=0.00501)
    np.testing.assert_allclose(found[1], whole["overturning_time"][1], atol=0.03)


def test_explorer_map_of_a_3d_body_ends_at_the_first_ring_without_falls() -> None:
    whole = random_3d_cube()
    data = explorer_page_data(whole)
    shape = whole["overturned"].shape
    np.testing.assert_array_equal(decode_outcome_variable_of_page(data, "flag", "i1", shape), whole["overturned"])
    for name, variable in (("azimuth", "fall_azimuth"), ("rotation", "peak_tilt")):
        found = decode_outcome_variable_of_page(data, name, "<u2", shape) * data["steps"][name]
        np.testing.assert_allclose(found, whole[variable], atol=0.00501)
    assert data["rings"] == 3
    whole["overturned"][1, 2, 0, 3, 1, 0] = np.nan  # and farther where it may fall, on one scale for all records
    assert explorer_page_data(whole)["rings"] == 5
    assert (data["space"], data["degrees"]) == (True, [True])


def test_explorer_rotations_without_a_critical_angle_are_in_degrees() -> None:
    both = (
        xr.concat([random_planar_cube(), random_planar_cube()], "element")
        .transpose(*DIMENSIONS, "element")
        .assign_coords(element=["a", "b"])
    )
    both["critical_angle"] = ("element", "b_over_h"), np.array([[0.1, 0.2, 0.3], [np.nan] * 3])
    both = both.isel(record=[0])
    assert explorer_page_data(both.isel(element=[0]))["degrees"] == [False]
    both["peak_rotation"] *= 100.0
    data = explorer_page_data(both.isel(element=[1]))
    assert data["degrees"] == [True]
    found = (
        decode_outcome_variable_of_page(data, "rotation", "<u2", tuple(both.sizes[name] for name in DIMENSIONS))
        * data["steps"]["rotation"]
    )
    np.testing.assert_allclose(found, both["peak_rotation"][..., 1], atol=0.00501)  # 65.5° were the largest


@pytest.mark.parametrize(
    ("name", "variable", "unit"),
    [("rotation", "peak_tilt", 0.1), ("azimuth", "fall_azimuth", 1.0), ("rotation", "peak_rotation", 0.01)],
    ids=["tenth of a degree", "degree", "percent of the toppling angle"],
)
def test_storage_in_explorer_page_does_not_change_rounding(name: str, variable: str, unit: float) -> None:
    """A value just below the middle between two printed numbers is not rounded up by its storage in the page."""
    whole = random_planar_cube(records=1) if variable == "peak_rotation" else random_3d_cube().isel(record=[0])
    spread = unit * np.linspace(0.0, 40.0, whole[variable].size)
    spread[::2] = unit * (np.floor(spread[::2] / unit) + 0.4999)
    whole[variable] = whole[variable].dims, spread.reshape(whole[variable].shape)
    data = explorer_page_data(whole)
    found = decode_outcome_variable_of_page(data, name, "<u2", whole[variable].shape) * data["steps"][name]
    np.testing.assert_array_equal(np.floor(found / unit + 0.5), np.floor(whole[variable] / unit + 0.5))


def test_explorer_first_shows_the_stoutest_certain_fall_among_certain_falls() -> None:
    """A fall is certain if all runs fall. The first case shown is the stoutest with certain falls as neighbours."""
    whole = random_planar_cube(ratios=6, heights=1, frictions=1)
    for name in ("overturned", "probability_towards", "probability_away"):
        whole[name][:] = 0.0
    for name in ("overturned", "probability_towards"):
        whole[name][1, [11, 0, 1], 0, :4] = 1.0  # across north: the neighbours of 0° are 330° and 30°
        whole[name][:, 6, 0, 5] = 1.0
        whole[name][0, 4:7, 0, :2] = 1.0
    whole["probability_towards"][0, 4, 0, 0] = 0.9
    data = explorer_page_data(whole)
    assert data["shown"]["record"] == 1
    assert data["records"][1]["clear"] == [0, 2]
    whole["probability_towards"][1, [11, 0, 1]] = np.nan  # nothing is known of runs that were not made
    whole["probability_away"][1, [11, 0, 1]] = np.nan
    assert explorer_page_data(whole)["records"][1]["clear"] == [6, 5]
    whole["overturned"][:], whole["probability_towards"][:] = 0.0, 0.0
    whole["probability_towards"][0, 3, 0, 2] = 0.25  # nothing falls in every run: the likeliest fall
    assert explorer_page_data(whole)["records"][0]["clear"] == [3, 2]


def test_explorer_time_scale_spans_falls_and_gaps_are_marked_as_not_computed() -> None:
    whole = random_planar_cube(records=3)
    whole["overturning_time"][:] = whole["overturning_time"].where(whole["record"] != 2)
    data = explorer_page_data(whole.isel(azimuth=[0, 1, 2]))
    for index in (0, 1):
        falls = whole["overturning_time"][index, :3].to_numpy()
        np.testing.assert_allclose(data["records"][index]["times"], [np.nanmin(falls), np.nanmax(falls)], atol=1e-6)
    assert data["records"][2]["times"] is None
    known = [azimuth for azimuth, there in zip(data["direction"], data["computed"], strict=True) if there]
    assert known == [0, 30, 60, 180, 210, 240]
    assert len(known) < len(data["direction"])


def test_explorer_page_has_title_question_and_report_link_of_the_study(tmp_path: Path) -> None:
    study = study_from_content(
        {"name": "a", "title": "Named", "question": "Where to?", "records": {"use": ["r0"]}}, "study"
    )
    for report in ("report.html", ""):
        write_explorer(random_planar_cube(), tmp_path / "look.html", study, report)
        text = (tmp_path / "look.html").read_text(encoding="utf-8")
        assert "<h1>Named</h1>" in text
        assert "Where to?" in text
        assert re.findall(r'href="([^"]*)"', text) == [report] * bool(report)


def test_film_command_in_the_explorer_has_the_language_of_the_page() -> None:
    for language, option in (("en", []), ("ja", ["--language", "ja"])):
        with use_translation_language(language):
            assert explorer_page_data(random_planar_cube())["film"]["options"] == option


def test_explorer_page_of_the_default_study_is_small_and_reproducible(tmp_path: Path) -> None:
    large = random_planar_cube(records=28, step=5, ratios=11, frictions=3)
    assert large["overturned"].size == 133_056
    write_explorer(large, tmp_path / "large.html")
    page = (tmp_path / "large.html").read_bytes()
    for name in ("a.html", "b.html"):
        write_explorer(random_planar_cube(), tmp_path / name)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()
    assert len(page) < 5_000_000
    assert b"http" not in page
    assert b"src=" not in page


def test_explorer_of_a_large_cube_has_a_file_for_each_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(explore, "MAX_CELLS_OF_SINGLE_EXPLORER_PAGE", 10)
    write_explorer(random_planar_cube(), tmp_path / "look.html")
    page, data = (tmp_path / "look.html").read_text(encoding="utf-8"), explorer_page_data(random_planar_cube())
    assert '"folder":"look-records"' in page
    assert '"cells"' not in page
    for index, record in enumerate(data["records"]):
        text = (tmp_path / "look-records" / f"{index}.js").read_text(encoding="utf-8")
        number, _, cells = text.removeprefix("explorerRecord(").removesuffix(");\n").partition(",")
        assert (int(number), json.loads(cells)) == (index, record["cells"])
