"""The page to look around in a cube: its data are the cube's."""

import base64
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from overturning.errors import ArgumentError
from overturning.figures import explore
from overturning.figures.explore import explorer_data, write_explorer

DIMENSIONS = ("record", "azimuth", "height", "b_over_h", "friction")
BAD = "</script><script>window.hurt = 1</script>"


def cube(records: int = 2, step: int = 30, ratios: int = 3, heights: int = 2, frictions: int = 2) -> xr.Dataset:
    """Random outcomes, with an ensemble, some of them missing."""
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
            "station": ("record", [BAD] * records),
            "event": ("record", [f"E {n}" for n in range(records)]),
            "fault_normal": ("record", [np.nan, *[30.0] * (records - 1)]),
        },
        attrs={"title": BAD},
    )


def test_the_numbers_are_those_of_the_cube() -> None:
    whole = cube()
    data = explorer_data(whole)
    shape = tuple(whole.sizes[name] for name in DIMENSIONS)
    flags = np.frombuffer(base64.b64decode(data["data"]["flag"]), "i1").reshape(shape)
    np.testing.assert_array_equal(np.where(flags == 2, np.nan, flags), whole["overturned"])
    time = np.frombuffer(base64.b64decode(data["data"]["time"]), "<u2").reshape(shape)
    np.testing.assert_allclose(np.where(time == 65535, np.nan, time * 0.01), whole["overturning_time"], atol=0.00501)
    towards = np.frombuffer(base64.b64decode(data["data"]["towards"]), "u1").reshape(shape)
    np.testing.assert_allclose(
        np.where(towards == 255, np.nan, towards / 200), whole["probability_towards"], atol=0.0026
    )


def test_the_default_study_fits_and_is_the_same_bytes_each_time(tmp_path: Path) -> None:
    large = cube(records=28, step=5, ratios=11, frictions=3)
    assert large["overturned"].size == 133_056
    for name in ("a.html", "b.html"):
        write_explorer(large, tmp_path / name)
    page = (tmp_path / "a.html").read_bytes()
    assert page == (tmp_path / "b.html").read_bytes()
    assert len(page) < 5_000_000
    assert b"http" not in page
    assert b"src=" not in page


def test_a_cube_too_large_for_a_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(explore, "MOST_CELLS", 10)
    with pytest.raises(ArgumentError, match="too many for a page, at most 10; choose records with --record"):
        explorer_data(cube())
