"""Motions made of a formula or of an obspy Stream."""

import numpy as np
import pytest

from overturning.errors import ArgumentError
from overturning.motion.motion import Motion


def test_a_sine_has_its_amplitude_and_direction() -> None:
    motion = Motion.sine(3.0, 0.8, azimuth_deg=60, cycles=2, rest=0.5)
    assert motion.duration == pytest.approx(2.6)
    assert motion.along(60).max() == pytest.approx(3.0, rel=1e-4)
    assert np.abs(motion.along(150)).max() < 1e-9
    assert np.abs(motion.along(60)[:101]).max() < 1e-9
    assert motion.along(60)[100 + 280] == pytest.approx(-3.0)  # 1.4 s: 1¾ cycles
    with pytest.raises(ArgumentError, match="period: 0"):
        Motion.sine(3.0, 0)


def stream(*channels: str, npts: int = 100):  # type: ignore[no-untyped-def]
    from obspy import Stream, Trace

    header = {"delta": 0.01, "calib": 2.0}
    return Stream([Trace(np.full(npts, float(n)), {**header, "channel": c}) for n, c in enumerate(channels, 1)])


@pytest.mark.parametrize("channels", [("HNN", "HNE", "HNZ"), ("NS2", "EW2", "UD2")])
def test_from_obspy(channels: tuple[str, ...]) -> None:
    motion = Motion.from_obspy(stream(*channels))
    assert (motion.north[0], motion.east[0], motion.up[0]) == (2.0, 4.0, 6.0)  # type: ignore[index]
    assert motion.sampling_interval == 0.01


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        (("HNN", "HNZ"), "no component towards east"),
        (("HN1", "HN2"), "neither N, E nor Z"),
        (("HNN", "HNN"), "stands twice"),
    ],
)
def test_streams_that_are_no_motion(channels: tuple[str, ...], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        Motion.from_obspy(stream(*channels))
