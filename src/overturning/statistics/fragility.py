"""Fragility: lognormal curves of the share of stones that fall as a function of motion intensity."""

import math
import re
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.statistics.bootstrap import ConfidenceInterval, bootstrap_interval

MAX_NEWTON_ITERATIONS: Final = 100
"""Maximum number of Newton steps; a fit that needs more does not converge."""

MAX_COEFFICIENT_CHANGE_PER_NEWTON_STEP: Final = 2.0
"""Largest change of constant or slope in one Newton step, for intensities scaled to unit standard deviation."""

STANDARDISED_RECORD_DEVIATION_POINTS: Final = np.linspace(-6.0, 6.0, 1201)
"""Integration points for the deviation of a record from its intensity, in standard deviations."""

MAX_VALUES_PER_FIT_BATCH: Final = 50_000
"""Largest number of values (samples × shares) in one batch of fits, so that the arrays stay in the cache."""


@dataclass(frozen=True)
class FittedFragilityCurve:
    """Fitted lognormal fragility curve of a class of stones: P(fall) = Φ(ln(x/median)/spread), x the intensity.

    Attributes
    ----------
    stone_class : str
        Name of the class of stones.
    measure, unit : str
        Intensity measure and its unit.
    median, spread : float
        Median in `unit`, and standard deviation of ln(x); NaN if no curve fits.
    median_interval : ConfidenceInterval
        95 % interval of the median, by bootstrap over earthquakes.
    min_intensity_of_validity_range, max_intensity_of_validity_range : float
        Range of the fitted intensities; the curve is not valid outside.
    record_variance_share : float
        Share of the variance spread² due to differences between records (`variance_share_between_records`); NaN if
        unknown.
    median_interval_and_log_std_censored_to_data : float, ConfidenceInterval, float
        Median, its interval and the spread, limited to the range of the data: a median or interval end is replaced by
        infinity above `max_intensity_of_validity_range` and by 0 below `min_intensity_of_validity_range`; the spread is
        NaN if the median lies outside this range.
    """

    stone_class: str
    measure: str
    unit: str
    median: float
    spread: float
    median_interval: ConfidenceInterval
    min_intensity_of_validity_range: float
    max_intensity_of_validity_range: float
    record_variance_share: float = math.nan

    @property
    def log_std_between_records_and_between_stones(self) -> tuple[float, float]:
        """Standard deviations of ln(intensity) between records, and between stones under one record; NaN if unknown."""
        spread = self.median_interval_and_log_std_censored_to_data[2]
        return spread * math.sqrt(self.record_variance_share), spread * math.sqrt(1 - self.record_variance_share)

    @property
    def stone_class_as_openquake_identifier(self) -> str:
        """Name of the stone class as an identifier for OpenQuake: only letters, digits, _ and -."""
        return re.sub(r"[^A-Za-z0-9_-]+", "_", self.stone_class.replace("/", "").replace(".", "p"))

    @property
    def median_interval_and_log_std_censored_to_data(self) -> tuple[float, ConfidenceInterval, float]:  # noqa: D102
        median, low, high = (
            math.inf
            if one > self.max_intensity_of_validity_range
            else 0.0
            if one < self.min_intensity_of_validity_range
            else one
            for one in (self.median, *self.median_interval)
        )
        return (
            median,
            ConfidenceInterval(low, high),
            self.spread
            if self.min_intensity_of_validity_range <= median <= self.max_intensity_of_validity_range
            else math.nan,
        )

    def fall_probability(self, intensity_in_curve_unit: ArrayLike) -> FloatArray:
        """Return the probability that a stone falls at each intensity, given in the unit of the curve."""
        over = np.asarray(intensity_in_curve_unit, dtype=np.float64) / self.median
        return np.asarray(scipy.special.ndtr(np.log(over) / self.spread))


def fit_lognormal_median_and_log_std(
    intensity_by_motion: ArrayLike, fall_share_by_motion: ArrayLike, weight_by_motion: ArrayLike | None = None
) -> tuple[float, float]:
    """Fit the median and log standard deviation of a fragility curve to shares of fallen stones, by maximum likelihood.

    Method: Baker (2015, Earthquake Spectra 31, eq. 11).

    Parameters
    ----------
    intensity_by_motion, fall_share_by_motion, weight_by_motion : array_like, shape (n,)
        Positive intensities, share of stones that fell (0 to 1), and weights (default 1; entries of weight 0 do not
        count).

    Returns
    -------
    (float, float)
        Median and spread (standard deviation of the logarithm). NaN if no stone falls, all fall, the shares hardly
        increase with intensity, or an intensity separates shares of 0 from shares of 1, so that the likelihood
        increases as the spread goes to 0 (Albert & Anderson 1984, Biometrika 71).

    Raises
    ------
    ArgumentError
        If shapes differ, an intensity is not positive or a share lies outside 0 to 1.
    """
    x, y = np.asarray(intensity_by_motion, dtype=np.float64), np.asarray(fall_share_by_motion, dtype=np.float64)
    w = np.ones_like(y) if weight_by_motion is None else np.asarray(weight_by_motion, dtype=np.float64)
    if x.shape != y.shape:
        raise ArgumentError(
            f"fall_share_by_motion: shape {y.shape}, intensity_by_motion {x.shape}; one share per intensity"
        )
    if x.size and not (x.min() > 0 and y.min() >= 0 and y.max() <= 1):
        raise ArgumentError("intensities must be positive, and shares lie in 0 to 1")
    x, y, w = x[w > 0], y[w > 0], w[w > 0]
    if x.size < 2 or y.min() == y.max() or x[y > 0].min() >= x[y < 1].max():
        return math.nan, math.nan
    (median,), (spread,) = _fit_lognormal_medians_and_log_stds(np.log(x), y, w[None])
    return float(median), float(spread)


