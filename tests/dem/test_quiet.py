"""Times before and after which a block cannot move, from the thresholds of a rigid block."""

import numpy as np
import pytest

from overturning.dem.quiet import (
    SIMULATED_TIME_BEFORE_START_THRESHOLD_S,
    SIMULATION_START_TO_ONSET_THRESHOLD_RATIO,
    simulated_sample_ranges_and_stays_at_rest,
)
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

INTERVAL = 0.01
STRONG_SAMPLES = slice(400, 700)


@pytest.mark.parametrize("vertical", [False, True])
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_case_is_computed_from_before_the_first_to_after_the_last_strong_sample(vertical: bool, share: float) -> None:
    """Samples above a share of the rocking threshold |a| = (g + a_up) B/H count, samples just below do not."""
    slenderness, amplitude = 0.3, 2.0
    level = np.zeros(1000)
    level[STRONG_SAMPLES] = (
        share * SIMULATION_START_TO_ONSET_THRESHOLD_RATIO * slenderness * STANDARD_GRAVITY / amplitude
    )
    level[650] = (
        1.01 / SIMULATION_START_TO_ONSET_THRESHOLD_RATIO * level[650] / share
    )  # one sample above the threshold itself
    # Upward acceleration makes the block heavier: the same ratio needs a stronger motion.
    up = np.full(1000, 0.5 * STANDARD_GRAVITY / amplitude) if vertical else None
    north = level * (1.5 if vertical else 1.0)
    motion = Motion(north, 0 * north, up, sampling_interval=INTERVAL, trust_data=True)
    first, calm, stays_at_rest = simulated_sample_ranges_and_stays_at_rest(
        motion, np.array([0]), np.array([amplitude]), north[None, :], np.array([slenderness])
    )
    assert not stays_at_rest[0]
    begin, end = (STRONG_SAMPLES.start, STRONG_SAMPLES.stop - 1) if share > 1 else (650, 650)
    assert first[0] in (
        max(begin - 1 - round(SIMULATED_TIME_BEFORE_START_THRESHOLD_S / INTERVAL), 0),
        begin - round(SIMULATED_TIME_BEFORE_START_THRESHOLD_S / INTERVAL),
    )
    # The motion is linear from the last strong sample to the next.
    assert end + 1 <= calm[0] <= end + 2


def test_only_a_case_below_its_threshold_is_marked_as_staying_at_rest() -> None:
    north = np.full(100, 0.99 * 0.3 * STANDARD_GRAVITY)
    motion = Motion(north, 0 * north, sampling_interval=INTERVAL)
    rows, amplitudes = np.zeros(3, np.int64), np.array([1.0, 1.02, -1.02])
    _, _, stays_at_rest = simulated_sample_ranges_and_stays_at_rest(
        motion, rows, amplitudes, north[None, :], np.full(3, 0.3)
    )
    assert stays_at_rest.tolist() == [True, False, False]
