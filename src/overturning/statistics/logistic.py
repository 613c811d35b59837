"""Logistic regression of overturning on intensity and shape, with intervals clustered by earthquake."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.statistics.bootstrap import MIN_EARTHQUAKES_FOR_INTERVAL
from overturning.statistics.by_record import iterate_record_result_batches
from overturning.units import STANDARD_GRAVITY

PREDICTOR_NAMES = ("ln PGA/(g B/H)", "ln PGV/PGA", "ln B/H", "ln H")
"""Predictors of `fit_logistic_overturning_model`: PGA over West's limit, PGV/PGA in s, slenderness, height in m."""

CONFIDENCE_LEVEL = 0.95
"""Probability of the intervals."""

MAX_PGA_FROM_ROUNDING_M_S2 = 1e-6
"""PGA, m/s², below which a motion is only rounding error (motions are rounded to 1e-9 m/s²)."""

MAX_RELATIVE_STD_OF_CONSTANT_PREDICTOR = 1e-6
"""Largest standard deviation of a predictor that is constant but for rounding, relative to its size if that exceeds 1.

Peaks of a motion in one direction have the same PGV/PGA along all azimuths but for the rounding of the samples.
"""

MAX_NEWTON_ITERATIONS = 200
MIN_LINEAR_PREDICTOR_FOR_SEPARATION_CHECK = 30.0
"""Linear predictor above which a fit is checked for separated data; the probability is 0 or 1 to 13 digits there."""

MAX_COEFFICIENT_STEP_OF_CONVERGED_FIT = 1e-10
"""Largest step of a converged fit, in standard deviations of the predictors, or relative to larger coefficients."""

RELATIVE_LOG_LIKELIHOOD_ROUNDING_ERROR = 1e-13
"""Relative rounding error of the log likelihood of many rows."""


@dataclass(frozen=True)
class LogisticFit:
    """Fitted logistic model of the fall probability: a coefficient with its interval for each predictor.

    Attributes
    ----------
    coefficient_names : tuple of str
        ``intercept`` and names of the predictors.
    coefficient_estimates, standard_errors, coefficient_interval_lows, coefficient_interval_highs : ndarray, shape (k,)
        Estimates, standard errors and intervals from the jackknife over clusters, see `fit_logistic_model`. Without
        intervals, the maximum-likelihood estimates, and NaN for the others.
    row_count, earthquake_cluster_count : int
        Number of rows of data and of independent clusters (earthquakes).
    predictor_minima, predictor_maxima : ndarray, shape (k − 1,)
        Range of each predictor; the fit is not valid outside.
    reason_without_estimate_or_interval : str
        Reason why there is no estimate or no interval; otherwise "".
    """

    coefficient_names: tuple[str, ...]
    coefficient_estimates: FloatArray
    standard_errors: FloatArray
    coefficient_interval_lows: FloatArray
    coefficient_interval_highs: FloatArray
    row_count: int
    earthquake_cluster_count: int
    predictor_minima: FloatArray
    predictor_maxima: FloatArray
    reason_without_estimate_or_interval: str = ""

    def fall_probability(self, predictors: ArrayLike) -> FloatArray:
        """Return the fitted fall probability, shape (…), for predictors of shape (…, k − 1).

        Predictors are in the order of `coefficient_names`, without the intercept.
        """
        x = np.asarray(predictors, dtype=np.float64)
        return np.asarray(1 / (1 + np.exp(-(self.coefficient_estimates[0] + x @ self.coefficient_estimates[1:]))))


