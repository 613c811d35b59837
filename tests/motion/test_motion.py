"""Motions from a formula or from an obspy Stream."""

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import obspy
import pytest

import overturning
from overturning.errors import ArgumentError, RecordError
from overturning.motion.direction import cosine_and_sine_of_azimuth
from overturning.motion.integration import integrate
from overturning.motion.motion import Motion
from overturning.records.record import Record


def test_a_sine_motion_has_the_given_amplitude_and_direction() -> None:
    motion = Motion.sine(3.0, 0.8, azimuth_deg=60, cycles=2, rest=0.5)
    assert motion.duration == pytest.approx(2.6)
    assert motion.acceleration_along(60).max() == pytest.approx(3.0, rel=1e-4)
    assert np.abs(motion.acceleration_along(150)).max() < 1e-9
    assert np.abs(motion.acceleration_along(60)[:101]).max() < 1e-9
    assert motion.acceleration_along(60)[100 + 280] == pytest.approx(-3.0)  # 1.4 s: 1¾ cycles
    with pytest.raises(ArgumentError, match="period: 0"):
        Motion.sine(3.0, 0)
    with pytest.raises(ArgumentError, match=r"rest: -0\.2"):
        Motion.sine(3.0, 0.8, rest=-0.2)  # it would begin within the sine
    with pytest.raises(ArgumentError, match=r"period: 0\.006 s in samples of 0\.005 s.*at most 0\.0015"):
        Motion.sine(3.0, 0.006, cycles=200)  # the samples would be those of 0.03 s


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"cycles": 0.004}, r"cycles: 0\.004, 0\.004 s in samples of 0\.005 s.*at most 0\.001"),  # it would be at rest
        ({"cycles": np.nan}, "cycles: nan; it must be a positive number"),
        ({"amplitude": "strong"}, "amplitude: 'strong'; it must be a number"),
        ({"period": [1.0, 2.0]}, "period: .*positive number"),
        ({"rest": 1e12}, r"rest: 4e\+14 samples; at most 3e\+07"),
        ({"amplitude": 60.0}, "peak acceleration 6.12 g .*trust_data=True"),
    ],
)
def test_a_sine_motion_with_impossible_arguments_is_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        Motion.sine(**{"amplitude": 3.0, "period": 1.0, **arguments})  # type: ignore[arg-type]


@pytest.mark.parametrize("wrong", ["north", None, [1.0, 2.0], np.nan, np.inf])
def test_the_error_names_a_motion_argument_that_is_not_finite(wrong: object) -> None:
    motion = Motion.sine(3.0, 1.0)
    for name, call in {"azimuth_deg": motion.acceleration_along, "factor": motion.scaled_by}.items():
        with pytest.raises(ArgumentError, match=f"^{name}: .*number"):
            call(wrong)  # type: ignore[operator]
    with pytest.raises(ArgumentError, match=r"^azimuth_deg: .*number"):
        Motion.sine(3.0, 1.0, azimuth_deg=wrong)  # type: ignore[arg-type]


def test_an_implausible_sine_is_accepted_with_trust_data() -> None:
    assert Motion.sine(60.0, 0.8, trust_data=True).north.max() == pytest.approx(60.0)


@pytest.mark.parametrize("period", [0.1, 0.2, 0.3, 0.7, 1.1])
def test_a_quarter_cycle_sine_ends_at_its_peak_despite_rounding(period: float) -> None:
    motion = Motion.sine(3.0, period, cycles=0.25, rest=0.3, sampling_interval=0.001)
    assert motion.north.max() == pytest.approx(3.0, abs=1e-12)
    assert motion.north[301 + round(250 * period) :].tolist() == [0.0] * 300


def stream_of_channels(*channels: str, npts: int = 100):  # type: ignore[no-untyped-def]
    """Return an obspy stream of the channels, with samples ±n for the n-th channel."""
    from obspy import Stream, Trace

    header = {"delta": 0.01, "calib": 2.0}
    wave = (-1.0) ** np.arange(npts)
    return Stream([Trace(n * wave, {**header, "channel": c}) for n, c in enumerate(channels, 1)])


