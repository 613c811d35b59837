"""Published overturning criteria: limits of peak motion by size and shape of a block, and their skill.

Limits are peak ground accelerations, m/s² (`ishiyama_velocity_limit`: velocities, m/s), up to which a block of height
H, m, does not rock or overturn; some depend on PGV/PGA, s. Each docstring states how the formula was checked, and
whether its source was available. An `ArgumentError` is raised if an argument is not positive.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.statistics.bootstrap import MeanOverEarthquakes, bootstrap_interval
from overturning.statistics.logistic import overturning_regression_data
from overturning.units import CM, GAL, STANDARD_GRAVITY


def _checked_positive_array(argument_name: str, argument_values: ArrayLike) -> FloatArray:
    """Return `argument_values` as an array; raise an `ArgumentError` unless all are positive and finite."""
    array = np.asarray(argument_values, dtype=np.float64)
    if not (np.isfinite(array).all() and (array > 0).all()):
        raise ArgumentError(
            f"{argument_name}: {array.min() if array.size else 'nothing'}; it must be positive and finite"
        )
    return array


def west_acceleration_limit(b_over_h: ArrayLike) -> FloatArray:
    """Return West's limit g B/H, m/s²: the acceleration above which a rigid block of width B, height H rocks.

    West's formula as given by Milne (1885, Transactions of the Seismological Society of Japan 8).
    """
    return STANDARD_GRAVITY * _checked_positive_array("b_over_h", b_over_h)


def ishiyama_velocity_limit(height: ArrayLike, b_over_h: ArrayLike) -> FloatArray:
    """Return Ishiyama's limit of peak ground velocity, m/s, below which a block of height H (m) does not overturn.

    v = 0.4 √(8 g R/3 · (1 − cos α)/cos² α), R half the diagonal, tan α = B/H (Ishiyama 1982, Earthquake
    Engineering and Structural Dynamics 10); about 10 B/√H in cm and cm/s for slender blocks.
    """
    tall, slenderness = _checked_positive_array("height", height), _checked_positive_array("b_over_h", b_over_h)
    alpha = np.arctan(slenderness)
    radius = tall * np.sqrt(1 + slenderness**2) / 2
    # 1 − cos α = 2 sin²(α/2), without cancellation for slender blocks.
    return np.asarray(
        0.4 * np.sqrt(8 * STANDARD_GRAVITY * radius / 3 * 2 * np.sin(alpha / 2) ** 2) / np.cos(alpha), dtype=np.float64
    )


def max_of_west_and_ishiyama_acceleration_limits(
    height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike
) -> FloatArray:
    """Return the PGA (m/s²) above which a block overturns: the larger of West's and Ishiyama's limits.

    The limits are g B/H and `ishiyama_velocity_limit` divided by PGV/PGA, s.
    """
    by_velocity = ishiyama_velocity_limit(height, b_over_h) / _checked_positive_array("pgv_over_pga", pgv_over_pga)
    return np.maximum(west_acceleration_limit(b_over_h), by_velocity)


def kaneko_hayashi_transition_frequency(height: ArrayLike, b_over_h: ArrayLike) -> FloatArray:
    """Return the frequency, Hz, above which the Kaneko–Hayashi criterion uses its formula for high frequencies.

    F_b = 15.6/√H (1 + B/H)^−1.5 with H in cm; `height` is in m.
    """
    tall, slenderness = _checked_positive_array("height", height) / CM, _checked_positive_array("b_over_h", b_over_h)
    return np.asarray(15.6 / np.sqrt(tall) * (1 + slenderness) ** -1.5)


def kaneko_hayashi_median_fall_pga(height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike) -> FloatArray:
    """Return the PGA, m/s², at which half of the blocks of height H, m, overturn (Kaneko & Hayashi).

    A₅₀ = g B/H (1 + B/H) up to the frequency F_b, 10 B/√H (1 + B/H)^2.5 · 2π F above, in cm, cm/s² and Hz,
    with the motion's frequency F = PGA/(2π PGV) (Kaneko & Hayashi 2000, Journal of Structural and Construction
    Engineering, AIJ, 536). The paper was not available. The branches meet at F_b within 0.05 % (10 · 15.6 · 2π =
    980.2 cm/s², which is g), so the coefficients are consistent with each other.
    """
    tall, slenderness = _checked_positive_array("height", height) / CM, _checked_positive_array("b_over_h", b_over_h)
    frequency = 1 / (2 * np.pi * _checked_positive_array("pgv_over_pga", pgv_over_pga))
    low = STANDARD_GRAVITY * slenderness * (1 + slenderness)
    high = 10 * slenderness * np.sqrt(tall) * (1 + slenderness) ** 2.5 * 2 * np.pi * frequency * GAL
    return np.where(frequency > kaneko_hayashi_transition_frequency(height, b_over_h), high, low)


def block_frequency_parameter(height: ArrayLike, b_over_h: ArrayLike) -> FloatArray:
    """Return p = √(3g/4R), rad/s, of a rectangular block of given height, m, and B/H; R is half its diagonal."""
    tall, slenderness = _checked_positive_array("height", height), _checked_positive_array("b_over_h", b_over_h)
    return np.asarray(np.sqrt(1.5 * STANDARD_GRAVITY / (tall * np.sqrt(1 + slenderness**2))))


def _pulse_to_block_frequency_ratio(height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike) -> FloatArray:
    """Return ω/p: angular frequency ω = 2 PGA/PGV of a one-sine pulse, over the block's p = √(3g/4R)."""
    # A one-sine pulse of amplitude a and angular frequency ω has the peak velocity 2a/ω.
    return 2 / _checked_positive_array("pgv_over_pga", pgv_over_pga) / block_frequency_parameter(height, b_over_h)