def fit_logistic_model(
    predictors: ArrayLike,
    fall_shares: ArrayLike,
    cluster_label_by_row: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    predictor_names: Sequence[str] = (),
    compute_jackknife_intervals: bool = True,
) -> LogisticFit:
    """Fit a logistic model to outcomes in clusters (earthquakes), with jackknife intervals over the clusters.

    Maximum likelihood by Newton's method (McCullagh & Nelder 1989, Generalized Linear Models, section 4.4) gives b
    from all G clusters and b_g without cluster g. The estimate is G b − (G − 1) b̄, with the bias of order 1/G
    removed (Quenouille 1956, Biometrika 43), its covariance (G − 1)/G Σ_g (b_g − b̄)(b_g − b̄)ᵀ, which is
    CR3 (MacKinnon, Nielsen & Webb 2023, Journal of Applied Econometrics 38), and intervals are those of Student's t
    with G − 1 degrees of freedom. The sandwich estimate of the covariance is too small for few clusters: its 95 %
    intervals contain the true value in only 86 to 92 % of cases for 14 earthquakes.

    Parameters
    ----------
    predictors, predictor_names : array_like, shape (n, k), sequence of str
        Predictors without intercept, and their names.
    fall_shares, weights, cluster_label_by_row : array_like, shape (n,)
        Outcome 0 or 1, or share of falls; weight (default 1; rows of weight 0 do not count); earthquake. An
        `ArgumentError` is raised if shapes do not match, a predictor is not finite, or a share lies outside 0 to 1.
    compute_jackknife_intervals : bool
        False: compute the maximum-likelihood estimates only, which are enough for a prediction.

    Returns
    -------
    LogisticFit
        The fit, with a ``reason_without_estimate_or_interval`` and without estimates if all outcomes are equal, or if a
        combination of predictors separates them, so that no finite estimate exists (Albert & Anderson 1984, Biometrika
        71). There are no intervals with fewer than `MIN_EARTHQUAKES_FOR_INTERVAL` clusters, or if the fit without one
        of them fails.
    """
    x, y = _checked_predictors_and_outcomes(predictors, fall_shares)
    w = np.ones_like(y) if weights is None else np.asarray(weights, dtype=np.float64)
    counts = w > 0  # a cluster without weight is none
    x, y, w = x[counts], y[counts], w[counts]
    _, member = np.unique(np.asarray(cluster_label_by_row)[counts], return_inverse=True)
    groups = int(member.max()) + 1 if y.size else 0
    label = ("intercept", *(predictor_names or [f"x{i + 1}" for i in range(x.shape[1])]))
    coefficient = error = np.full(len(label), np.nan)
    note = _reason_why_fit_is_impossible(y)
    if not note:
        # Centre and scale the predictors, so that the information matrix is well conditioned.
        centre, scale = x.mean(axis=0), x.std(axis=0)
        varies = scale > MAX_RELATIVE_STD_OF_CONSTANT_PREDICTOR * np.maximum(1.0, np.abs(centre))
        design = np.column_stack([np.ones_like(y), (x[:, varies] - centre[varies]) / scale[varies]])
        if np.linalg.matrix_rank(design) < design.shape[1]:
            note = "no fit: predictors are linearly dependent"
        else:
            beta, note = _fit_coefficients_by_newton_method(design, y, w, np.zeros(design.shape[1]))
    if not note:
        # Return to the units of the predictors; a constant predictor gets no coefficient.
        back = _coefficient_unscaling_matrix(centre, scale, varies)
        given = np.where(np.concatenate(([True], varies)), 0.0, np.nan)
        coefficient = back @ beta + given
        if compute_jackknife_intervals and groups >= MIN_EARTHQUAKES_FOR_INTERVAL:
            without, note = _jackknife_coefficients_and_failure_reason(design, y, w, beta, member)
            if not note:
                estimates = _jackknife_estimate_and_standard_error(coefficient, without @ back.T)
                coefficient, error = (one + given for one in estimates)
        elif compute_jackknife_intervals:
            note = f"no interval: fewer than {MIN_EARTHQUAKES_FOR_INTERVAL} earthquakes"
    half = float(scipy.special.stdtrit(groups - 1, (1 + CONFIDENCE_LEVEL) / 2)) * error
    nowhere = np.full(len(label) - 1, np.nan)
    return LogisticFit(
        coefficient_names=label,
        coefficient_estimates=coefficient,
        standard_errors=error,
        coefficient_interval_lows=coefficient - half,
        coefficient_interval_highs=coefficient + half,
        row_count=int(y.size),
        earthquake_cluster_count=groups,
        predictor_minima=x.min(axis=0) if y.size else nowhere,
        predictor_maxima=x.max(axis=0) if y.size else nowhere,
        reason_without_estimate_or_interval=note,
    )