def test_the_start_time_is_preserved_from_record_to_motion_to_obspy() -> None:
    """From record to motion to obspy and back; obspy's default, 1970, is no start time."""
    wave = np.sin(2 * np.pi * np.arange(101) / 20)  # five whole waves: the velocity returns to 0
    record = Record("own", wave, wave[::-1].copy() / 2, None, 0.01, start="2020-01-01T00:00:00Z")
    for motion in (Motion.of(record), Motion.from_obspy(record.to_obspy()), Motion.of(record).scaled_by(2.0)):
        assert motion.to_obspy()[0].stats.starttime == obspy.UTCDateTime(2020, 1, 1)
    assert Motion.from_obspy(stream_of_channels("HNN", "HNE")).start is None


@pytest.mark.parametrize("key", ["network", "station", "location"])
def test_a_stream_with_components_of_different_stations_is_refused(key: str) -> None:
    several = stream_of_channels("HNN", "HNE", "HNZ")
    assert Motion.from_obspy(several).sample_count == 100
    several[1].stats[key] = "10"
    with pytest.raises(ArgumentError, match="east and north differ in station, location, start"):
        Motion.from_obspy(several)


def test_a_motion_with_masked_samples_in_any_component_is_refused() -> None:
    """Values under a mask (here 30 m/s²) must not be used."""
    samples = np.where(np.arange(200) == 70, 30.0, np.sin(np.arange(200) / 10))
    gap, still = np.ma.masked_greater(samples, 20.0), np.zeros(200)
    for of in (
        {"north": gap, "east": still},
        {"north": still, "east": gap},
        {"north": still, "east": still, "up": gap},
    ):
        with pytest.raises(ArgumentError, match="sample 70 is masked, a gap"):
            Motion(**of, sampling_interval=0.01)
    with pytest.raises(RecordError, match="record own: north: sample 70 is masked"):
        Record("own", gap, still, None, 0.01)
    whole = np.ma.masked_array(samples[:70])
    assert type(Motion(whole, whole, sampling_interval=0.01).north) is np.ndarray


