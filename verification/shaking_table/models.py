"""Models that are fitted to some tests and predict the probability of a fall in others."""

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.statistics.logistic import fit_logistic_model
from verification.shaking_table.clouds import (
    NEIGHBOURHOOD_CENTRE_B_OVER_H,
    NEIGHBOURHOOD_CENTRE_HEIGHTS_M,
    NEIGHBOURHOOD_HALF_WIDTH_LN_B_OVER_H,
    NEIGHBOURHOOD_HALF_WIDTH_LN_HEIGHT,
    StonesWithSimulatedOutcomes,
)
from verification.shaking_table.data import ShakingTableTests

TestIndices = NDArray[np.intp]
FallPredictionModel = Callable[[int, TestIndices, TestIndices], FloatArray]
"""Function of specimen, tests to learn from and tests to predict; returns the probabilities of the latter."""


def smoothed_fall_shares_by_size_and_test(stones: StonesWithSimulatedOutcomes) -> FloatArray:
    """Return the share of the stones of similar size that fall in each test, shape (sizes, tests).

    A size is a neighbourhood of stones: B/H and height are within a fixed logarithmic distance of a centre. The centres
    are all pairs of a central B/H and a central height; the height varies fastest.

    Half a fall and half a stand are added to each count, so that no share is 0 or 1 and all likelihoods are finite.
    """
    log_b, log_h = np.log(stones.b_over_h), np.log(stones.height)
    fell = stones.fell_by_test_and_stone.astype(np.float32)  # exact: no count comes near 2**24
    made = []
    for shape in np.log(NEIGHBOURHOOD_CENTRE_B_OVER_H):
        near = np.abs(log_b - shape) < NEIGHBOURHOOD_HALF_WIDTH_LN_B_OVER_H
        members = (
            np.abs(log_h[near] - np.log(NEIGHBOURHOOD_CENTRE_HEIGHTS_M)[:, None]) < NEIGHBOURHOOD_HALF_WIDTH_LN_HEIGHT
        )
        counts = members.astype(np.float32) @ fell[:, near].T
        made.append((counts + 0.5) / (members.sum(axis=1) + 1)[:, None])
    return np.concatenate(made)


def index_of_most_likely_size_neighbourhood(
    fall_share_by_size_neighbourhood_and_test: FloatArray, fell_by_test: NDArray[np.bool_], learning_tests: TestIndices
) -> int:
    """Return the index of the range of B/H and height that makes the outcomes of `learning_tests` most likely."""
    p, y = fall_share_by_size_neighbourhood_and_test[:, learning_tests], fell_by_test[learning_tests]
    likelihood = np.where(y, np.log(p), np.log1p(-p)).sum(axis=1)
    return int(np.argmax(likelihood))


