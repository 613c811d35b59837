"""Outcomes of stones that are shipped with the package: those of the kernel, for the right motions only."""

import math
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from overturning.motion.motion import Motion
from overturning.surveys import stone_outcomes
from overturning.surveys.library import CandidateMotion
from overturning.surveys.responses import (
    StoneHeightAndSideRatios,
    count_cases_to_simulate_and_estimate_time_s,
    note_on_stones_simulated_with_smaller_d_over_b,
)
from overturning.surveys.stone_outcomes import shipped_stone_outcomes_of_motion, simulate_outcomes_of_sizes
from overturning.surveys.stones import Stone
from tests.dem.test_same_bits import NUMPY_INSTRUCTION_SETS


@pytest.mark.parametrize("count", [2, pytest.param(60, marks=pytest.mark.long)])
@pytest.mark.parametrize("aspect", [0.0, *stone_outcomes.SIMULATED_D_OVER_B])
def test_shipped_stone_outcomes_match_new_simulations(
    candidate_motions_of_package: tuple[CandidateMotion, ...], aspect: float, count: int
) -> None:
    """Shipped outcomes of random motions and sizes equal new ones at all frictions, peak velocities and azimuths."""
    motions, dice = candidate_motions_of_package, np.random.default_rng([count, int(10 * aspect)])
    for one in dice.choice(len(motions), count):
        shipped = shipped_stone_outcomes_of_motion(motions[one], aspect)
        name = sorted(shipped)[dice.integers(len(shipped))]
        h, b = map(int, name.split("-"))
        found = simulate_outcomes_of_sizes(motions[one], aspect, [(h, b)], 1)[0]
        np.testing.assert_array_equal(shipped[name], found, err_msg=f"{motions[one].name}, {name}")


@pytest.mark.long
def test_case_grid_text_equals_that_of_shipped_outcomes_on_any_processor() -> None:
    """NumPy runs without wide-vector instructions, which change the last digits of exponentials and logarithms."""
    command = [
        sys.executable,
        "-c",
        f"import {stone_outcomes.__name__} as outcomes; print(outcomes.simulated_grid_text_to_detect_outdated_files())",
    ]
    done = subprocess.run(
        command,
        env=os.environ | {"NPY_DISABLE_CPU_FEATURES": " ".join(NUMPY_INSTRUCTION_SETS)},
        capture_output=True,
        text=True,
        check=True,
    )
    with np.load(stone_outcomes.SHIPPED_OUTCOMES_FILE) as stored:
        assert done.stdout.strip() == str(stored["grid"])


def test_grid_of_peak_velocities_and_b_over_h_is_geometric() -> None:
    for grid, ends in (
        (stone_outcomes.SIMULATED_PGV_M_S, (0.2, 3.2)),
        (stone_outcomes.SIMULATED_B_OVER_H, (0.08, 0.8)),
    ):
        np.testing.assert_allclose(grid, np.geomspace(*ends, grid.size), rtol=1e-15)


def standing_stone(height: float, aspect: float, b_over_h: float = 0.3) -> Stone:
    """Return a standing stone with a ratio D/B of depth to width; 0 means a round column."""
    side = b_over_h * aspect if aspect else math.nan
    return Stone(
        False, math.nan, False, b_over_h=b_over_h, b_over_h_side=side, height_m=height, has_round_plan=aspect == 0.0
    )


@pytest.mark.parametrize(
    ("aspects", "note"),
    [
        ((6.7, 8.0), "2 stones are simulated with D/B 4, the largest; D/B in the survey: up to 8"),
        ((0.125, 1.0), "1 stone is simulated with D/B 4, the largest; D/B in the survey: up to 8"),
        ((0.0, 1.0, 4.9), None),
    ],
)
def test_note_counts_stones_above_the_largest_simulated_depth_to_width_ratio(
    aspects: tuple[float, ...], note: str | None
) -> None:
    unknown = Stone(True, math.nan, False)
    assert note_on_stones_simulated_with_smaller_d_over_b(
        [unknown, *(standing_stone(0.9, one, 0.1) for one in aspects)]
    ) == ((note,) if note else ())


def test_only_stones_within_the_documented_limits_have_shipped_outcomes(
    candidate_motions_of_package: tuple[CandidateMotion, ...],
) -> None:
    stated = re.search(
        r"outcomes of stones up to ([\d.]+) m high under the (\d+) motions of the library",
        (Path(__file__).parents[2] / "docs" / "surveys.md").read_text(encoding="utf-8"),
    )
    assert stated
    highest, count = map(float, stated.groups())
    motions = candidate_motions_of_package
    assert len(motions) == count
    known = [
        StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(standing_stone(height, aspect, ratio))
        for height in (0.25, 0.9, highest)
        for ratio in (0.1, 0.37, 0.8)
        for aspect in (0.0, 1.0, 1.5, 2.3, 3.5, 7.0)
    ]
    assert count_cases_to_simulate_and_estimate_time_s(motions, known) == (0, 0.0)
    every, seconds = count_cases_to_simulate_and_estimate_time_s(motions, known, counts_cases_with_stored_outcomes=True)
    assert every > 1e6
    assert seconds > 60.0
    assert (
        count_cases_to_simulate_and_estimate_time_s(
            motions, [StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(standing_stone(1.05 * highest, 1.0))]
        )[0]
        > 0
    )


def motion_with_changed_components(one: CandidateMotion, **changes: object) -> CandidateMotion:
    """Return a candidate motion with the components given in `changes` (`north`, `east`, `up`) replaced."""
    motion = one.motion
    parts = {"north": motion.north, "east": motion.east, "up": motion.up} | changes
    return replace(one, motion=Motion(**parts, sampling_interval=motion.sampling_interval))


def test_a_motion_that_only_resembles_one_of_the_library_has_no_shipped_outcomes(
    candidate_motions_of_package: tuple[CandidateMotion, ...],
) -> None:
    motions = {one.name: one for one in candidate_motions_of_package}
    kaikoura, sine = motions["Kaikoura, WTMC"], motions["sine 0.8 s"]
    assert shipped_stone_outcomes_of_motion(kaikoura, 1.0)
    assert shipped_stone_outcomes_of_motion(motion_with_changed_components(sine, up=0.0 * sine.motion.north), 1.0)
    for other in (
        motion_with_changed_components(kaikoura, up=None),
        motion_with_changed_components(sine, up=np.ones_like(sine.motion.north)),
        replace(sine, pga_m_s2=1.001 * sine.pga_m_s2),
        replace(sine, peak_velocity_azimuth_deg=90.0),
        CandidateMotion.from_motion("longer", "", Motion(np.append(sine.motion.north, 0.0),
                                    np.append(sine.motion.east, 0.0), sampling_interval=0.01)),
    ):  # fmt: skip
        assert shipped_stone_outcomes_of_motion(other, 1.0) == {}


def test_shipped_outcomes_of_another_grid_are_not_used(
    candidate_motions_of_package: tuple[CandidateMotion, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    one = candidate_motions_of_package[0]
    assert shipped_stone_outcomes_of_motion(one, 1.0)
    for read in (stone_outcomes._d_over_b_texts_with_shipped_outcomes, stone_outcomes._shipped_outcome_array):
        read.cache_clear()
    monkeypatch.setattr(stone_outcomes, "SIMULATED_FRICTIONS", (0.5, 0.65, 0.9))
    assert shipped_stone_outcomes_of_motion(one, 1.0) == {}
    stone_outcomes._d_over_b_texts_with_shipped_outcomes.cache_clear()