def pulse_acceleration_to_overturn_after_impact(
    height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike
) -> FloatArray:
    """Return the PGA, m/s², at which a single sine pulse overturns a block after one impact on its base.

    a = g B/H (1 + ω/6p), ω = 2 PGA/PGV the pulse's frequency (Makris & Roussos 2000, Géotechnique 50, for
    near-source pulses). The paper was not available. Compared with the rocking block, the formula is 0 to 11 % too
    high for ω/p of 1 to 4 and B/H = 0.1, and far too low for ω/p above 5.
    """
    ratio = _pulse_to_block_frequency_ratio(height, b_over_h, pgv_over_pga)
    return west_acceleration_limit(b_over_h) * (1 + ratio / 6)


def sine_pulse_pga_to_overturn_without_impact(
    height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike
) -> FloatArray:
    """Return the PGA, m/s², at which a single sine pulse overturns a block without any impact on its base.

    a = A g B/H with √(A² − 1) − A exp(−(2π − arcsin 1/A) p/ω) = ω/p: the linearised slender block reaches
    its unstable equilibrium exactly at the end of the pulse (the mode without impact of Zhang & Makris 2001, Journal of
    Engineering Mechanics 127; in closed form as in Dimitrakopoulos & DeJong 2012, Proceedings of the Royal Society A
    468).
    """
    ratio = _pulse_to_block_frequency_ratio(height, b_over_h, pgv_over_pga)

    def left_minus_right_of_amplitude_equation(pulse_over_west_limit: FloatArray) -> FloatArray:
        length = (2 * np.pi - np.arcsin(1 / pulse_over_west_limit)) / ratio
        return np.asarray(np.sqrt(pulse_over_west_limit**2 - 1) - pulse_over_west_limit * np.exp(-length) - ratio)

    # The left side increases with A without bound, so bisection finds the root.
    low, high = np.ones_like(ratio), 2.0 + ratio + ratio**2
    for _ in range(60):
        middle = (low + high) / 2
        above = left_minus_right_of_amplitude_equation(middle) > 0
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return west_acceleration_limit(b_over_h) * high