def _fit_lognormal_medians_and_log_stds(
    log_intensity_by_motion: FloatArray,
    fall_share_by_motion: FloatArray,
    weights_by_fit_and_motion: FloatArray,
    start_median_and_log_std: tuple[float, float] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Fit m lognormal fragility curves by Newton's method, one for each row of the weights, shape (m, n).

    Return m medians and m spreads (standard deviations of ln intensity), NaN without a fit. `log_intensity_by_motion`
    and `fall_share_by_motion` have shape (n,). The iteration starts from the curve ``start_median_and_log_std``. The
    log-likelihood is concave; a step that lowers it is halved, because otherwise the iteration can oscillate.
    """
    middle, width = float(log_intensity_by_motion.mean()), max(float(log_intensity_by_motion.std()), 1e-3)
    scaled = (log_intensity_by_motion - middle) / width
    # Constant and slope of each row, their likelihood, the next step, and the rows that have not converged.
    first = (
        (0.0, 1.0)
        if start_median_and_log_std is None
        else (
            (middle - math.log(start_median_and_log_std[0])) / start_median_and_log_std[1],
            width / start_median_and_log_std[1],
        )
    )
    found, moving = np.tile(first, (len(weights_by_fit_and_motion), 1)), np.ones(len(weights_by_fit_and_motion), bool)
    likelihood, trying = np.full(len(weights_by_fit_and_motion), -np.inf), np.zeros_like(found)
    for iteration in range(MAX_NEWTON_ITERATIONS):
        at = np.flatnonzero(moving)
        if not at.size:
            break
        tried = found[at] + trying[at]
        different = slice(None) if iteration else slice(1)  # all rows start at the same point
        z = tried[different, :1] + tried[different, 1:] * scaled
        below, above = scipy.special.log_ndtr(z), scipy.special.log_ndtr(-z)
        reached = (
            weights_by_fit_and_motion[at] * (fall_share_by_motion * below + (1 - fall_share_by_motion) * above)
        ).sum(axis=1)
        worse = reached < likelihood[at] - 1e-12 * np.abs(reached)
        trying[at[worse]] /= 2
        better = at[~worse]
        if worse.any():
            z, below, above = z[~worse], below[~worse], above[~worse]
        found[better], likelihood[better], w = tried[~worse], reached[~worse], weights_by_fit_and_motion[better]
        density = -0.5 * z * z - 0.5 * math.log(2 * math.pi)
        falls, stands = np.exp(density - below), np.exp(density - above)
        score = w * (fall_share_by_motion * falls - (1 - fall_share_by_motion) * stands)
        information = w * (
            fall_share_by_motion * falls * (falls + z) + (1 - fall_share_by_motion) * stands * (stands - z)
        )  # minus the score's slope
        gradient = np.stack([score.sum(axis=1), score @ scaled], axis=1)
        a, b, c = information.sum(axis=1), information @ scaled, information @ scaled**2
        with np.errstate(divide="ignore", invalid="ignore"):  # no step if the data are separated
            step = np.stack([c * gradient[:, 0] - b * gradient[:, 1], a * gradient[:, 1] - b * gradient[:, 0]], axis=1)
            step /= (a * c - b * b)[:, None]
            step *= np.minimum(
                1.0,
                MAX_COEFFICIENT_CHANGE_PER_NEWTON_STEP
                / np.maximum(np.abs(step).max(axis=1), MAX_COEFFICIENT_CHANGE_PER_NEWTON_STEP),
            )[:, None]
        trying[better] = step
        moving[better] = np.abs(gradient).max(axis=1) > 1e-9 * w.sum(axis=1)
    found = np.where(moving[:, None], np.nan, found + trying)
    slope = found[:, 1] / width
    # A spread above 3 means that the shares hardly depend on intensity. Where an intensity separates the shares, the
    # slope has no bound; unless it reaches 1e3, the median is a value between the separated intensities.
    slope = np.where((slope > 1 / 3) & (slope < 1e3), slope, np.nan)
    return np.exp(middle - found[:, 0] / slope), 1 / slope


def variance_share_between_records(
    median_and_log_std: tuple[float, float],
    intensity_by_motion: FloatArray,
    fall_share_by_motion: FloatArray,
    record_label_by_motion: NDArray[np.generic],
    stone_count_by_motion: ArrayLike,
) -> float:
    """Estimate the share of a fragility curve's variance (spread²) that is due to differences between records.

    The share is 0 if equal intensities have equal shares of falls.

    A stone falls if ln(x/median) exceeds its capacity, the sum of two normal deviates: one common to all stones under
    a record, and one of the stone (probit model with a random intercept: Ochi & Prentice 1984, Biometrika 71, 531).
    Median and total spread are those fitted without regard to records, which are consistent (Liang & Zeger 1986,
    Biometrika 73, 13). The share maximises the likelihood, integrated over the deviates of the records.

    Parameters
    ----------
    median_and_log_std : (float, float)
        Median and spread from `fit_lognormal_median_and_log_std`.
    intensity_by_motion, fall_share_by_motion, record_label_by_motion : ndarray, shape (n,)
        Intensities, share of stones that fell, and the record of each share.
    stone_count_by_motion : array_like, shape (n,) or ()
        Number of stones of each share: those with a known outcome.

    Returns
    -------
    float
        0 to 0.99; NaN if there is no curve.
    """
    if not math.isfinite(median_and_log_std[0]):
        return math.nan
    z = np.log(intensity_by_motion / median_and_log_std[0]) / median_and_log_std[1]
    count = np.broadcast_to(np.asarray(stone_count_by_motion, dtype=np.float64), z.shape)
    by_record = (record_label_by_motion == one for one in np.unique(record_label_by_motion))
    records = [(z[own, None], fall_share_by_motion[own, None], count[own, None]) for own in by_record]
    density = -0.5 * STANDARDISED_RECORD_DEVIATION_POINTS**2

    def negative_log_likelihood(between_record_variance_share: float) -> float:
        log_likelihoods = []
        for level, fell, stones in records:
            at = (level + math.sqrt(between_record_variance_share) * STANDARDISED_RECORD_DEVIATION_POINTS) / math.sqrt(
                1 - between_record_variance_share
            )
            each = stones * (fell * scipy.special.log_ndtr(at) + (1 - fell) * scipy.special.log_ndtr(-at))
            log_likelihoods.append(each.sum(axis=0) + density)
        return -float(scipy.special.logsumexp(log_likelihoods, axis=1).sum())

    found = scipy.optimize.minimize_scalar(
        negative_log_likelihood, bounds=(0.0, 0.99), method="bounded", options={"xatol": 1e-3}
    )
    return float(found.x)


def fit_fragility_curve(
    stone_class_name: str,
    intensity_measure_and_unit: tuple[str, str],
    intensity_by_motion: FloatArray,
    fall_share_by_motion: FloatArray,
    earthquake_name_by_motion: NDArray[np.str_],
    *,
    record_label_by_motion: NDArray[np.generic] | None = None,
    stone_count_by_motion: ArrayLike = 0,
) -> FittedFragilityCurve:
    """Fit the fragility curve of a class of stones, with a bootstrap interval of its median.

    `intensity_by_motion`, `fall_share_by_motion`, `earthquake_name_by_motion` and `record_label_by_motion` have one
    entry for each motion, shape (n,).

    If ``record_label_by_motion`` is given, the share of the variance between records is estimated, too; this needs
    ``stone_count_by_motion``, the number of stones with a known outcome under each motion.
    """
    known = np.isfinite(fall_share_by_motion) & (intensity_by_motion > 0)
    intensity_by_motion, fall_share_by_motion, earthquake_name_by_motion = (
        intensity_by_motion[known],
        fall_share_by_motion[known],
        earthquake_name_by_motion[known],
    )
    median, spread = fit_lognormal_median_and_log_std(intensity_by_motion, fall_share_by_motion)
    between = math.nan
    if record_label_by_motion is not None:
        stones = np.broadcast_to(stone_count_by_motion, known.shape)[known]
        between = variance_share_between_records(
            (median, spread), intensity_by_motion, fall_share_by_motion, record_label_by_motion[known], stones
        )
    names, member = np.unique(earthquake_name_by_motion, return_inverse=True)

    def medians_of_bootstrap_samples(earthquake_indices_by_bootstrap_sample: NDArray[np.intp]) -> FloatArray:
        count = (earthquake_indices_by_bootstrap_sample[:, :, None] == np.arange(names.size)).sum(
            axis=1, dtype=np.float64
        )
        parts = np.array_split(
            count,
            math.ceil(
                len(earthquake_indices_by_bootstrap_sample) * fall_share_by_motion.size / MAX_VALUES_PER_FIT_BATCH
            ),
        )
        return np.concatenate(
            [
                _fit_lognormal_medians_and_log_stds(
                    np.log(intensity_by_motion), fall_share_by_motion, part[:, member], (median, spread)
                )[0]
                for part in parts
            ]
        )

    ends_of_median = ConfidenceInterval()
    if math.isfinite(median):
        ends_of_median = bootstrap_interval(medians_of_bootstrap_samples, np.arange(names.size))
    ends = (
        (float(intensity_by_motion.min()), float(intensity_by_motion.max()))
        if intensity_by_motion.size
        else (math.nan, math.nan)
    )
    return FittedFragilityCurve(
        stone_class_name, *intensity_measure_and_unit, median, spread, ends_of_median, *ends, between
    )
