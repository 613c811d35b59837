"""Published overturning criteria: limits of peak motion by size and shape of a block, and their skill.

Limits are peak ground accelerations, m/s² (`ishiyama_velocity_limit`: velocities, m/s), up to which a block of height
H, m, does not rock or overturn; some depend on PGV/PGA, s. Each docstring states how the formula was checked, and
whether its source was available. An `ArgumentError` is raised if an argument is not positive.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.statistics.bootstrap import MeanOverEarthquakes, bootstrap_interval
from overturning.statistics.criteria_limits import OVERTURNING_CRITERIA, _pulse_to_block_frequency_ratio
from overturning.statistics.logistic import overturning_regression_data
from overturning.units import STANDARD_GRAVITY


class WeightedFallPredictionCounts(NamedTuple):
    """Weighted counts of hits, misses, false alarms and correct rejections of a rule that predicts falls.

    Each count is a number or an array. The shares computed from them are NaN where the denominator is 0.
    """

    hits: Any
    misses: Any
    false_alarms: Any
    correct_rejections: Any

    @classmethod
    def from_count_array(cls, prediction_counts: FloatArray) -> "WeightedFallPredictionCounts":
        """Create the counts from an array with (hits, misses, false alarms, rejections) along the last axis."""
        return cls(*np.moveaxis(prediction_counts, -1, 0))

    @property
    def actual_fall_share(self) -> Any:
        """Weighted share of all cases in which the block falls, predicted or not."""
        return _divide_with_nan_for_zero_over_zero(self.hits + self.misses, sum(self))

    @property
    def hit_rate(self) -> Any:
        """Weighted share, of the cases in which the block falls, for which a fall is predicted."""
        return _divide_with_nan_for_zero_over_zero(self.hits, self.hits + self.misses)

    @property
    def false_alarm_rate(self) -> Any:
        """Weighted share, of the cases in which the block stands, for which a fall is predicted."""
        return _divide_with_nan_for_zero_over_zero(self.false_alarms, self.false_alarms + self.correct_rejections)

    @property
    def peirce_skill_score(self) -> Any:
        """Peirce skill score: hit rate minus false-alarm rate; 1 for perfect predictions, 0 for random ones."""
        return self.hit_rate - self.false_alarm_rate


def _divide_with_nan_for_zero_over_zero(numerator: Any, denominator: Any) -> Any:
    """Divide two numbers or arrays; the result is NaN for 0/0."""
    with np.errstate(invalid="ignore"):
        return np.divide(numerator, denominator)


SLENDERNESS_ONLY_RULE_NAME: Final = "B/H alone"
"""Name of the rule that ignores the motion."""

MAX_VALID_PULSE_TO_BLOCK_FREQUENCY_RATIO: Final = 5.0
"""Largest ω/p for which `pulse_acceleration_to_overturn_after_impact` is valid; above it the limit is far too low."""


@dataclass(frozen=True)
class PredictionRuleScore:
    """Score of a rule that predicts whether a block falls from its height and B/H and the motion's PGA and PGV.

    Attributes
    ----------
    name, rule_text : str
        Name and rule, in words, of the criterion, or of the rule that ignores the motion.
    counts_over_all_cases, peirce_skill_over_all_cases : WeightedFallPredictionCounts, MeanOverEarthquakes
        Counts over all planes and blocks together, and their Peirce skill with its 95 % bootstrap interval over
        earthquakes.
    weighted_mean_skill_over_block_sizes : MeanOverEarthquakes
        Skill for each block size (height and B/H), averaged over sizes with the weights f(1 − f), where f is the
        share of cases in which a block of this size falls; with its 95 % bootstrap interval over earthquakes.
    weighted_mean_skill_in_pulse_valid_range : float
        Mean skill as in ``weighted_mean_skill_over_block_sizes``, but only of the cases in which the ratio ω/p of
        pulse frequency to block frequency is at most `MAX_VALID_PULSE_TO_BLOCK_FREQUENCY_RATIO`.
    """

    name: str
    rule_text: str
    counts_over_all_cases: WeightedFallPredictionCounts
    peirce_skill_over_all_cases: MeanOverEarthquakes
    weighted_mean_skill_over_block_sizes: MeanOverEarthquakes
    weighted_mean_skill_in_pulse_valid_range: float


@dataclass(frozen=True)
class OverturningCriteriaScores:
    """Scores of published overturning criteria, and of a rule that predicts falls from the slenderness B/H alone.

    Attributes
    ----------
    rule_scores : tuple of PredictionRuleScore
        Scores of `OVERTURNING_CRITERIA`, in their order, and of the rule that ignores the motion: a block falls if B/H
        is below a threshold, which is chosen for the largest skill on this cube.
    best_minus_other_skill_by_criterion_name : dict of str to MeanOverEarthquakes
        ``weighted_mean_skill_over_block_sizes`` of the best criterion minus that of each other criterion, by name of
        the other, with the interval of the difference (the same bootstrap samples for the two). Empty if the skill of
        a criterion is undefined.
    case_share_above_valid_pulse_frequency_ratio : float
        Weighted share of cases in which the ratio ω/p of pulse frequency to block frequency is above
        `MAX_VALID_PULSE_TO_BLOCK_FREQUENCY_RATIO`.
    criterion_counts_by_height_and_b_over_h : dict of (float, float) to tuple of WeightedFallPredictionCounts
        Counts of each of `OVERTURNING_CRITERIA`, in their order, by height, m, and B/H of the block.
    """

    rule_scores: tuple[PredictionRuleScore, ...]
    best_minus_other_skill_by_criterion_name: dict[str, MeanOverEarthquakes]
    case_share_above_valid_pulse_frequency_ratio: float
    criterion_counts_by_height_and_b_over_h: dict[tuple[float, float], tuple[WeightedFallPredictionCounts, ...]]

    @property
    def score_of_best_criterion(self) -> PredictionRuleScore:
        """Score of the published criterion whose prediction skill, averaged over block sizes, is largest."""
        return max(
            self.rule_scores[: len(OVERTURNING_CRITERIA)],
            key=lambda one: np.nan_to_num(one.weighted_mean_skill_over_block_sizes.mean, nan=-np.inf),
        )


def score_overturning_criteria(cube: xr.Dataset, pga_and_pgv: xr.Dataset) -> OverturningCriteriaScores | None:
    """Score how well published criteria predict the simulated falls; None if no outcome is known.

    `pga_and_pgv` has ``pga`` and ``pgv`` of each record and azimuth. The data are those of
    `overturning_regression_data`, with nominal outcomes instead of ensemble probabilities.
    """
    predictors, falls, event, weight = overturning_regression_data(cube, pga_and_pgv, use_ensemble=False)
    if not falls.size:
        return None
    over_west, ratio, slender, height = np.exp(predictors).T
    pga = over_west * STANDARD_GRAVITY * slender
    # Rounding errors of the logarithm must not separate equal values.
    kinds, block = np.unique(np.stack([height, slender], axis=1).round(9), axis=0, return_inverse=True)
    of_block = [(float(tall), float(shape)) for tall, shape in kinds]
    group = np.unique(event, return_inverse=True)[1] * len(kinds) + block.ravel()
    valid = _pulse_to_block_frequency_ratio(height, slender, ratio) <= MAX_VALID_PULSE_TO_BLOCK_FREQUENCY_RATIO

    def count_predictions_by_earthquake_and_block(
        predicts_fall_by_case: NDArray[np.bool_], weight_by_case: FloatArray
    ) -> FloatArray:
        """Count hits, misses, false alarms and rejections by earthquake and block, shape (earthquakes, blocks, 4)."""
        columns = (
            falls * predicts_fall_by_case, falls * ~predicts_fall_by_case,
            (1 - falls) * predicts_fall_by_case, (1 - falls) * ~predicts_fall_by_case,
        )  # fmt: skip
        counts = [np.bincount(group, weight_by_case * column, np.unique(event).size * len(kinds)) for column in columns]
        return np.stack(counts, axis=1, dtype=np.float64).reshape(-1, len(kinds), 4)

    def score_rule(rule_name: str, rule_in_words: str, predicts_fall_by_case: NDArray[np.bool_]) -> PredictionRuleScore:
        counts = count_predictions_by_earthquake_and_block(predicts_fall_by_case, weight)
        overall = WeightedFallPredictionCounts.from_count_array(counts.sum(axis=(0, 1)))
        skill, within = (
            MeanOverEarthquakes(
                len(counts), float(of(counts)), *bootstrap_interval(of, counts, statistic_bounds=(-1.0, 1.0))
            )
            for of in (_peirce_skill_over_all_blocks, _skill_within_blocks_weighted_by_outcome_variance)
        )
        valid_counts = count_predictions_by_earthquake_and_block(predicts_fall_by_case, weight * valid)
        if rule_name == SLENDERNESS_ONLY_RULE_NAME:  # 0 within blocks by definition, not by chance
            within = replace(within, interval_low=math.nan, interval_high=math.nan)
        weighted_skill = float(_skill_within_blocks_weighted_by_outcome_variance(valid_counts))
        return PredictionRuleScore(rule_name, rule_in_words, overall, skill, within, weighted_skill)

    predictions = [
        pga >= one.pga_limit_from_height_b_over_h_pgv_over_pga(height, slender, ratio) for one in OVERTURNING_CRITERIA
    ]
    rules = [
        score_rule(one.name, one.rule_text, mask) for one, mask in zip(OVERTURNING_CRITERIA, predictions, strict=True)
    ]
    shapes = np.unique(kinds[:, 1])
    bounds = ((shapes[1:] + shapes[:-1]) / 2).round(9).tolist()
    blind = [score_rule(SLENDERNESS_ONLY_RULE_NAME, f"B/H below {bound:.3g}", slender < bound) for bound in bounds]
    rules += sorted(blind, key=lambda one: np.nan_to_num(-one.counts_over_all_cases.peirce_skill_score, nan=1.0))[:1]
    by_event = {
        one.name: count_predictions_by_earthquake_and_block(predicted, weight)
        for one, predicted in zip(OVERTURNING_CRITERIA, predictions, strict=True)
    }
    counts = np.stack([one.sum(axis=0) for one in by_event.values()], axis=1)
    blocks = {
        name: tuple(map(WeightedFallPredictionCounts.from_count_array, each))
        for name, each in zip(of_block, counts, strict=True)
    }
    beyond = float((weight * ~valid).sum() / weight.sum())
    return OverturningCriteriaScores(tuple(rules), _best_minus_other_skill_by_name(by_event), beyond, blocks)


def _best_minus_other_skill_by_name(
    confusion_counts_by_criterion_name: dict[str, FloatArray],
) -> dict[str, MeanOverEarthquakes]:
    """Compute the best criterion's prediction skill minus that of each other criterion, by name of the other.

    See `OverturningCriteriaScores.best_minus_other_skill_by_criterion_name`. The counts of each criterion have shape
    (earthquakes, blocks, 4).
    """
    skills = {
        name: float(_skill_within_blocks_weighted_by_outcome_variance(counts))
        for name, counts in confusion_counts_by_criterion_name.items()
    }
    if not np.isfinite([*skills.values()]).all():
        return {}
    best = max(skills, key=lambda name: skills[name])

    def first_minus_second_skill(counts_of_criterion_pair: FloatArray) -> FloatArray:
        first, second = np.split(counts_of_criterion_pair, 2, axis=-1)
        return _skill_within_blocks_weighted_by_outcome_variance(
            first
        ) - _skill_within_blocks_weighted_by_outcome_variance(second)

    pairs = {
        name: np.concatenate([confusion_counts_by_criterion_name[best], counts], axis=-1)
        for name, counts in confusion_counts_by_criterion_name.items()
    }
    return {
        name: MeanOverEarthquakes(
            len(pair),
            float(first_minus_second_skill(pair)),
            *bootstrap_interval(first_minus_second_skill, pair, statistic_bounds=(-2.0, 2.0)),
        )
        for name, pair in pairs.items()
        if name != best
    }


def _peirce_skill_over_all_blocks(prediction_counts_by_earthquake_and_block: FloatArray) -> FloatArray:
    """Compute the prediction skill over all blocks together, from counts of shape (…, earthquakes, blocks, 4)."""
    counts = WeightedFallPredictionCounts.from_count_array(prediction_counts_by_earthquake_and_block.sum(axis=(-3, -2)))
    return np.asarray(counts.peirce_skill_score)


def _skill_within_blocks_weighted_by_outcome_variance(
    prediction_counts_by_earthquake_and_block: FloatArray,
) -> FloatArray:
    """Compute prediction skill for each block size, and average over sizes; counts: (…, earthquakes, blocks, 4).

    The weight of a block size is f(1 − f), where f is the share of its cases that fall. So a block that nearly always
    falls, or nearly always stands, has a small weight: its skill depends on a few cases. f(1 − f) is the variance of
    the outcome, so the mean is the slope of a regression of outcomes on predictions within blocks.
    """
    counts = WeightedFallPredictionCounts.from_count_array(prediction_counts_by_earthquake_and_block.sum(axis=-3))
    skill, fall_share = counts.peirce_skill_score, counts.actual_fall_share
    weight = np.where(np.isfinite(skill), fall_share * (1 - fall_share), 0.0)
    return np.asarray(
        _divide_with_nan_for_zero_over_zero(
            (weight * np.where(weight > 0, skill, 0.0)).sum(axis=-1), weight.sum(axis=-1)
        )
    )
