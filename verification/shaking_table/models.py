"""Models that are fitted to some tests and predict the probability of a fall in others."""

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.statistics.logistic import fit_logistic_model
from verification.shaking_table.clouds import B_OVER_H, HEIGHT, WIDTH_B_OVER_H, WIDTH_HEIGHT, SimulatedStones
from verification.shaking_table.data import ShakingTableTests

Rows = NDArray[np.intp]
Model = Callable[[int, Rows, Rows], FloatArray]
"""Function of specimen, tests to learn from and tests to predict; returns the probabilities of the latter."""


def ensemble_fractions(stones: SimulatedStones) -> FloatArray:
    """Return the share of the stones of each neighbourhood that fall in each test, shape (centres, tests).

    Half a fall and half a stand are added to each count, so that no share is 0 or 1 and all likelihoods are finite.
    """
    log_b, log_h = np.log(stones.b_over_h), np.log(stones.height)
    fell = stones.fell.astype(np.float32)  # exact: no count comes near 2**24
    made = []
    for shape in np.log(B_OVER_H):
        near = np.abs(log_b - shape) < WIDTH_B_OVER_H
        members = np.abs(log_h[near] - np.log(HEIGHT)[:, None]) < WIDTH_HEIGHT
        counts = members.astype(np.float32) @ fell[:, near].T
        made.append((counts + 0.5) / (members.sum(axis=1) + 1)[:, None])
    return np.concatenate(made)


def most_likely_centre(fractions: FloatArray, fell: NDArray[np.bool_], learning_tests: Rows) -> int:
    """Return the index of the neighbourhood that best predicts the outcomes of the tests to learn from."""
    p, y = fractions[:, learning_tests], fell[learning_tests]
    likelihood = np.where(y, np.log(p), np.log1p(-p)).sum(axis=1)
    return int(np.argmax(likelihood))


def prediction_models(
    tests: ShakingTableTests, rectangle_fractions: FloatArray, prism_fractions: FloatArray
) -> dict[str, Model]:
    """Return the prediction models by name; the fractions are shares of each neighbourhood that fall."""
    peaks = np.log(np.column_stack([tests.pga, tests.pgv]))

    def shares(fractions: FloatArray) -> Model:
        def ensemble(specimen: int, learn: Rows, predict: Rows) -> FloatArray:
            return np.asarray(fractions[most_likely_centre(fractions, tests.fell[specimen], learn)][predict])

        return ensemble

    def peaks_alone(specimen: int, learn: Rows, predict: Rows) -> FloatArray:
        return _logistic_probabilities(peaks, tests, specimen, learn, predict)

    def both(specimen: int, learn: Rows, predict: Rows) -> FloatArray:
        share = rectangle_fractions[most_likely_centre(rectangle_fractions, tests.fell[specimen], learn)]
        predictors = np.column_stack([np.log(share / (1 - share)), peaks])
        return _logistic_probabilities(predictors, tests, specimen, learn, predict)

    return {PEAKS: peaks_alone, ENSEMBLE: shares(rectangle_fractions), BOTH: both, SPACE: shares(prism_fractions)}


PEAKS: Final = "logistic of PGA and PGV"
ENSEMBLE: Final = "ensemble of rectangles"
BOTH: Final = "ensemble, PGA and PGV in a logistic"
SPACE: Final = "ensemble of 3-D prisms"


def _logistic_probabilities(
    predictors: FloatArray, tests: ShakingTableTests, specimen: int, learning_tests: Rows, predicted_tests: Rows
) -> FloatArray:
    fell = tests.fell[specimen][learning_tests].astype(np.float64)
    fit = fit_logistic_model(predictors[learning_tests], fell, tests.motion[learning_tests], intervals=False)
    return fit.fall_probability(predictors[predicted_tests])


def split_odd_even(tests: ShakingTableTests) -> Iterator[tuple[Rows, Rows]]:
    """Yield one split: learn from the odd-numbered tests and predict the even ones, as in the published results."""
    odd = tests.number % 2 == 1
    yield np.flatnonzero(odd), np.flatnonzero(~odd)


def leave_motion_out(tests: ShakingTableTests) -> Iterator[tuple[Rows, Rows]]:
    """Yield a split for each motion: predict its tests and learn from the tests of all other motions."""
    for name in np.unique(tests.motion):
        own = tests.motion == name
        yield np.flatnonzero(~own), np.flatnonzero(own)


def predict_held_out(model: Model, specimen: int, splits: Iterator[tuple[Rows, Rows]], test_count: int) -> FloatArray:
    """Return the predicted probability of each test; NaN if no split predicts it."""
    p = np.full(test_count, np.nan)
    for learn, predict in splits:
        p[predict] = model(specimen, learn, predict)
    return p
