"""Directions and axes: mean, resultant and tests of uniformity, with the source of each formula.

A *direction* has a sense (a block fell towards 60°); an *axis* has none (60° and 240° are the same). Axes are
averaged by doubling their angles, and halving the mean (Mardia & Jupp 2000, Directional Statistics, sections 1.1 and
9.1).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.stored import StoredFloatOrNan

MAX_RESULTANT_LENGTH_FROM_ROUNDING = 1e-9
"""Resultant length below which a mean direction is only rounding error: the vectors cancel."""

MIN_RESULTANT_WITH_MEAN_DIRECTION: Final = 0.05
"""Smallest resultant length with a mean direction or axis; below it the falls are spread all round."""

ROSE_SECTOR_COUNT: Final = 24
"""Number of sectors of a rose; the first is centred on 0°."""

SIMULATED_SECTOR_COUNTS_PER_P_VALUE: Final = 20_000
"""Number of random draws for a simulated p-value."""

RANDOM_ROTATION_SETS_PER_RAYLEIGH_TEST: Final = 4_999
"""Number of random rotations in the `rayleigh_test_by_random_rotation`."""


_SECTOR_BORDER_TOLERANCE_DEG: Final = 1e-6
"""Largest distance from the border of two sectors at which an azimuth counts as on the border, degrees."""


def sector_index(angles_deg: ArrayLike, sector_count: int) -> NDArray[np.intp]:
    """Return, for each angle, the number of the sector that contains it; sector 0 is centred on 0°.

    An angle on a border belongs to the sector with the larger index.
    """
    wide = 360.0 / sector_count
    # Rounding may bring a small negative angle to 360° itself.
    return np.asarray(((np.asarray(angles_deg) + wide / 2) % 360.0 // wide).astype(np.intp) % sector_count)


def fall_shares_by_sector(
    fall_azimuths_deg: ArrayLike,
    weight_by_fall: FloatArray | None = None,
    width_to_spread_each_fall_over_deg: float = 0.0,
) -> FloatArray:
    """Compute the share of the falls (azimuths, degrees) that lies in each sector, shape (`ROSE_SECTOR_COUNT`,).

    Falls have the weights `weight_by_fall` (default 1). All shares are 0 without falls. A fall on the border of two
    sectors counts half in each.

    If ``width_to_spread_each_fall_over_deg`` is positive, the weight of each fall is spread evenly over this width,
    centred on its azimuth.
    """
    if width_to_spread_each_fall_over_deg > 0.0:
        angle, sector_wide = np.asarray(fall_azimuths_deg, np.float64), 360.0 / ROSE_SECTOR_COUNT
        # Borders of three full circles: an interval that crosses north continues in the next circle.
        border = sector_wide * (np.arange(-ROSE_SECTOR_COUNT, 2 * ROSE_SECTOR_COUNT + 1) - 0.5)
        below = np.clip((border - (angle % 360.0)[:, None]) / width_to_spread_each_fall_over_deg + 0.5, 0.0, 1.0)
        parts = np.diff(below, axis=1).reshape(-1, 3, ROSE_SECTOR_COUNT).sum(axis=1)
        counts = (np.ones_like(angle) if weight_by_fall is None else weight_by_fall) @ parts
    else:
        sides = (np.asarray(fall_azimuths_deg, np.float64) + way * _SECTOR_BORDER_TOLERANCE_DEG for way in (-1.0, 1.0))
        counts = sum(
            0.5 * np.bincount(sector_index(side, ROSE_SECTOR_COUNT), weight_by_fall, ROSE_SECTOR_COUNT)
            for side in sides
        )
    total = counts.sum()
    return counts / total if total > 0 else counts


def mean_angle_deg_and_mean_resultant_length(
    angles_deg: ArrayLike, weight_by_angle: ArrayLike | None = None, *, axial: bool = False
) -> tuple[float, float]:
    """Compute the mean direction (or axis) of weighted angles, and the mean resultant length (0 to 1).

    Formulas: Mardia & Jupp (2000, eqs 2.2.2 to 2.2.4).

    Angles (degrees) and non-negative weights (default 1) have shape (n,). If `axial`, the angles are those of axes,
    which are doubled before averaging.

    Returns
    -------
    mean_deg : float
        In [0, 360) for directions, in [0, 180) for axes; NaN if the vectors cancel.
    length : float
        Mean resultant length, 0 to 1, for axes of the doubled angles; NaN if the weights sum to 0.
    """
    angle = np.radians(np.asarray(angles_deg, dtype=np.float64)) * (2 if axial else 1)
    weights = np.ones_like(angle) if weight_by_angle is None else np.asarray(weight_by_angle, dtype=np.float64)
    total = float(weights.sum())
    if total <= 0:
        return math.nan, math.nan
    cosine, sine = float((weights * np.cos(angle)).sum()) / total, float((weights * np.sin(angle)).sum()) / total
    length = math.hypot(cosine, sine)
    if length < MAX_RESULTANT_LENGTH_FROM_ROUNDING:
        return math.nan, 0.0
    full = 180.0 if axial else 360.0
    mean = math.degrees(math.atan2(sine, cosine)) / (2 if axial else 1) % full
    return (0.0 if mean >= full else mean), min(length, 1.0)


def wrap_axis_difference_to_90_deg(angle_between_axes_deg: ArrayLike) -> FloatArray:
    """Wrap angles between axes, degrees, into (−90, 90], since an axis repeats after 180°."""
    return -((-np.asarray(angle_between_axes_deg, dtype=np.float64) + 90.0) % 180.0 - 90.0)


@dataclass(frozen=True)
class StatisticalTestResult:
    """Result of a statistical test on ``n`` independent observations: name of the test, statistic and p-value.

    The docstring of each test defines its statistic. The p-value is the probability, under the null hypothesis, of a
    statistic at least as extreme. Statistic and p-value are NaN for n = 0.
    """

    __test__ = False  # tells pytest that this is no test case

    name: str
    n: int
    statistic: StoredFloatOrNan = math.nan
    p_value: StoredFloatOrNan = math.nan


@lru_cache(maxsize=4)
def _random_rotations(
    vector_count: int, rotation_rounding_step_rad_by_vector: tuple[float, ...] = ()
) -> NDArray[np.complex128]:
    """Draw uniformly distributed rotations, as unit complex numbers.

    The shape is (`RANDOM_ROTATION_SETS_PER_RAYLEIGH_TEST`, `vector_count`). Each angle of rotation is rounded to a
    multiple of its vector's step in `rotation_rounding_step_rad_by_vector`, unless the step is 0.
    """
    angles = np.random.Generator(np.random.PCG64(1)).uniform(
        0.0, 2 * math.pi, size=(RANDOM_ROTATION_SETS_PER_RAYLEIGH_TEST, vector_count)
    )
    step = np.array(rotation_rounding_step_rad_by_vector or (0.0,))
    rounded = np.round(angles / np.where(step > 0.0, step, 1.0)) * step
    return np.exp(1j * np.where(step > 0.0, rounded, angles))


def rayleigh_test_by_random_rotation(
    x_components_of_unnormalised_vectors: ArrayLike,
    y_components_of_unnormalised_vectors: ArrayLike,
    angle_recording_step_deg: ArrayLike = 0.0,
) -> StatisticalTestResult:
    """Test the null hypothesis that vectors have independent, uniformly distributed directions.

    The statistic is the length of the mean vector. Vectors may have different lengths. To test axes for a common axis,
    pass vectors with doubled angles.

    Under the null hypothesis each vector has a uniform direction, independent of its length and of the others. The
    p-value is simulated: each vector is rotated at random and keeps its length (a randomisation test, exact for any n;
    for unit vectors it is Rayleigh's test, Mardia & Jupp 2000, section 6.3.1). An angle that is recorded in steps, such
    as one of eight compass points, is rounded to its step after the rotation: two vectors at the same of eight points
    have p = 1/8, not 0.

    Parameters
    ----------
    x_components_of_unnormalised_vectors, y_components_of_unnormalised_vectors : array_like, shape (n,)
        Components of the vectors; for axes those of the doubled angles. Vectors of length 0 count as observations.
    angle_recording_step_deg : array_like, shape (n,) or ()
        Step of the angle of each vector, degrees, a divisor of 360; for axes that of the doubled angles. 0: no step.
    """
    x, y = (
        np.asarray(x_components_of_unnormalised_vectors, dtype=np.float64),
        np.asarray(y_components_of_unnormalised_vectors, dtype=np.float64),
    )
    n = int(x.size)
    if n == 0:
        return StatisticalTestResult("randomised Rayleigh", 0)
    statistic = math.hypot(x.mean(), y.mean())
    steps = np.broadcast_to(np.radians(angle_recording_step_deg), n)
    # Without steps only the lengths matter, as a uniform rotation makes the direction uniform.
    if np.any(steps > 0):
        rotated_sums = _random_rotations(n, tuple(steps.tolist())) @ (x + 1j * y)
    else:
        rotated_sums = _random_rotations(n) @ np.hypot(x, y)
    drawn = np.abs(rotated_sums) / n
    extreme = int((drawn >= statistic - 1e-12).sum())
    return StatisticalTestResult(
        "randomised Rayleigh", n, statistic, (1 + extreme) / (1 + RANDOM_ROTATION_SETS_PER_RAYLEIGH_TEST)
    )


def _watson_u2_statistic(cumulative_probabilities: FloatArray) -> FloatArray:
    """Compute Watson's U² statistic of samples, each of n cumulative probabilities (0 to 1) along the last axis."""
    ordered = np.sort(cumulative_probabilities, axis=-1)
    n = ordered.shape[-1]
    rank = (2 * np.arange(1, n + 1) - 1) / (2 * n)
    return np.asarray(((ordered - ordered.mean(axis=-1, keepdims=True) - rank + 0.5) ** 2).sum(axis=-1) + 1 / (12 * n))


def watson_u2_test(
    cumulative_probabilities: ArrayLike, simulated_cumulative_probabilities: FloatArray | None = None
) -> StatisticalTestResult:
    """Test with Watson's U² whether angles follow a given distribution on the circle.

    U² = Σ (u_i − ū − (2i − 1)/2n + 1/2)² + 1/12n, where u_i are the `cumulative_probabilities` in ascending
    order and ū is their mean (Watson 1961, Biometrika 48). The p-value is 2 Σ (−1)^(m−1) exp(−2 m² π² U²*)
    for all n > 1, with U²* = (U² − 0.1/n + 0.1/n²)(1 + 0.8/n) (Stephens 1970, JRSS B 32). For n = 1, U² is 1/12
    for every angle, and p = 1.

    Parameters
    ----------
    cumulative_probabilities : array_like, shape (n,)
        Distribution function of the model at each observed angle; for uniformity the angle divided by 360°. An
        `ArgumentError` is raised if a value lies outside 0 to 1.
    simulated_cumulative_probabilities : array, shape (draws, n), optional
        Cumulative probabilities of samples that are drawn from the model, for angles that are recorded in steps and so
        not continuous. The p-value is then (1 + number of draws with at least the observed U²)/(1 + draws).
    """
    values = np.asarray(cumulative_probabilities, dtype=np.float64)
    n = int(values.size)
    if n == 0:
        return StatisticalTestResult("Watson U²", 0)
    if not (np.isfinite(values).all() and values.min() >= 0 and values.max() <= 1):
        raise ArgumentError(
            "cumulative_probabilities: values must lie in 0 to 1; pass the model's distribution function at the angles"
        )
    statistic = float(_watson_u2_statistic(values))
    if simulated_cumulative_probabilities is not None:
        extreme = int((_watson_u2_statistic(simulated_cumulative_probabilities) >= statistic - 1e-12).sum())
        return StatisticalTestResult(
            "Watson U²", n, statistic, (1 + extreme) / (1 + len(simulated_cumulative_probabilities))
        )
    modified = (statistic - 0.1 / n + 0.1 / n**2) * (1 + 0.8 / n)
    order = np.arange(1, 51)
    p_value = 2 * float(((-1.0) ** (order - 1) * np.exp(-2 * order**2 * math.pi**2 * max(modified, 0.0))).sum())
    return StatisticalTestResult("Watson U²", n, statistic, min(max(p_value, 0.0), 1.0) if n > 1 else 1.0)


def _watson_u2_of_sector_counts(sector_counts: FloatArray, sector_probabilities: FloatArray) -> FloatArray:
    """Compute Watson's U² of the counts in sectors of a circle (last axis) against the sectors' probabilities."""
    total = sector_counts.sum(axis=-1, keepdims=True)
    difference = np.cumsum(sector_counts - total * sector_probabilities, axis=-1)
    centre = (difference * sector_probabilities).sum(axis=-1, keepdims=True)
    return np.asarray((((difference - centre) ** 2) * sector_probabilities).sum(axis=-1) / total[..., 0])


def watson_u2_test_of_sectors(sector_counts: ArrayLike, sector_probabilities: ArrayLike) -> StatisticalTestResult:
    """Test with Watson's U² whether counts in successive sectors of a circle follow given probabilities.

    U²_G = (1/n) Σ_j (S_j − S̄)² p_j for n observations, with the probability p_j of sector j, the sum S_j of
    observed minus expected counts up to sector j, and S̄ = Σ S_j p_j (Choulakian, Lockhart & Stephens 1994, Canadian
    Journal of Statistics 22). The p-value is simulated, so it holds for small counts and unequal sectors.

    Parameters
    ----------
    sector_counts, sector_probabilities : array_like, shape (k,)
        Observed count of each sector, and its probability under the null hypothesis. An `ArgumentError` is raised if
        shapes differ, or the probabilities are negative or do not sum to 1.
    """
    observed, expected = np.asarray(sector_counts, dtype=np.float64), np.asarray(sector_probabilities, dtype=np.float64)
    if observed.shape != expected.shape or observed.ndim != 1:
        raise ArgumentError(
            f"sector_probabilities: shape {expected.shape}, sector_counts {observed.shape}; one probability per sector"
        )
    if (expected < 0).any() or abs(expected.sum() - 1) > 1e-9:
        raise ArgumentError(
            f"sector_probabilities: sums to {expected.sum():.6g}; it must sum to 1 without negative values"
        )
    return _test_with_simulated_p_value("grouped Watson U²", _watson_u2_of_sector_counts, observed, expected)


def _chi_square_statistic(sector_counts: FloatArray, sector_probabilities: FloatArray) -> FloatArray:
    """Compute Pearson's X² of the counts in sectors of a circle (last axis) against the sectors' probabilities."""
    expected = sector_counts.sum(axis=-1, keepdims=True) * sector_probabilities
    with np.errstate(divide="ignore", invalid="ignore"):  # expected 0: 0/0 or ∞
        parts = (sector_counts - expected) ** 2 / expected
    return np.asarray(np.where(np.isnan(parts), 0.0, parts).sum(axis=-1))


def chi_square_test_of_sectors(sector_counts: FloatArray, sector_probabilities: FloatArray) -> StatisticalTestResult:
    """Test with Pearson's X² whether counts in sectors of a circle follow given probabilities.

    The parameters are those of `watson_u2_test_of_sectors`.

    The p-value is simulated because octants of a survey often have fewer than the five expected stones that the
    chi-square distribution needs (Mardia & Jupp 2000, section 6.3.3).
    """
    return _test_with_simulated_p_value("chi-square", _chi_square_statistic, sector_counts, sector_probabilities)


@lru_cache(maxsize=2)
def _random_sector_counts(total_count_over_sectors: int, sector_probabilities: tuple[float, ...]) -> FloatArray:
    """Draw multinomial counts in sectors of a circle, with the sum `total_count_over_sectors` in each draw.

    The shape is (`SIMULATED_SECTOR_COUNTS_PER_P_VALUE`, sectors). The last results are cached, since a survey is tested
    twice against the same probabilities.
    """
    probabilities = np.array(sector_probabilities)
    draws = np.random.Generator(np.random.PCG64(1)).multinomial(
        total_count_over_sectors, probabilities / probabilities.sum(), size=SIMULATED_SECTOR_COUNTS_PER_P_VALUE
    )
    return draws.astype(np.float64)


def _test_with_simulated_p_value(
    test_name: str,
    statistic_function: Callable[[FloatArray, FloatArray], FloatArray],
    sector_counts: FloatArray,
    sector_probabilities: FloatArray,
) -> StatisticalTestResult:
    """Test sector counts against given probabilities; the p-value comes from simulated multinomial counts.

    p = (1 + number of draws with at least the observed statistic)/(1 + `SIMULATED_SECTOR_COUNTS_PER_P_VALUE`).
    """
    # A stone of two sectors counts in parts, whose sum may be a rounding error away from a whole number.
    n = round(float(sector_counts.sum()))
    if n == 0:
        return StatisticalTestResult(test_name, 0)
    statistic = float(statistic_function(sector_counts, sector_probabilities))
    draws = _random_sector_counts(n, tuple(sector_probabilities.tolist()))
    extreme = int((statistic_function(draws, sector_probabilities) >= statistic * (1 - 1e-12)).sum())
    return StatisticalTestResult(test_name, n, statistic, (1 + extreme) / (1 + SIMULATED_SECTOR_COUNTS_PER_P_VALUE))
