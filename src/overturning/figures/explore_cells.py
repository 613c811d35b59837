"""Cells of a record for the explorer page: outcomes as base64-encoded integers, and a clear case to open with."""

import base64
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.planes import fall_probabilities_towards_and_away
from overturning.model.status import CaseStatus

if TYPE_CHECKING:
    import xarray as xr

ENCODED_PROBABILITY_STEP_COUNT: Final = 240
"""Number of steps of a probability from 0 to 1 in the page's data, in which the largest integer means missing.

Shares of 8, 16 and 24 runs are represented exactly. Other shares are rounded, but only 0 becomes 0 and only 1
becomes 1.
"""

_MIN_ENCODED_OVERTURNING_TIME_RESOLUTION_S: Final = 1e-2
"""Smallest step of times, s."""

ENCODED_AZIMUTH_STEP_DEG: Final = 1 / 101
"""Step of azimuths, degrees.

The page rounds to whole degrees, tenths of a degree and percent. Steps are an odd fraction of these units, so that no
multiple of a step is half-way between two shown numbers: rounded twice, 1.3496° would become 1.35° and then 1.4°.
"""

_ROTATION_VARIABLE_BY_DIRECTION_DIMENSION: Final = {"azimuth": "peak_rotation", "orientation": "peak_tilt"}
"""Name of the rotation variable, by the direction of the model."""

ENCODED_ROTATION_STEP_IN_CRITICAL_ANGLES: Final = 0.01 / 11
"""Step of rotations in units of the critical angle α; see `ENCODED_AZIMUTH_STEP_DEG`."""

ENCODED_ROTATION_STEP_DEG: Final = 0.1 / 11
"""Step of rotations in degrees; see `ENCODED_AZIMUTH_STEP_DEG`."""


def encode_outcomes_of_record(
    record_cube: "xr.Dataset",
    towards_and_away_probabilities: "xr.Dataset",
    rotation_encoding_step_by_element: Sequence[float],
) -> dict[str, Any]:
    """Encode the outcomes of all cases under one record as base64 text for the interactive results page.

    The rotations of a scene element are stored as multiples of its step in `rotation_encoding_step_by_element`.
    """
    model = default_model_of_same_kind_as_results_cube(record_cube)
    order = (model.direction_dimension_name, "height", "b_over_h", "aspect", "friction", "element")

    def transpose_to_explorer_page_dimension_order(one_record_cube_variable: "xr.DataArray") -> FloatArray:
        """Return the values of a variable in the order of dimensions that the page expects."""
        return np.asarray(
            one_record_cube_variable.variable.isel(record=0).transpose(*order).to_numpy(), dtype=np.float64
        )

    flag = transpose_to_explorer_page_dimension_order(record_cube["overturned"])
    ensemble = ensemble_fall_or_fall_towards_probability(record_cube)
    # The probability is missing where the ensemble was not run: the map then shows the flag of the cell itself.
    known = (
        towards_and_away_probabilities if ensemble is None else towards_and_away_probabilities.where(ensemble.notnull())
    )
    time = transpose_to_explorer_page_dimension_order(record_cube["overturning_time"])
    time_step = max(
        _MIN_ENCODED_OVERTURNING_TIME_RESOLUTION_S, float(np.nanmax(time, initial=0.0)) / (np.iinfo("<u2").max - 1)
    )  # 16 bits must hold it
    cells = {
        "flag": _encode_array_as_base64(
            np.where(
                np.isnan(flag),
                transpose_to_explorer_page_dimension_order(_display_codes_of_cases_without_outcome(record_cube)),
                flag,
            ).astype("i1")
        ),
        "rotation": _encode_multiples_of_step_as_base64(
            transpose_to_explorer_page_dimension_order(
                record_cube[_ROTATION_VARIABLE_BY_DIRECTION_DIMENSION[model.direction_dimension_name]]
            ),
            np.asarray(rotation_encoding_step_by_element),
            "<u2",
        ),
        "time": _encode_multiples_of_step_as_base64(time, time_step, "<u2"),
        "timeStep": time_step,
        **{
            name: _encode_multiples_of_step_as_base64(
                _keep_intermediate_probabilities_off_0_and_1(transpose_to_explorer_page_dimension_order(known[name])),
                1 / ENCODED_PROBABILITY_STEP_COUNT,
                "u1",
            )
            for name in ("towards", "away")
        },
    }
    if not model.is_planar:
        cells["azimuth"] = _encode_multiples_of_step_as_base64(
            transpose_to_explorer_page_dimension_order(record_cube["fall_azimuth"]), ENCODED_AZIMUTH_STEP_DEG, "<u2"
        )
    return cells


def _display_codes_of_cases_without_outcome(record_cube: "xr.Dataset") -> "xr.DataArray":
    """Return the code shown for a case without an outcome: 10 + its status number, or 2 if the reason is not stored."""
    import xarray as xr

    unknown = xr.full_like(record_cube["overturned"], 2.0, dtype=np.float64)
    if "status" not in record_cube:
        return unknown
    reasons = [float(status) for status in CaseStatus if not status.trajectory_has_known_outcome]
    status = record_cube["status"].astype(np.float64)
    return xr.where(status.isin(reasons), 10.0 + status, unknown)