@pytest.mark.parametrize("channels", [("HNN", "HNE", "HNZ"), ("NS2", "EW2", "UD2")])
def test_an_obspy_stream_gives_the_motion_of_its_components(channels: tuple[str, ...]) -> None:
    motion = Motion.from_obspy(stream_of_channels(*channels))
    assert (motion.north[0], motion.east[0], motion.up[0]) == (2.0, 4.0, 6.0)  # type: ignore[index]
    assert motion.sampling_interval == 0.01


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        (("HNN", "HNZ"), "no component towards east"),
        (("HN1", "HN2"), "neither N, E nor Z"),
        (("HNN", "HNN"), "is given twice"),
        (("HNN", "BNE"), "channels of sensors HN and BN"),
        (("DOWN", "E"), "'DOWN' is neither N, E nor Z"),  # names that end alike: down was north, S00E east
        (("N", "S00E"), "'S00E' is neither N, E nor Z"),
        (("TRAN", "N90E"), "'TRAN' is neither N, E nor Z"),
    ],
)
def test_an_invalid_obspy_stream_is_refused(channels: tuple[str, ...], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        Motion.from_obspy(stream_of_channels(*channels))


def test_a_stream_with_a_merged_gap_is_refused() -> None:
    """Values under the mask of a gap are arbitrary: here 1e9 m/s² from 0.5 s on."""
    from obspy import Stream, Trace, UTCDateTime

    pieces = Stream()
    for channel in ("HNN", "HNE"):
        for begin in (0, 1):
            header = {"delta": 0.01, "channel": channel, "starttime": UTCDateTime(2001, 1, 1) + begin}
            pieces += Trace(np.full(50, 0.1), header)
    merged = pieces.copy().merge()
    for trace in merged:
        trace.data.data[50:100] = 1e9
    with pytest.raises(
        ArgumentError, match=r"channel \.\.\.HN[NE]: a gap of 50 masked samples; cut the stream to one side"
    ):
        Motion.from_obspy(merged)
    filled = pieces.copy().merge(fill_value=0.0)
    assert Motion.from_obspy(filled).sample_count == 150
    for trace in filled:
        trace.data = np.ma.masked_array(trace.data)  # a mask that hides nothing
    assert np.abs(Motion.from_obspy(filled).north).max() == 0.1


@pytest.mark.parametrize("channels", [("HHN", "HHE", "HHZ"), ("EHN", "EHE", "EHZ"), ("BLN", "BLE"), ("GPN", "GPE")])
def test_channels_of_velocity_sensors_are_refused_unless_their_unit_is_stated(channels: tuple[str, ...]) -> None:
    with pytest.raises(
        ArgumentError, match=rf"channel \.\.\.{channels[0]}: a velocity sensor by its code; .* unit='m/s2'"
    ):
        Motion.from_obspy(stream_of_channels(*channels))
    assert Motion.from_obspy(stream_of_channels(*channels), unit="m/s2").north[0] == 2.0
    assert Motion.from_obspy(stream_of_channels(*channels), unit="gal").north[0] == pytest.approx(0.02)
    with pytest.raises(ArgumentError, match=r"unit: 'm/s'; known are m/s2"):
        Motion.from_obspy(stream_of_channels(*channels), unit="m/s")


@pytest.mark.parametrize(("output", "taken"), [("ACC", True), ("VEL", False), ("DISP", False)])
@pytest.mark.parametrize("code", ["HH", "HN"])
def test_stream_with_response_removed_is_accepted_only_as_acceleration(code: str, output: str, taken: bool) -> None:
    """Obspy removes the response of a flat velocity sensor and records this in the trace's processing."""
    from obspy.core.inventory import Channel, Inventory, Network, Station
    from obspy.core.inventory.response import Response

    found = stream_of_channels(f"{code}N", f"{code}E", npts=400)
    response = Response.from_paz([], [], 1.0, input_units="M/S")
    channels = [Channel(f"{code}{axis}", "", 0, 0, 0, 0, azimuth=0, dip=0, response=response) for axis in "NE"]
    inventory = Inventory([Network("XX", [Station("T", 0, 0, 0, channels=channels)])], source="test")
    for number, trace in enumerate(found):
        trace.stats.update({"network": "XX", "station": "T", "calib": 1.0})
        trace.data = 1e-3 * np.sin(np.arange(400) / (20.0 + number))
    found.remove_response(inventory, output=output)
    if taken:
        assert Motion.from_obspy(found).sample_count == 400
    else:
        with pytest.raises(ArgumentError, match=f"its response was removed to {output}"):
            Motion.from_obspy(found)


def test_an_integrated_obspy_trace_is_refused() -> None:
    """Regression: a velocity from obspy's `integrate` has a plausible size and was read as m/s²."""
    found = stream_of_channels("HNN", "HNE").integrate()
    with pytest.raises(ArgumentError, match=r"HNN: integrated by obspy; .* unit='m/s2'"):
        Motion.from_obspy(found)
    assert Motion.from_obspy(found, unit="m/s2").sample_count == 100
    assert Motion.from_obspy(found.differentiate()).sample_count == 100


def test_a_sac_direction_that_contradicts_the_channel_code_gives_a_warning() -> None:
    found = stream_of_channels("HNN", "HNE", "HNZ")
    axes = {"HNN": (0.0, 90.0), "HNE": (93.0, 90.0), "HNZ": (0.0, 0.0)}
    for trace in found:
        trace.stats.sac = dict(zip(("cmpaz", "cmpinc"), axes[trace.stats.channel], strict=True))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Motion.from_obspy(found)
    for channel, key, value, words in ((0, "cmpaz", 137.0, "azimuth 137°"), (2, "cmpinc", 180.0, "180° from up")):
        wrong = found.copy()
        wrong[channel].stats.sac[key] = value
        with pytest.warns(UserWarning, match=rf"points (north|up) by its code, but .*{words}.* its SAC header"):
            Motion.from_obspy(wrong)


def test_a_stream_in_counts_is_refused() -> None:
    """Regression: small counts were read as m/s², and larger ones were said to look like Gal."""
    found = stream_of_channels("HNN", "HNE")
    for trace in found:
        trace.data = (3 * trace.data).astype(np.int32)
    assert Motion.from_obspy(found).north[0] == 6.0, "a reader of counts has left what one is in calib"
    for trace in found:
        trace.stats.calib = 1.0
    with pytest.raises(ArgumentError, match=r"HNN: integer samples are counts; remove the response"):
        Motion.from_obspy(found)
    assert Motion.from_obspy(found, unit="mm/s2").north[0] == pytest.approx(0.003)


def test_the_scale_factor_of_a_sac_file_is_not_applied(tmp_path: Path) -> None:
    """Obspy stores the header field SCALE in `calib`; `from_obspy` ignores it, as `overturning.read` does."""
    found = stream_of_channels("HNN", "HNE")
    for trace in found:
        trace.stats.calib = 1.0
        trace.stats.update({"network": "XX", "station": "T"})
        trace.write(str(tmp_path / f"{trace.stats.channel}.sac"), format="SAC")
    read = obspy.Stream([obspy.read(path)[0] for path in sorted(tmp_path.iterdir())])
    plain = Motion.from_obspy(read)
    for trace in read:
        trace.stats.sac["scale"] = 2.0
        trace.write(str(tmp_path / f"{trace.stats.channel}.sac"), format="SAC")
    scaled = obspy.Stream([obspy.read(path)[0] for path in sorted(tmp_path.iterdir())])
    assert {trace.stats.calib for trace in scaled} == {2.0}
    np.testing.assert_array_equal(Motion.from_obspy(scaled).north, plain.north)
    record = overturning.read(sorted(tmp_path.iterdir()), unit="m/s2", processed=True, trust_data=True)
    np.testing.assert_array_equal(record.north, plain.north)


def test_a_stream_with_drifting_velocity_gives_a_warning() -> None:
    """Raw counts read by obspy contain an offset; `overturning.read` removes it, `from_obspy` only warns."""
    found = stream_of_channels("HNN", "HNE", npts=4000)
    for trace, offset, speed in zip(found, (0.0, 0.05), (0.07, 0.06), strict=True):
        trace.data = np.sin(np.arange(4000) * speed) * np.hanning(4000) + offset
    with pytest.warns(UserWarning, match="velocity towards east ends at 100 % of its peak, like raw data") as told:
        raw = Motion.from_obspy(found)
    assert len(told) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.abs(Motion.from_obspy(found.detrend("constant")).east - raw.east).max() == pytest.approx(
            0.1, rel=0.01
        )


def test_obspy_channels_of_another_sensor_than_declared_are_refused() -> None:
    with pytest.raises(ArgumentError, match=r"NS1: it belongs to the borehole sensor; .* sensor='borehole'"):
        Motion.from_obspy(stream_of_channels("NS1", "EW1", "UD1"))
    assert Motion.from_obspy(stream_of_channels("NS1", "EW1", "UD1"), sensor="borehole").sample_count == 100
    with pytest.raises(ArgumentError, match="NS2: it belongs to the surface sensor"):
        Motion.from_obspy(stream_of_channels("NS2", "EW2"), sensor="borehole")


@pytest.mark.parametrize(
    ("azimuth", "north", "east"),
    [
        (0, 1, 0), (30, 3**0.5 / 2, 0.5), (45, 0.5**0.5, 0.5**0.5), (60, 0.5, 3**0.5 / 2), (90, 0, 1),
        (135, -(0.5**0.5), 0.5**0.5), (180, -1, 0), (240, -0.5, -(3**0.5) / 2), (270, 0, -1), (330, 3**0.5 / 2, -0.5),
        (-30, 3**0.5 / 2, -0.5), (750, 3**0.5 / 2, 0.5),
    ],
)  # fmt: skip
def test_direction_cosines_match_known_compass_angles(azimuth: float, north: float, east: float) -> None:
    """Cosine and sine of angles of the equilateral triangle and the square, clockwise from north."""
    assert cosine_and_sine_of_azimuth(azimuth) == pytest.approx((north, east), abs=1e-12)


def test_the_integral_of_a_motion_follows_the_trapezoidal_rule() -> None:
    """Computed by hand: cumulative sum of (0 + 1)/2 · 0.5, (1 + 3)/2 · 0.5 and (3 − 1)/2 · 0.5, from 0."""
    np.testing.assert_allclose(integrate(np.array([0.0, 1.0, 3.0, -1.0]), 0.5), [0.0, 0.25, 1.25, 1.75])


@pytest.mark.parametrize(
    ("east", "word"),
    [
        (lambda wave: 0.004 * wave, "stream: east is dead: its peak is 0.4 Gal, less than 1/100 of that of north"),
        (lambda wave: -wave, "stream: north and east have the same samples"),
        (lambda wave: np.clip(np.roll(wave, 7), -0.3, 0.3), "stream: east is clipped: "),
    ],
)
def test_flat_copied_and_clipped_traces_give_warnings(east: Callable[[np.ndarray], np.ndarray], word: str) -> None:
    """Traces of a stream that are flat, equal or clipped give warnings; two different components give none."""
    time = np.arange(1000) / 100
    wave = np.sin(2 * np.pi * time) * np.sin(np.pi * time / 10) ** 2
    wave /= np.abs(wave).max()
    motion = Motion(wave, east(wave), sampling_interval=0.01)
    with pytest.warns(UserWarning, match=word):
        Motion.from_obspy(motion.to_obspy())
    Motion.from_obspy(Motion(wave, np.roll(wave, 7), sampling_interval=0.01).to_obspy())
