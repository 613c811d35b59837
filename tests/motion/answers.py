"""What is measured of made-up motions: peaks, spectra, directions, noise; and which motions are refused."""

from functools import cache, partial
from typing import Any

import numpy as np

from overturning.motion import direction, fourier, heading, intensity, jma_intensity, noise, plausible, soil, spectra
from overturning.motion.integration import integrate
from overturning.motion.motion import Motion, as_motion
from overturning.motion.oscillator import Oscillators, coefficients
from tests.kept import Answers, interface_of, keys_of, refusals


@cache
def motion(interval: float = 0.01, samples: int = 1500) -> Motion:
    """Weak noise, then strong noise that dies away, with a pulse towards N60°E in it."""
    dice, time = np.random.default_rng(5), np.arange(samples) * interval
    grows = np.where(time < 4.0, 0.002, np.exp(-((time - 6.0) ** 2) / 4.0) + 0.01)
    parts = [grows * np.convolve(dice.normal(size=samples), np.ones(4) / 4, "same") for _ in range(3)]
    pulse = np.where(abs(time - 6.0) < 0.8, 1.5 * np.sin(2 * np.pi * (time - 6.0) / 1.6), 0.0)
    north, east = parts[0] + 0.5 * pulse, parts[1] + 0.866 * pulse
    return Motion(np.round(north, 9), np.round(east + 0.003, 9), np.round(parts[2], 9), sampling_interval=interval)


def of_directions() -> dict[str, Any]:
    asked = [0.0, 30.0, 89.999, 90.0, 135.0, 180.0, 250.0, 359.5, 360.0, -1.0, -270.0, 725.0]
    pair, many = motion().horizontal, np.random.default_rng(1).normal(size=(2, 9000))
    thick = many / np.hypot(*many) * (1 + 1e-3 * np.random.default_rng(2).random(9000))
    cosines = direction.cosines_of(np.arange(0, 180, 7.0))
    return {
        "cosines": [list(direction.direction_cosines(azimuth)) for azimuth in asked],
        **{
            name: direction.largest_along(one, cosines)
            for name, one in (("few", pair), ("many", many), ("ring", thick))
        },
        **{f"peaks {n}": heading.peak_azimuths(motion(n)) for n in (0.005, 0.02)},
        "pulse": [heading.pulse_axis(motion(n)) for n in (0.005, 0.01, 0.05)],
        "wavelet": heading.daubechies(),
        "still": [list(heading.pulse_axis(still())), list(heading.peak_azimuths(still()).values())],
    }


def still(count: int = 400) -> Motion:
    return Motion(np.zeros(count), np.zeros(count), sampling_interval=0.01)


def of_measures(interval: float) -> dict[str, Any]:
    one = motion(interval, 500)
    steps = [{"effect": {name: [k + 1.0, k + 2.0] for k, name in enumerate(intensity.PEAKS)}}] * 2
    table = intensity.intensity_by_azimuth(one, [0.0, 20.0, 60.0, 150.0, 200.0, 359.0])
    level = Motion(one.north, one.east, sampling_interval=interval)
    return {
        "table": table,
        "attributes": {name: values.attrs for name, values in table.variables.items()},
        "record": intensity.record_measures(one, steps),
        "level": intensity.record_measures(level, []),
        "short": intensity.record_measures(Motion([1, 0], [0, 1], sampling_interval=0.01), []),
        "still": intensity.measures_by_azimuth(still(), [0.0, 45.0]),
        "along one way": intensity.measures_by_azimuth(
            Motion(one.north, 0 * one.north, sampling_interval=0.02), [90.0]
        ),
    }


def of_spectra() -> dict[str, Any]:
    periods = [0.02, 0.05, 0.3, 1.0, 4.0, 15.0]
    found = {f"{n}": spectra.spectra_by_azimuth(motion(n), periods, [0, 60, 150]) for n in (0.005, 0.02)}
    oscillators = Oscillators(motion(0.02).horizontal, 0.02, 4.0)
    return found | {
        "damped": spectra.spectra_by_azimuth(motion(), periods, [60], damping=0.3, points_per_period=8),
        "undamped": spectra.pseudo_acceleration(motion(), [0.5], [60], damping=0.0),
        "RotD": spectra.rotd(motion(), periods[:4]),
        "quarters": spectra.rotd(motion(), [0.3], percentiles=[25, 75]),
        "SI": [spectra.spectrum_intensity(motion(), [0, 60], damping=d) for d in (0.05, 0.2)],
        "factors": [oscillators.factor(period) for period in (0.001, 0.05, 0.1, 0.3, 1.0, 10.0)],
        "coefficients": list(coefficients(0.7, 0.05, 0.01)),
        "responses": oscillators.response(0.4, 0.1, ("velocity", "displacement")),
        "long": Oscillators(motion().horizontal, 0.01, 30.0).response(30.0, 0.05, ("displacement",)),
    }