def _encode_array_as_base64(values: NDArray[Any]) -> str:
    """Encode the bytes of an array as base64 text."""
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")


def _encode_multiples_of_step_as_base64(
    values: FloatArray, encoding_step: float | FloatArray, integer_dtype_name: str
) -> str:
    """Round an array to multiples of `encoding_step`, and encode the multiples as unsigned integers in base64 text.

    The largest integer stands for missing; larger values are clipped to the second largest.
    """
    largest = np.iinfo(integer_dtype_name).max
    whole = np.where(np.isnan(values), largest, np.minimum(np.rint(np.nan_to_num(values) / encoding_step), largest - 1))
    return _encode_array_as_base64(whole.astype(integer_dtype_name))


def _keep_intermediate_probabilities_off_0_and_1(fall_probabilities: FloatArray) -> FloatArray:
    """Clip probabilities strictly between 0 and 1 so that rounding them to 240 steps does not make them 0 or 1."""
    return np.where(
        (fall_probabilities > 0) & (fall_probabilities < 1),
        np.clip(fall_probabilities, 1 / ENCODED_PROBABILITY_STEP_COUNT, 1 - 1 / ENCODED_PROBABILITY_STEP_COUNT),
        fall_probabilities,
    )


class InitialExplorerCase(NamedTuple):
    """Case of one record that the interactive page shows first, with a measure of how clearly its block falls.

    Attributes
    ----------
    direction_and_b_over_h_indices : list of int
        Indices of the cell along direction and B/H.
    fall_clarity_sort_key : tuple
        True if the case falls in every run; its probability of a fall; mean probability of the case and its
        neighbours; index of B/H. Of two cases the clearer one has the larger tuple.
    """

    direction_and_b_over_h_indices: list[int]
    fall_clarity_sort_key: tuple[bool, float, float, int]


def choose_initial_explorer_case(
    cells_by_direction_and_b_over_h: "xr.Dataset", directions_close_full_circle: bool
) -> InitialExplorerCase:
    """Choose the case of a block under one record that the interactive page shows first: a clear fall.

    Candidates are the cases that fall towards their azimuth (3-D: to any side) in every run of the ensemble. Of these
    the case is chosen whose eight neighbours in the grid have the largest mean probability of such a fall; of equal
    cases the stoutest. Without candidates, the case with the largest probability of such a fall is chosen.

    Parameters
    ----------
    cells_by_direction_and_b_over_h : Dataset
        Cells over direction and B/H.
    directions_close_full_circle : bool
        True if the last direction is next to the first one.
    """
    order = (
        default_model_of_same_kind_as_results_cube(cells_by_direction_and_b_over_h).direction_dimension_name,
        "b_over_h",
    )
    ensemble = ensemble_fall_or_fall_towards_probability(cells_by_direction_and_b_over_h)
    chance = np.nan_to_num(
        explorer_probabilities_towards_and_away(cells_by_direction_and_b_over_h)["towards"]
        .transpose(*order)
        .to_numpy()
        .astype(np.float64)
    )
    ran = np.ones_like(chance) if ensemble is None else ensemble.notnull().transpose(*order).to_numpy()
    every = (
        (chance == 1.0) & (cells_by_direction_and_b_over_h["overturned"].transpose(*order).to_numpy() == 1) & (ran > 0)
    )
    around = np.pad(chance, ((1, 1), (0, 0)), mode="wrap" if directions_close_full_circle else "edge")
    around = np.pad(around, ((0, 0), (1, 1)), mode="edge")
    nearby = np.lib.stride_tricks.sliding_window_view(around, (3, 3)).mean(axis=(2, 3)).round(6)
    stoutness = np.broadcast_to(np.arange(chance.shape[1]), chance.shape)
    rank = np.lexsort([-np.arange(chance.size), *(one.ravel() for one in (stoutness, nearby, chance, every))])
    a, b = np.unravel_index(rank[-1], chance.shape)
    return InitialExplorerCase([int(a), int(b)], (bool(every[a, b]), float(chance[a, b]), float(nearby[a, b]), int(b)))


def ensemble_fall_or_fall_towards_probability(cube: "xr.Dataset") -> "xr.DataArray | None":
    """Return the share of each case's ensemble runs that fall (2-D: that fall towards its azimuth).

    An ensemble repeats a case with slight changes. The share is NaN for cases without such runs. Returns None if the
    cube has no ensemble.
    """
    return cube.get("probability_falls", cube.get("probability_towards"))


def explorer_probabilities_towards_and_away(cube: "xr.Dataset") -> "xr.Dataset":
    """Return each case's probability of a fall towards its azimuth (3-D: of any fall), and of the opposite fall."""
    chance = fall_probabilities_towards_and_away(cube)
    if "probability_falls" in cube:
        chance["towards"] = cube["probability_falls"].fillna(chance["towards"])
    return chance