@dataclass(frozen=True)
class OverturningCriterion:
    """Published overturning criterion: name, rule in words, and function that computes the PGA for overturning.

    The function gives the limit in m/s² from height (m), B/H and PGV/PGA (s).
    """

    name: str
    rule_text: str
    pga_limit_from_height_b_over_h_pgv_over_pga: Callable[[ArrayLike, ArrayLike, ArrayLike], FloatArray]


def _west_limit_of_each_block_and_motion(height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike) -> FloatArray:
    return west_acceleration_limit(b_over_h) * np.ones(np.broadcast_shapes(np.shape(height), np.shape(pgv_over_pga)))


OVERTURNING_CRITERIA: Final = (
    OverturningCriterion("West", "PGA above g B/H", _west_limit_of_each_block_and_motion),
    OverturningCriterion(
        "Ishiyama",
        "PGA above g B/H, and PGV above the velocity of Ishiyama (1982)",
        max_of_west_and_ishiyama_acceleration_limits,
    ),
    OverturningCriterion(
        "Kaneko–Hayashi", "PGA above the median of Kaneko and Hayashi (2000)", kaneko_hayashi_median_fall_pga
    ),
    OverturningCriterion(
        "pulse, one impact", "PGA above g B/H (1 + ω/6p), ω = 2 PGA/PGV", pulse_acceleration_to_overturn_after_impact
    ),
    OverturningCriterion(
        "pulse, no impact",
        "PGA above that of the one-sine pulse without impact",
        sine_pulse_pga_to_overturn_without_impact,
    ),
)
"""Criteria in the order of tables and figures."""

NAMES_OF_CRITERIA_FROM_SECONDARY_SOURCES: Final = ("Kaneko–Hayashi", "pulse, one impact")
"""Criteria taken from secondary sources; the docstring of each function states how it was checked."""


class WeightedFallPredictionCounts(NamedTuple):
    """Counts, weighted, of hits, misses, false alarms and correct rejections of a rule that predicts falls.

    Each is a number or an array; a share is NaN if its denominator is 0.
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
        Score of all planes and blocks together, and its skill with the 95 % bootstrap interval over earthquakes.
    weighted_mean_skill_over_block_sizes : MeanOverEarthquakes
        Mean skill over blocks of one height and B/H, weighted by f(1 − f) with f their share of falls, with the
        same kind of interval.
    weighted_mean_skill_in_pulse_valid_range : float
        Value of ``weighted_mean_skill_over_block_sizes`` without the planes above
        `MAX_VALID_PULSE_TO_BLOCK_FREQUENCY_RATIO`.
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
        Skill within blocks of the `score_of_best_criterion` minus that of each other one, with the interval of the
        difference; both from the same bootstrap samples. Empty if the skill of a criterion is undefined.
    case_share_above_valid_pulse_frequency_ratio : float
        Weighted share of cases (planes and blocks) whose ω/p is above `MAX_VALID_PULSE_TO_BLOCK_FREQUENCY_RATIO`.
    criterion_counts_by_height_and_b_over_h : dict of (float, float) to tuple of WeightedFallPredictionCounts
        Scores of `OVERTURNING_CRITERIA` by height, m, and B/H.
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

    The weight of a block is f(1 − f), where f is the share of cells of a block that fall. The skill of a block that
    nearly always falls, or stands, depends on a few cells. f(1 − f) is the variance of the outcome, so the mean is
    the slope of a regression of outcomes on predictions within blocks.
    """
    counts = WeightedFallPredictionCounts.from_count_array(prediction_counts_by_earthquake_and_block.sum(axis=-3))
    skill, fall_share = counts.peirce_skill_score, counts.actual_fall_share
    weight = np.where(np.isfinite(skill), fall_share * (1 - fall_share), 0.0)
    return np.asarray(
        _divide_with_nan_for_zero_over_zero(
            (weight * np.where(weight > 0, skill, 0.0)).sum(axis=-1), weight.sum(axis=-1)
        )
    )