def of_fourier() -> dict[str, Any]:
    samples, at = motion().north, [0.05, 0.3, 1.0, 7.0, 40.0]
    frequency, amplitude = fourier.amplitude_spectrum(samples, 0.01)
    return {
        "frequency": frequency,
        "amplitude": amplitude,
        "smooth": fourier.konno_ohmachi(frequency, amplitude, at),
        "short": fourier.konno_ohmachi(*fourier.amplitude_spectrum(samples[600:640], 0.01), at),
        "bell": fourier.bell(12, 4),
        "bands": fourier.band_amplitude(samples, 0.01, np.geomspace(0.02, 40, 60)),
        "integral": integrate(samples[:9], 0.5),
        "JMA": [
            jma_intensity.instrumental_intensity(motion(n), horizontal=h) for n in (0.005, 0.01) for h in (True, False)
        ],
        "filter": jma_intensity.amplitude(np.array([0.0, 0.05, 0.5, 1.0, 6.0, 10.0, 25.0, 50.0, 80.0])),
        "at rest": jma_intensity.instrumental_intensity(still(), horizontal=True),
        "published": jma_intensity.as_published([6.44, 6.46, 6.494, 6.495, 6.5, -0.5]),
        "rule": jma_intensity.SURVEY_RULE,
        "adds": jma_intensity.VERTICAL_ADDS,
    }


def of_noise() -> dict[str, Any]:
    one = motion()
    tilted = one.north + np.where(np.arange(one.samples) > 600, 0.05, 0.0)
    cases = {"as it is": one.components, "tilted": [tilted, one.east], "one at rest": [one.north, 0 * one.east]}
    early = {"early": [one.north[n:] for n in (0, 350)], "no noise": [one.north[420:]], "at rest": [0 * one.north]}
    ratios = {name: noise.noise_ratio(parts, 0.01) for name, parts in (cases | early).items()}
    few = [
        np.array(x, float)
        for x in ([0, 1], [0, 1, 0, 0, 0, 9], [0, 0, 1, 0, 0, 0, 9], [0, 1, 0, 1, 0, 1, 0, 1, 9, -9, 9])
    ]
    return ratios | {
        "ratio": ratios["tilted"].ratio if ratios["tilted"] else None,
        "onsets": [noise.onset(part) for part in (*one.components, *few, one.north[::-1])],
        "fine": noise.noise_ratio([motion(0.005, 3000).north], 0.005),
        "long": noise.noise_ratio([np.append(np.tile(one.north[:300], 8), one.north) for _ in "ab"], 0.2),
        "weak": noise.noise_ratio([1e-3 * part for part in one.components[:2]], 0.01),
    }


def of_sizes() -> dict[str, Any]:
    g, units = 9.80665, ("", "gal", "g", "m/s2", "mg", "mm/s2")
    short = np.array([0.0, 1.0, -1.0, 0.0])
    peaks = [5.001, 4.999, 1e-4, 0.9e-4, 0.0, 100.0, 2.1, 0.004]
    return {
        f"{peak} {unit}": plausible.implausible([peak * g * short], 0.01, unit=unit) for peak in peaks for unit in units
    } | {
        f"pushed for {count}": [plausible.implausible([np.full(count, 10.0)], 0.01, pgv=pgv) for pgv in (True, False)]
        for count in (100, 101, 103)
    }


def of_motions() -> dict[str, Any]:
    one = Motion.sine(3.0, 0.5, azimuth_deg=30.0, cycles=1.5, rest=0.2, sampling_interval=0.02)
    stream = motion().to_obspy()
    again = Motion.from_obspy(stream, unit="gal")
    return {
        "sine": {"north": one.north, "east": one.east},
        "text": [repr(one), repr(motion())],
        "about": [one.samples, one.duration, one.trusted],
        "displacement": motion().displacement,
        "velocity": motion().velocity,
        "along": motion().along(100.0),
        "times": motion().times(-2.0).components,
        "obspy": [[t.stats.channel, t.stats.delta, t.stats.unit, str(t.stats.starttime)] for t in stream],
        "Gal": again.components,
    }


