"""Site response compared with the closed form of one damped layer on a half-space."""

import importlib.util
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from overturning import Motion, run_study
from overturning.commands.workflow import compute_surface_motions
from overturning.errors import ArgumentError, RecordError
from overturning.motion.soil import (
    MAX_ACCELERATION_TO_PEAK_RATIO_AFTER_TAIL,
    MIN_VIBRATION_TAIL_S,
    MIN_ZERO_PADDING_S,
    RockHalfSpace,
    SoilLayer,
    check_pystrata_has_soil_curves,
    propagate_through_soil,
)
from overturning.records.processing import process_record
from overturning.records.pulses import parse_pulse, record_of_pulse
from overturning.records.record import processing_entry_text, processing_peaks_and_notes_of_record
from overturning.records.site import SoilSite
from overturning.records.store import (
    read_record_from_motion_file,
    round_samples_to_stored_decimals,
    write_record_to_motion_file,
)
from tests.expect import expect_error

if importlib.util.find_spec("pystrata") is None and "OVERTURNING_NO_SKIP" not in os.environ:
    pytest.skip("pystrata is not installed (`make soil`)", allow_module_level=True)

SAMPLING_INTERVAL_S = 0.01
LAYER, ROCK = SoilLayer(thickness_m=20, velocity_m_s=200), RockHalfSpace(velocity_m_s=1000)
SOIL_SITE_SETTINGS = {"layers": [{"thickness_m": 20, "velocity_m_s": 200}], "rock": {"velocity_m_s": 1000}}
PULSE = record_of_pulse(parse_pulse("sine amplitude_gal=300 period_s=0.4 azimuth_deg=0"))


def closed_form_surface_to_outcrop_ratio(frequency: np.ndarray, layer: SoilLayer, rock: RockHalfSpace) -> np.ndarray:
    """Return the ratio of surface to outcrop motion of one layer (Kramer 1996, eq. 7.28).

    The complex shear modulus is G (√(1 − 4ξ²) + 2iξ).
    """
    speed = [one.velocity_m_s * np.sqrt(np.sqrt(1 - 4 * one.damping**2) + 2j * one.damping) for one in (layer, rock)]
    impedance = layer.density_kg_m3 * speed[0] / (rock.density_kg_m3 * speed[1])
    phase = 2 * np.pi * frequency * layer.thickness_m / speed[0]
    return 1 / (np.cos(phase) + 1j * impedance * np.sin(phase))


@pytest.fixture(scope="module")
def noise_samples() -> np.ndarray:
    """Noise of 2000 samples under a Hann window."""
    return np.random.default_rng(2).normal(size=2000) * np.hanning(2000)


def test_the_response_of_one_soil_layer_matches_the_closed_form(noise_samples: np.ndarray) -> None:
    found = propagate_through_soil(noise_samples, SAMPLING_INTERVAL_S, [LAYER], ROCK)
    length = 1 << 16
    frequency = np.fft.rfftfreq(length, SAMPLING_INTERVAL_S)
    expected = np.fft.irfft(
        np.fft.rfft(noise_samples, length) * closed_form_surface_to_outcrop_ratio(frequency, LAYER, ROCK), length
    )
    assert found.surface_acceleration.size == noise_samples.size + round(MIN_VIBRATION_TAIL_S / SAMPLING_INTERVAL_S)
    assert (
        np.abs(found.surface_acceleration - expected[: found.surface_acceleration.size]).max()
        < 1e-3 * np.abs(expected).max()
    )
    assert found.is_converged


def test_free_vibration_of_soil_does_not_wrap_to_the_start(noise_samples: np.ndarray) -> None:
    # A pulse at the very end: without zeros behind it its echo would stand at the start.
    late = np.zeros(1000)
    late[-50:] = np.hanning(50)
    found = propagate_through_soil(late, SAMPLING_INTERVAL_S, [LAYER], ROCK).surface_acceleration
    assert np.abs(found[:900]).max() < 0.01 * np.abs(found).max()
    assert 5 * 4 * LAYER.thickness_m / LAYER.velocity_m_s < MIN_ZERO_PADDING_S  # five fundamental periods


@pytest.mark.parametrize(("thickness", "velocity", "damping"), [(30, 100, 0.01), (300, 300, 0.01), (20, 200, 0.05)])
def test_lightly_damped_soil_above_a_borehole_matches_the_closed_form(
    thickness: float, velocity: float, damping: float
) -> None:
    """A borehole motion is that of rigid rock: the ratio of surface to borehole motion is 1/cos(ωH/v), v complex."""
    layer = SoilLayer(thickness_m=thickness, velocity_m_s=velocity, damping=damping)
    late = np.zeros(2000)
    late[-500:] = np.random.default_rng(3).normal(size=500) * np.hanning(500)
    found = propagate_through_soil(
        late, SAMPLING_INTERVAL_S, [layer], ROCK, motion_is_on_outcrop=False
    ).surface_acceleration
    length = 1 << 19
    rigid = ROCK.model_copy(update={"velocity_m_s": 1e15})
    ratio = closed_form_surface_to_outcrop_ratio(np.fft.rfftfreq(length, SAMPLING_INTERVAL_S), layer, rigid)
    whole = np.fft.irfft(np.fft.rfft(late, length) * ratio, length)
    expected, left = whole[: found.size], np.abs(whole[found.size : -1000]).max() / np.abs(whole).max()
    assert np.abs(found - expected).max() < 3e-3 * np.abs(expected).max()
    assert (
        left < 1.2 * MAX_ACCELERATION_TO_PEAK_RATIO_AFTER_TAIL
    )  # the motion at the surface is not cut off while the layer vibrates
    assert np.abs(found[:1400]).max() < 3e-3 * np.abs(found).max()  # before the motion begins