def fall_prediction_models_by_name(
    tests: ShakingTableTests,
    rectangle_fall_share_by_neighbourhood_and_test: FloatArray,
    prism_fall_share_by_size_and_test: FloatArray,
) -> dict[str, FallPredictionModel]:
    """Return, by model name, functions that predict fall probabilities of tests from the outcomes of other tests.

    The fall shares of random rectangles and random prisms are those of `smoothed_fall_shares_by_size_and_test`.
    """
    peaks = np.log(np.column_stack([tests.measured_pga, tests.measured_pgv]))

    def create_best_fitting_size_model(
        fall_share_by_size_neighbourhood_and_test: FloatArray,
    ) -> FallPredictionModel:
        """Return a model that predicts the simulated fall share of the stones whose B/H and height fit best."""

        def predict_by_fall_share_of_best_fitting_size(
            specimen_number: int, learning_tests: TestIndices, predicted_tests: TestIndices
        ) -> FloatArray:
            """Predict the simulated fall share of stones whose B/H and height best fit `learning_tests`."""
            return np.asarray(
                fall_share_by_size_neighbourhood_and_test[
                    index_of_most_likely_size_neighbourhood(
                        fall_share_by_size_neighbourhood_and_test,
                        tests.fell_by_specimen[specimen_number],
                        learning_tests,
                    )
                ][predicted_tests]
            )

        return predict_by_fall_share_of_best_fitting_size

    def predict_fall_probabilities_by_pga_and_pgv(
        specimen_number: int, learning_tests: TestIndices, predicted_tests: TestIndices
    ) -> FloatArray:
        """Predict fall probabilities by logistic regression on the logarithms of measured PGA and PGV."""
        return _fall_probabilities_by_logistic_regression(
            peaks, tests, specimen_number, learning_tests, predicted_tests
        )

    def fall_probability_by_pga_pgv_and_simulated_share(
        specimen_number: int, learning_tests: TestIndices, predicted_tests: TestIndices
    ) -> FloatArray:
        """Predict fall probabilities by logistic regression on log PGA, log PGV and the log odds of a simulated share.

        The share is that of the random rectangles that fall in a test, among those whose B/H and height lie in the
        range that best fits the tests to learn from.
        """
        share = rectangle_fall_share_by_neighbourhood_and_test[
            index_of_most_likely_size_neighbourhood(
                rectangle_fall_share_by_neighbourhood_and_test, tests.fell_by_specimen[specimen_number], learning_tests
            )
        ]
        predictors = np.column_stack([np.log(share / (1 - share)), peaks])
        return _fall_probabilities_by_logistic_regression(
            predictors, tests, specimen_number, learning_tests, predicted_tests
        )

    return {
        PGA_PGV_LOGISTIC_MODEL_NAME: predict_fall_probabilities_by_pga_and_pgv,
        RECTANGLES_MODEL_NAME: create_best_fitting_size_model(rectangle_fall_share_by_neighbourhood_and_test),
        ENSEMBLE_AND_PEAKS_MODEL_NAME: fall_probability_by_pga_pgv_and_simulated_share,
        PRISMS_MODEL_NAME: create_best_fitting_size_model(prism_fall_share_by_size_and_test),
    }


PGA_PGV_LOGISTIC_MODEL_NAME: Final = "logistic of PGA and PGV"
RECTANGLES_MODEL_NAME: Final = "ensemble of rectangles"
ENSEMBLE_AND_PEAKS_MODEL_NAME: Final = "ensemble, PGA and PGV in a logistic"
PRISMS_MODEL_NAME: Final = "ensemble of 3-D prisms"


def _fall_probabilities_by_logistic_regression(
    predictors_by_test: FloatArray,
    tests: ShakingTableTests,
    specimen_number: int,
    learning_tests: TestIndices,
    predicted_tests: TestIndices,
) -> FloatArray:
    """Fit a logistic model to `learning_tests` and return the fall probabilities of `predicted_tests`."""
    fell = tests.fell_by_specimen[specimen_number][learning_tests].astype(np.float64)
    fit = fit_logistic_model(
        predictors_by_test[learning_tests],
        fell,
        tests.played_record_names[learning_tests],
        compute_jackknife_intervals=False,
    )
    return fit.fall_probability(predictors_by_test[predicted_tests])


def split_into_odd_learning_and_even_predicted_tests(
    tests: ShakingTableTests,
) -> Iterator[tuple[TestIndices, TestIndices]]:
    """Yield one split: learn from the odd-numbered tests and predict the even ones, as in the published results."""
    odd = tests.laboratory_test_numbers % 2 == 1
    yield np.flatnonzero(odd), np.flatnonzero(~odd)


def splits_leaving_out_one_motion(tests: ShakingTableTests) -> Iterator[tuple[TestIndices, TestIndices]]:
    """Yield a split for each motion: predict its tests and learn from the tests of all other motions."""
    for name in np.unique(tests.played_record_names):
        own = tests.played_record_names == name
        yield np.flatnonzero(~own), np.flatnonzero(own)


def predict_unseen_tests(
    model: FallPredictionModel,
    specimen_number: int,
    learning_and_predicted_test_splits: Iterator[tuple[TestIndices, TestIndices]],
    test_count: int,
) -> FloatArray:
    """Return the predicted fall probability of one specimen in each test; NaN if no split predicts the test."""
    p = np.full(test_count, np.nan)
    for learn, predict in learning_and_predicted_test_splits:
        p[predict] = model(specimen_number, learn, predict)
    return p