def of_refusals() -> dict[str, Any]:
    a, gap = np.array([0.0, 1.0, -1.0, 0.0]), np.ma.masked_array([0.0, 1.0, 2.0], [0, 1, 0])
    sine, made = partial(Motion.sine, 3.0), partial(Motion, sampling_interval=0.01)

    def streamed(
        channels: tuple[str, ...] = ("HNN", "HNE", "HNZ"), unit: Any = None, sensor: str = "surface", **about: Any
    ) -> Any:
        stream = motion().to_obspy()
        for trace, channel in zip(stream, channels, strict=False):
            trace.stats.channel = channel
        for key, value in about.items():
            setattr(stream[1].stats, key, value)
        return Motion.from_obspy(stream[: len(channels)], unit=unit, sensor=sensor)

    return refusals(
        lambda: made(a, a[:3]),
        lambda: made(a[:1], a[:1]),
        lambda: made([a, a], a),
        lambda: made(a, [0, np.inf, 0, 0]),
        lambda: made(gap, a[:3]),
        lambda: made(60 * a, a),
        lambda: made(a, a, a[:2]),
        lambda: made(a[:2], a[:2]),
        *(
            lambda interval=interval: Motion(a, a, sampling_interval=interval)
            for interval in (0.0, -1.0, np.nan, np.inf, 1e-3)
        ),
        lambda: Motion(60 * a, a, sampling_interval=0.01, trust_data=True),
        lambda: sine(0.0),
        lambda: sine(np.inf),
        lambda: sine(0.02),
        lambda: sine(0.0199),
        lambda: sine(1.0, rest=-0.1),
        lambda: sine(1.0, rest=0.0),
        lambda: sine(1.0, cycles=0),
        lambda: Motion.sine(0, 1.0),
        lambda: sine(1.0, rest=np.nan),
        lambda: as_motion([1, 2]),
        lambda: as_motion(motion().to_obspy()),
        lambda: as_motion(motion().to_obspy()[0]),
        lambda: as_motion(motion()),
        lambda: direction.direction_cosines(np.nan),
        lambda: direction.checked_azimuths([]),
        lambda: direction.checked_azimuths([[1.0]]),
        lambda: direction.checked_azimuths([1.0, np.inf]),
        lambda: jma_intensity.instrumental_intensity(still(30), horizontal=True),
        lambda: jma_intensity.instrumental_intensity(still(29), horizontal=True),
        lambda: jma_intensity.instrumental_intensity(still()),
        lambda: fourier.amplitude_spectrum([1.0], 0.01),
        lambda: fourier.amplitude_spectrum([1.0, 2.0], 0.01),
        lambda: fourier.amplitude_spectrum([[1.0, 2.0]], 0.01),
        *(lambda at=at: fourier.konno_ohmachi(np.arange(4.0), np.ones(4), at) for at in (0.0, -1.0, np.inf, 1e-3)),
        *(lambda h=h: spectra.pseudo_acceleration(motion(), [1.0], [0.0], damping=h) for h in (-0.01, 0.0, 0.999, 1.0)),
        *(
            lambda p=p: spectra.pseudo_acceleration(motion(), p, [0.0])
            for p in ([], [0.0], [[1.0]], [np.inf], [1.0, -1.0])
        ),
        *(
            lambda c=c: streamed(c)
            for c in (("HHN", "HNE"), ("HNN", "HNE"), ("HNN",), ("HNE",), ("HNN", "HNN"), ("HNN", "HN1"))
        ),
        *(
            lambda c=c: streamed(c)
            for c in (("NS1", "EW1"), ("NS2", "EW2", "UD2"), ("N", "E", "Z"), ("HLN", "HNE"), ("EPZ",))
        ),
        lambda: streamed(("NS1", "EW1"), sensor="borehole"),
        lambda: streamed(("NS2", "EW2"), sensor="borehole"),
        lambda: streamed(sensor="roof"),
        lambda: streamed(unit="feet"),
        lambda: streamed(("HHN", "HHE"), unit="m/s2"),
        lambda: streamed(delta=0.02),
        lambda: streamed(station="X"),
        lambda: streamed(location="10"),
        lambda: streamed(("HHN", "HHE"), processing=["remove_response(output='ACC')"]),
        lambda: streamed(processing=["remove_response(output='ACC')", "remove_response(output='VEL')"]),
    )


ANSWERS: Answers = {
    "interface": partial(interface_of, "motion"),
    "directions": of_directions,
    "measures": partial(of_measures, 0.02),
    "measures, coarse": partial(of_measures, 0.04),
    "spectra": of_spectra,
    "Fourier": of_fourier,
    "noise": of_noise,
    "sizes": of_sizes,
    "motions": of_motions,
    "refusals": of_refusals,
    "keys": partial(keys_of, soil.Layer, soil.Rock),
}