@pytest.mark.parametrize(
    ("layer", "reason"),
    [
        ({"thickness_m": 30, "velocity_m_s": 100, "damping": 0}, "give the layers and the rock more damping"),
        ({"thickness_m": 1e4, "velocity_m_s": 10}, "check thickness_m (m) and velocity_m_s (m/s)"),
    ],
)
def test_soil_layers_without_a_usable_response_are_refused(layer: dict[str, float], reason: str) -> None:
    with expect_error(ArgumentError, "site: ", reason):
        propagate_through_soil(
            PULSE.north, PULSE.sampling_interval, [SoilLayer(**layer)], ROCK, motion_is_on_outcrop=False
        )


def test_a_soil_layer_resonates_at_its_fundamental_period() -> None:
    time = np.arange(0, 30, SAMPLING_INTERVAL_S)
    peaks = [
        np.abs(
            propagate_through_soil(
                np.sin(2 * np.pi * time / period), SAMPLING_INTERVAL_S, [LAYER], ROCK
            ).surface_acceleration[1500:3000]
        ).max()
        for period in (0.25, 0.4, 0.8)
    ]
    expected = np.abs(closed_form_surface_to_outcrop_ratio(1 / np.array([0.25, 0.4, 0.8]), LAYER, ROCK))
    assert peaks == pytest.approx(expected, rel=0.03)


def test_soil_with_a_strain_curve_amplifies_strong_motion_less_than_weak(noise_samples: np.ndarray) -> None:
    soft = LAYER.model_copy(update={"curve": "Vucetic & Dobry (91), PI=15"})
    weak, strong = (
        propagate_through_soil(scale * noise_samples, SAMPLING_INTERVAL_S, [soft], ROCK) for scale in (1e-4, 3.0)
    )
    assert weak.is_converged
    assert strong.max_shear_strain_of_any_layer > 100 * weak.max_shear_strain_of_any_layer
    ratio = np.abs(strong.surface_acceleration).max() / 3.0 / (np.abs(weak.surface_acceleration).max() / 1e-4)
    assert ratio < 0.8


def test_a_soil_strain_beyond_the_curve_is_noted(noise_samples: np.ndarray) -> None:
    """Beyond the end of a curve, modulus and damping are constant, so the iteration converges at any strain."""
    soft = LAYER.model_copy(update={"curve": "Vucetic & Dobry (91), PI=15"})  # ends at a strain of 1 %
    within, beyond = (
        propagate_through_soil(scale * noise_samples, SAMPLING_INTERVAL_S, [soft], ROCK) for scale in (10.0, 30.0)
    )
    assert (within.is_converged, within.effective_strain_and_end_of_curve_if_exceeded) == (True, None)
    assert within.max_shear_strain_of_any_layer < 0.01
    assert beyond.effective_strain_and_end_of_curve_if_exceeded == pytest.approx(
        (0.65 * beyond.max_shear_strain_of_any_layer, 0.01)
    )
    assert beyond.max_shear_strain_of_any_layer > 0.02
    site = SoilSite.model_validate(SOIL_SITE_SETTINGS | {"layers": [soft.model_dump()]})
    _, text = site.propagate_record_to_surface_with_note(replace(PULSE, north=100.0 * PULSE.north))
    assert "% beyond the curve (which ends at 1 %); east converged, strain 0 %" in text


def test_an_invalid_soil_profile_is_refused(noise_samples: np.ndarray) -> None:
    with pytest.raises(ValidationError, match="thickness_m"):
        SoilLayer(thickness_m=0, velocity_m_s=200)
    with pytest.raises(ValidationError, match="layers"):
        SoilSite(layers=[], rock=ROCK)
    with pytest.raises(ArgumentError, match="curve 'none'; known are"):
        propagate_through_soil(noise_samples, SAMPLING_INTERVAL_S, [LAYER.model_copy(update={"curve": "none"})], ROCK)


