"""Shares of cells in which members disagree, compared with closed forms at known probabilities."""

import numpy as np
import pytest
from scipy.stats import multinomial

from overturning.settings import EnsembleSettings
from overturning.statistics.spread import (
    average_first_batch_statistic_over_run_orders,
    indicator_that_most_runs_fall_and_sides_differ,
    indicator_that_some_runs_fall_and_others_stand,
)
from overturning.study.ensemble import fall_probability_convergence_mask


@pytest.mark.parametrize("chances", [(0.02, 0.0), (0.05, 0.05), (0.3, 0.0), (0.1, 0.85), (0.5, 0.45), (0.97, 0.02)])
def test_share_of_disagreeing_ensembles_is_independent_of_early_stopping(chances: tuple[float, float]) -> None:
    """The share of ensembles whose members disagree matches a closed form, although many ensembles stop early.

    The share is that for the first batch of members, at known fall probabilities.

    Counted over all members that were run, the share would depend on stopping: 0.48 in place of 0.34 for (0.1, 0.85).
    """
    cells, settings = 20_000, EnsembleSettings()
    towards, away = chances
    generator = np.random.default_rng(11)
    values = np.array([1, -1, 0], np.int8)
    flags = generator.choice(values, p=[towards, away, 1 - towards - away], size=(cells, settings.members))
    runs = np.full(cells, settings.members)
    for size in (16, 8):
        first = np.where(np.arange(settings.members) < size, flags, np.int8(-128))
        runs = np.where(fall_probability_convergence_mask(first, settings.half_width), size, runs)
    made = np.arange(settings.members) < runs[:, None]
    shares = [((flags == side) & made).sum(axis=1) / runs for side in (1, -1)]
    outcomes = np.array([(i, j, 8 - i - j) for i in range(9) for j in range(9 - i)])
    chance = multinomial.pmf(outcomes, 8, [towards, away, 1 - towards - away])
    both = (np.minimum(outcomes[:, 0], outcomes[:, 1]) > 0) & (outcomes[:, 2] < 4)
    fall = towards + away
    for statistic, expected in (
        (indicator_that_some_runs_fall_and_others_stand, 1 - fall**8 - (1 - fall) ** 8),
        (indicator_that_most_runs_fall_and_sides_differ, chance[both].sum()),
    ):
        found = average_first_batch_statistic_over_run_orders(statistic, *shares, runs, settings)
        assert found.mean() == pytest.approx(expected, abs=4 * max(found.std(), 1e-3) / np.sqrt(cells))
    assert np.isnan(
        average_first_batch_statistic_over_run_orders(
            indicator_that_some_runs_fall_and_others_stand, [np.nan], [np.nan], [0], settings
        )
    ).all()
    # Without stopping each order of the runs is as good: 1 of 16 is among the first 8 of them in one half.
    assert average_first_batch_statistic_over_run_orders(
        indicator_that_some_runs_fall_and_others_stand,
        [1 / 16],
        [0.0],
        [16],
        EnsembleSettings(members=16, half_width=0.0),
    ) == pytest.approx(0.5)
    assert average_first_batch_statistic_over_run_orders(
        indicator_that_some_runs_fall_and_others_stand, [1 / 15], [0.0], [15], EnsembleSettings(members=16)
    ) == pytest.approx(8 / 15)
    many = average_first_batch_statistic_over_run_orders(
        indicator_that_some_runs_fall_and_others_stand,
        [1 / 400],
        [0.0],
        [400],
        EnsembleSettings(members=400, half_width=0.0),
    )
    assert many == pytest.approx(8 / 400)


@pytest.mark.parametrize(
    ("towards", "away", "parts", "both"),
    [(0, 0, 0, 0), (3, 0, 1, 0), (8, 0, 0, 0), (5, 1, 1, 1), (4, 4, 0, 1), (2, 1, 1, 0), (2, 2, 1, 0), (1, 4, 1, 1)],
)
def test_runs_that_disagree_or_mostly_fall_to_both_sides_are_recognised(
    towards: int, away: int, parts: int, both: int
) -> None:
    """Runs disagree if some fall and some stand; falls to both sides need more than half of the runs to fall."""
    assert indicator_that_some_runs_fall_and_others_stand(np.array(towards), np.array(away), 8) == parts
    assert indicator_that_most_runs_fall_and_sides_differ(np.array(towards), np.array(away), 8) == both