def _checked_predictors_and_outcomes(predictors: ArrayLike, fall_shares: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return predictors, shape (n, k), and outcomes, shape (n,), as float arrays; raise an error if invalid.

    An ArgumentError is raised if shapes do not match, a predictor is not finite, or an outcome lies outside 0 to 1.
    """
    x, y = np.asarray(predictors, dtype=np.float64), np.asarray(fall_shares, dtype=np.float64)
    if x.ndim != 2 or y.shape != x.shape[:1]:
        raise ArgumentError(f"outcome: shape {y.shape}, predictors {x.shape}; one outcome per row of predictors")
    if not np.isfinite(x).all():
        count = int((~np.isfinite(x).all(axis=1)).sum())
        raise ArgumentError(f"predictors: {count} of {len(x)} rows are not finite; leave them out")
    if y.size and not (y.min() >= 0 and y.max() <= 1):
        raise ArgumentError(f"outcome: {y.min()} to {y.max()}; outcomes are shares between 0 and 1")
    return x, y


def _reason_why_fit_is_impossible(fall_shares: FloatArray) -> str:
    """Return why no logistic model can be fitted (no outcome known, all fall or none); "" if one can be fitted."""
    if fall_shares.size == 0:
        return "no fit: no outcome is known"
    if fall_shares.max() == 0.0:
        return "no fit: nothing falls"
    return "no fit: everything falls" if fall_shares.min() == 1.0 else ""


def _coefficient_unscaling_matrix(
    predictor_means: FloatArray, predictor_stds: FloatArray, is_varying: NDArray[np.bool_]
) -> FloatArray:
    """Return the matrix that converts coefficients of scaled predictors to those of the original predictors.

    The shape is (predictors + 1, varying predictors + 1); the first coefficient is the intercept.
    """
    back = np.zeros((predictor_means.size + 1, int(is_varying.sum()) + 1))
    back[0, 0] = 1.0
    back[0, 1:] = -predictor_means[is_varying] / predictor_stds[is_varying]
    back[1 + np.flatnonzero(is_varying), 1 + np.arange(int(is_varying.sum()))] = 1 / predictor_stds[is_varying]
    return back


def _fit_coefficients_by_newton_method(
    design_matrix: FloatArray, fall_shares: FloatArray, weights: FloatArray, start_coefficients: FloatArray
) -> tuple[FloatArray, str]:
    """Fit logistic coefficients by Newton's method; return them, and "" or the reason why there is no fit.

    The log likelihood is concave, so a step that is halved until it raises the likelihood leads to the maximum. The
    first time that a linear predictor exceeds `MIN_LINEAR_PREDICTOR_FOR_SEPARATION_CHECK`, a linear programme decides
    whether a finite maximum exists.
    """
    negative_log_likelihood = _create_neg_log_likelihood_of_linear_predictors(fall_shares, weights)
    beta, linear, may_be_separated = start_coefficients, design_matrix @ start_coefficients, True
    reached = negative_log_likelihood(linear)
    for _ in range(MAX_NEWTON_ITERATIONS):
        falls, stands = scipy.special.expit(linear), scipy.special.expit(-linear)  # 1 - falls would be rounded to 0
        information = (design_matrix * (weights * falls * stands)[:, None]).T @ design_matrix
        gradient = design_matrix.T @ (weights * (fall_shares * stands - (1 - fall_shares) * falls))
        try:
            step = np.linalg.solve(information, gradient)
        except np.linalg.LinAlgError:
            break
        largest = reached * (1 + RELATIVE_LOG_LIKELIHOOD_ROUNDING_ERROR)
        reached = negative_log_likelihood(linear := design_matrix @ (beta + step))
        while np.abs(step).max() > MAX_COEFFICIENT_STEP_OF_CONVERGED_FIT and reached > largest:
            step = step / 2
            reached = negative_log_likelihood(linear := design_matrix @ (beta + step))
        beta = beta + step
        if may_be_separated and np.abs(linear).max() > MIN_LINEAR_PREDICTOR_FOR_SEPARATION_CHECK:
            if _plane_separates_falls_from_standing_cases(design_matrix, fall_shares):
                return beta, "no fit: predictors separate falls from stands"
            may_be_separated = False
        if np.abs(step).max() < MAX_COEFFICIENT_STEP_OF_CONVERGED_FIT * max(1.0, np.abs(beta).max()):
            return beta, ""
    return beta, "no fit: the iteration does not converge"


def _create_neg_log_likelihood_of_linear_predictors(
    fall_shares: FloatArray, weights: FloatArray
) -> Callable[[FloatArray], float]:
    """Return a function that computes minus the logarithm of the weighted likelihood from linear predictors.

    A row with a share s of falls has the term s ln P + (1 − s) ln(1 − P), P the fall probability; only one part
    remains if s is 0 or 1.
    """
    sign = np.where(fall_shares == 1, -1.0, 1.0)
    shared = np.flatnonzero((fall_shares > 0) & (fall_shares < 1))
    share = fall_shares[shared]

    def negative_log_likelihood(linear_predictor_by_row: FloatArray) -> float:
        losses = np.logaddexp(0, sign * linear_predictor_by_row)
        between = linear_predictor_by_row[shared]
        losses[shared] = share * np.logaddexp(0, -between) + (1 - share) * np.logaddexp(0, between)
        return float(weights @ losses)

    return negative_log_likelihood


def _plane_separates_falls_from_standing_cases(design_matrix: FloatArray, fall_shares: FloatArray) -> bool:
    """Return whether a plane in predictor space separates falls from standing cases; both may lie in the plane.

    Then, and only then, no finite estimate exists (Albert & Anderson 1984, Biometrika 71). A row whose outcome is a
    share between 0 and 1 means falls and standing cases at one point, and must lie in the plane. The columns of the
    design matrix must be linearly independent.
    """
    from scipy.optimize import linprog  # imported only where a fit fails: importing it takes long

    shared, columns = ((fall_shares > 0) & (fall_shares < 1), design_matrix.shape[1])
    # The number of rows first: before NumPy 2.4, a matrix without rows has no rank.
    if shared.sum() >= columns and np.linalg.matrix_rank(design_matrix[shared]) == columns:
        return False
    beyond = np.where(fall_shares == 1, 1.0, -1.0)[~shared, None] * design_matrix[~shared]
    found = linprog(
        -beyond.sum(axis=0),
        A_ub=-beyond,
        b_ub=np.zeros(len(beyond)),
        A_eq=design_matrix[shared],
        b_eq=np.zeros(int(shared.sum())),
        bounds=(-1.0, 1.0),
    )
    # The planes that separate form a cone: the best one has a coefficient at a bound, or none but zero separates.
    return bool(found.success) and float(np.abs(np.asarray(found.x)).max()) > 0.5


def _jackknife_coefficients_and_failure_reason(
    design_matrix: FloatArray,
    fall_shares: FloatArray,
    weights: FloatArray,
    start_coefficients: FloatArray,
    cluster_index_by_row: NDArray[np.intp],
) -> tuple[FloatArray, str]:
    """Return the coefficients fitted without each cluster in turn (jackknife), and "" or the reason why a fit failed.

    If one fit fails, the array of coefficients is empty.
    """
    estimates, none = [], np.empty((0, start_coefficients.size))
    for one in range(int(cluster_index_by_row.max()) + 1):
        kept = cluster_index_by_row != one
        if _reason_why_fit_is_impossible(fall_shares[kept]):
            return none, "no interval: all falls, or all stands, are of one earthquake"
        if np.linalg.matrix_rank(design_matrix[kept]) < start_coefficients.size:
            return none, "no interval: without one earthquake predictors are linearly dependent"
        found, note = _fit_coefficients_by_newton_method(
            design_matrix[kept], fall_shares[kept], weights[kept], start_coefficients
        )
        if note:
            return none, f"no interval: without one earthquake {note.removeprefix('no fit: ')}"
        estimates.append(found)
    return np.array(estimates), ""


def _jackknife_estimate_and_standard_error(
    coefficients_from_all_clusters: FloatArray, coefficients_by_omitted_cluster: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the bias-corrected jackknife estimate and its standard error, from fits that each omit one cluster.

    `coefficients_by_omitted_cluster` has shape (clusters, coefficients).
    """
    groups, mean = len(coefficients_by_omitted_cluster), coefficients_by_omitted_cluster.mean(axis=0)
    error = np.sqrt((groups - 1) / groups * ((coefficients_by_omitted_cluster - mean) ** 2).sum(axis=0))
    return groups * coefficients_from_all_clusters - (groups - 1) * mean, error


def overturning_regression_data(
    cube: xr.Dataset, pga_and_pgv: xr.Dataset, *, use_ensemble: bool = True
) -> tuple[FloatArray, FloatArray, NDArray[np.intp], FloatArray]:
    """Return the data of a logistic fit: predictors, share of falls, earthquake index and weight of each row.

    There is one row for each record, plane, height and B/H. The outcome is the share of friction coefficients for which
    the block falls. Planes without motion, such as perpendicular to a pulse, are left out, since PGV/PGA is 0/0 there.

    Parameters
    ----------
    cube : Dataset
        The cube, which is read in batches of records.
    pga_and_pgv : Dataset
        ``pga`` (m/s²) and ``pgv`` (m/s) over ``record`` and ``azimuth``; an `ArgumentError` is raised if an azimuth of
        the cube is missing.
    use_ensemble : bool
        Use probabilities instead of flags (see `Model.fall_probability_and_direction_by_case`).

    Returns
    -------
    predictors : ndarray, shape (n, 4)
        Values of `PREDICTOR_NAMES`.
    outcome, event, weight : ndarray, shape (n,)
        The outcome is averaged over friction and weighted by the share of known values; no predictor depends on
        friction, so this does not change the fit. Events are numbers in the order of their names; the mean weight is 1.
    """
    model, parts = default_model_of_same_kind_as_results_cube(cube), []
    number = np.unique(np.atleast_1d(cube["event"].values), return_inverse=True)[1]
    for places, some in iterate_record_result_batches(cube, model.variable_names_read_for_fall_probability):
        planes = model.fall_probability_and_direction_by_case(some, use_ensemble=use_ensemble)
        where, falls = planes["azimuth"], planes["falls"].transpose("record", *model.dimension_names)
        try:
            along = pga_and_pgv[["pga", "pgv"]].isel(record=places).sel(azimuth=where, method="nearest", tolerance=1e-6)
        except KeyError as error:
            raise ArgumentError(
                "intensity: azimuths of the cube are missing; compute it on the cube's azimuths"
            ) from error
        pga, pgv = (along[name].transpose("record", ...).to_numpy()[..., None, None] for name in ("pga", "pgv"))
        moves = pga > MAX_PGA_FROM_ROUNDING_M_S2
        pga = np.where(moves, pga, np.nan)
        height, slender = (falls[name].to_numpy().astype(float) for name in ("height", "b_over_h"))
        height = height[:, None]
        answered = np.isfinite(falls.to_numpy()).sum(axis=-1)
        share = np.nansum(falls.to_numpy(), axis=-1, dtype=np.float64) / np.maximum(answered, 1)
        values = (pga / (STANDARD_GRAVITY * slender), pgv / pga, slender, height)
        weight = (planes["weight"].to_numpy() * where.size)[:, None, None] * answered / falls.sizes["friction"]
        known = (answered > 0) & moves
        *table, weights = (np.broadcast_to(one, share.shape)[known] for one in (*map(np.log, values), weight))
        events = np.broadcast_to(number[places][:, None, None, None], share.shape)[known]
        parts.append((np.stack(table, axis=1), share[known], events, weights))
    if not parts:
        return np.empty((0, 4)), np.empty(0), np.empty(0, np.intp), np.empty(0)
    predictors, outcome, events, shares = (np.concatenate(column) for column in zip(*parts, strict=True))
    return predictors, outcome, events, shares


def fit_logistic_overturning_model(cube: xr.Dataset, pga_and_pgv: xr.Dataset) -> LogisticFit:
    """Fit a logistic model of the fall probability, with the predictors `PREDICTOR_NAMES`, to a study's results.

    `pga_and_pgv` has ``pga`` and ``pgv`` of each record and azimuth.
    """
    predictors, outcome, event, weight = overturning_regression_data(cube, pga_and_pgv)
    return fit_logistic_model(predictors, outcome, event, weights=weight, predictor_names=PREDICTOR_NAMES)


def coefficient_interval_and_predictor_range_rows(
    logistic_fit: LogisticFit,
) -> list[tuple[str, float, float, float, float, float]]:
    """Return, for each coefficient of a logistic model: name, estimate, interval limits, and range of its predictor.

    The range of the intercept is NaN.
    """
    fit = logistic_fit
    least, most = ((math.nan, *values.tolist()) for values in (fit.predictor_minima, fit.predictor_maxima))
    columns = (fit.coefficient_estimates, fit.coefficient_interval_lows, fit.coefficient_interval_highs)
    return list(zip(fit.coefficient_names, *(values.tolist() for values in columns), least, most, strict=True))