@pytest.mark.parametrize(
    ("curve", "part"),
    [("Iwasaki, 0.25 atm", "damping"), ("Seed & Idriss, Sand Lower", "modulus reduction")],
)
def test_a_soil_curve_without_modulus_or_damping_is_refused(curve: str, part: str) -> None:
    """One curve has no damping in pystrata, the other no modulus reduction; a soil layer needs both properties."""
    layer = LAYER.model_copy(update={"curve": curve})
    for refusal in (
        check_pystrata_has_soil_curves,
        lambda layers: propagate_through_soil(PULSE.north, 0.01, layers, ROCK),
    ):
        with expect_error(
            ArgumentError, f"site: curve {curve!r}: pystrata has no {part} of this curve; choose a curve"
        ):
            refusal([layer])
    check_pystrata_has_soil_curves([LAYER, LAYER.model_copy(update={"curve": "Seed & Idriss, Sand Mean"})])


def test_processing_with_a_soil_site_gives_the_motion_at_the_soil_surface() -> None:
    soft = LAYER.model_copy(update={"curve": "Vucetic & Dobry (91), PI=15"})
    done = process_record(PULSE, (), SoilSite(layers=[soft], rock=ROCK))
    alone = propagate_through_soil(PULSE.north, PULSE.sampling_interval, [soft], ROCK)
    assert done.north == pytest.approx(alone.surface_acceleration)
    assert done.processing[0]["effect"]["pga"][1] == pytest.approx(np.abs(alone.surface_acceleration).max())
    assert "north converged" in processing_entry_text(done.processing[0])
    linear = process_record(PULSE, (), SoilSite(layers=[LAYER], rock=ROCK))
    assert np.abs(linear.north).max() > np.abs(done.north).max()


def test_borehole_motion_is_not_treated_as_outcrop() -> None:
    """A borehole motion contains downgoing waves: treated as outcrop motion it gives too weak a surface motion."""
    deep = replace(PULSE, extra={"declared": ["borehole sensor"], "processed": True})
    with expect_error(RecordError, "record pulse: of a borehole", "write `motion: within` at the site"):
        process_record(deep, (), SoilSite(layers=[LAYER], rock=ROCK))
    within = process_record(deep, (), SoilSite(layers=[LAYER], rock=ROCK, motion="within"))
    outcrop = process_record(PULSE, (), SoilSite(layers=[LAYER], rock=ROCK))
    assert np.abs(within.north).max() > 1.3 * np.abs(outcrop.north).max()


def test_components_at_the_soil_surface_have_equal_length(noise_samples: np.ndarray) -> None:
    """The soil vibrates longest under the component that ends abruptly; zeros extend the other components."""
    late = np.zeros(noise_samples.size)
    late[-50:] = np.hanning(50)
    light = SoilSite(layers=[{"thickness_m": 30, "velocity_m_s": 100, "damping": 0.01}], rock=ROCK)
    record = replace(PULSE, north=noise_samples, east=late, up=np.ones(noise_samples.size))
    found, _ = light.propagate_record_to_surface_with_note(record)
    alone = propagate_through_soil(late, record.sampling_interval, light.layers, ROCK).surface_acceleration
    assert found.north.size == found.east.size == found.up.size == alone.size
    assert np.array_equal(found.east, alone)
    assert np.array_equal(found.up, np.append(record.up, np.zeros(alone.size - noise_samples.size)))


def test_a_record_passed_to_a_study_is_propagated_through_its_soil_site() -> None:
    """A sine at the period of the layer, 4 H/v, overturns more blocks at the soil surface than on rock."""
    motion = Motion.sine(amplitude=2.0, period=0.4, cycles=6)
    keys = {"azimuth": {"step": 180}, "b_over_h": [0.2, 0.3], "height": [0.3], "ensemble": {"members": 0}}
    rock, soft = (run_study([motion], **keys, **more) for more in ({}, {"site": SOIL_SITE_SETTINGS}))
    peaks = json.loads(soft.attrs["record_processing"])["motion-1"]["peaks"]["pga"]
    expected = np.abs(
        propagate_through_soil(motion.north, motion.sampling_interval, [LAYER], ROCK).surface_acceleration
    ).max()
    assert peaks == pytest.approx([2.0, expected], rel=1e-6)
    assert np.abs(rock["overturned"]).sum() < np.abs(soft["overturned"]).sum()


def test_motion_files_of_a_variant_with_soil_hold_the_surface_motions(tmp_path: Path) -> None:
    record = round_samples_to_stored_decimals(PULSE)
    study = {"name": "x", "records": {"use": ["pulse"]}, "variants": {"soft": {"site": SOIL_SITE_SETTINGS}}}
    renamed = replace(record, record_id="pulse")
    write_record_to_motion_file(renamed, tmp_path / "rock" / "pulse.nc")
    compute_surface_motions(json.dumps(study), tmp_path / "rock", tmp_path / "soft", "soft")
    found = read_record_from_motion_file(tmp_path / "soft" / "pulse.nc")
    alone = propagate_through_soil(record.north, record.sampling_interval, [LAYER], ROCK)
    assert found.north == pytest.approx(alone.surface_acceleration, abs=1e-9)
    assert processing_peaks_and_notes_of_record(found)["peaks"]["pga"] == pytest.approx(
        [np.abs(record.north).max(), np.abs(alone.surface_acceleration).max()]
    )
