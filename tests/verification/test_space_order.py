"""Bodies in space converge with the step."""

from verification.space_order import orders


def test_tilt_and_azimuth_of_the_fall_converge() -> None:
    (tilt, tilts), (_, azimuths) = orders("centred").values()
    assert tilt >= 0.8, tilts
    # Which points press and slide is decided anew at each step: below some thousandths of a degree the azimuth no longer follows it.
    assert azimuths[0] < 1e-3
    assert azimuths[-1] < azimuths[0]
