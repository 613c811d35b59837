"""What a user meets in Python."""

import pydoc
from pathlib import Path

import numpy as np
import pytest

import overturning
from overturning.errors import ArgumentError, ConfigError
from overturning.motion.motion import Motion


def test_names_versions_and_help() -> None:
    assert set(overturning.__all__) <= set(dir(overturning))
    assert overturning.__version__[0].isdigit()
    text = pydoc.plain(pydoc.render_doc(overturning))
    for name in overturning.__all__:
        assert name in text
        assert (getattr(overturning, name).__doc__ or "").strip()
    assert (Path(overturning.__file__).parent / "py.typed").is_file()


def test_a_stream_where_a_motion_belongs_gets_a_sentence() -> None:
    from obspy import Stream

    with pytest.raises(ArgumentError, match=r"an obspy Stream; make it a motion by Motion\.from_obspy"):
        overturning.simulate(Stream(), azimuth_deg=[0])
    with pytest.raises(ArgumentError, match=r"a ndarray; give a Motion"):
        overturning.trajectory(np.zeros(3), azimuth_deg=0)  # type: ignore[arg-type]


def test_read_simulate_and_study(tmp_path: Path) -> None:
    wave = Motion.sine(6.0, 0.8, azimuth_deg=60)
    time = np.arange(wave.samples) * wave.sampling_interval
    rows = [f"{t:.3f},{100 * n:.6f},{100 * e:.6f}" for t, n, e in zip(time, wave.north, wave.east, strict=True)]
    (tmp_path / "pulse.csv").write_text("\n".join(["time,north,east", *rows]) + "\n", encoding="utf-8")
    columns = "time:s north:gal east:gal"
    record = overturning.read(tmp_path / "pulse.csv", columns=columns, processed=True)
    assert Motion.from_record(record).along(60).max() == pytest.approx(6.0, rel=1e-3)
    with pytest.raises(ArgumentError, match="units: no declaration of a record; known are "):
        overturning.read(tmp_path / "pulse.csv", units="gal")
    grid = {"b_over_h": [0.2, 0.4], "height": [0.6], "friction": [1.0]}
    outcome = overturning.simulate(record, azimuth_deg=[60, 150, 240, 330], **grid)
    cube = overturning.run_study([record], azimuth={"step": 30}, ensemble={"members": 0}, **grid)
    assert cube["record_id"].to_numpy().tolist() == ["pulse"]
    np.testing.assert_array_equal(
        cube["overturned"].sel(azimuth=[60, 150, 240, 330]).squeeze("record").to_numpy(),
        outcome["overturned"].to_numpy(),
    )
    with pytest.raises(ConfigError, match="azimth: unknown key; did you mean azimuth"):
        overturning.run_study([record], azimth={"step": 30})
