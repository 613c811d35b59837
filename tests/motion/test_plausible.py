"""Implausible motions are refused, with the unit that would make them plausible."""

import numpy as np
import pytest

import overturning
from overturning.errors import ArgumentError
from overturning.motion.motion import Motion
from overturning.motion.plausible import implausible_amplitude_reason

TIME = np.arange(0, 10, 0.01)
WAVE = np.sin(2 * np.pi * TIME) * np.exp(-((TIME - 5) ** 2))
G = 9.80665


@pytest.mark.parametrize(
    ("peak", "unit", "words"),
    [
        (535.0 * G, "g", ["535 g", "at most 5 g", "declared in g", "Gal (0.55 g)", "mg (0.54 g)"]),
        (5.35, "m/s2", []),
        (535.0, "m/s2", ["at most 5 g", "Gal (0.55 g)"]),
        (0.0005, "gal", ["at least 0.0001 g", "g (0.05 g)"]),
        (5.1 * G, "", ["at most 5 g", "the unit stated in the file is wrong"]),
        (1.01e-4 * G, "gal", []),
        (4.9 * G, "g", []),
    ],
)
def test_the_error_for_an_implausible_peak_names_bound_and_likely_unit(peak, unit, words):
    found = implausible_amplitude_reason(
        [peak * WAVE / np.abs(WAVE).max(), 0 * WAVE], 0.01, declared_unit_if_file_states_none=unit
    )
    assert bool(found) == bool(words)
    for word in words:
        assert word in found


def test_an_implausible_velocity_is_reported():
    steady = np.full(1000, 2.0)
    assert "peak velocity 1998 cm/s" in implausible_amplitude_reason([steady], 0.01)
    assert implausible_amplitude_reason([steady], 0.01, check_velocity=False) == ""
    # Above 10 m/s, three times what was ever recorded: 9.99 s of steady acceleration to either side of it.
    assert implausible_amplitude_reason([steady / 2], 0.01) == ""
    assert "at most 1000 cm/s" in implausible_amplitude_reason([steady / 1.98], 0.01)


def test_a_motion_of_numbers_like_gal_is_refused_unless_trusted():
    with pytest.raises(ArgumentError, match=r"numbers declared in m/s² look like Gal .* trust_data=True"):
        Motion(800 * WAVE, 0 * WAVE, sampling_interval=0.01)
    trusted = Motion(800 * WAVE, 0 * WAVE, sampling_interval=0.01, trust_data=True)
    found = overturning.simulate(trusted, azimuth_deg=[0], height=[0.6], b_over_h=[0.3], friction=[0.6])
    assert found.overturned.size == 1
    # Rest is rest in every unit.
    assert Motion(0 * WAVE, 0 * WAVE, sampling_interval=0.01).sample_count == WAVE.size
