"""Illustrative cases for the report, selected by fixed rules."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import chain, starmap
from typing import Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.model import Model
from overturning.statistics.by_record import iterate_record_result_batches
from overturning.statistics.circular import wrap_axis_difference_to_90_deg

BOTH_SIDES_CASE_TITLE: Final = "Falls, but to which side?"
"""Title of the case with falls to both sides."""

ANY_ELEMENT_FALLS_VARIABLE: Final = "any_element_falls"
"""Name of a variable that is True where at least one element of the scene falls."""

MIN_VISIBLE_ROTATION_OVER_ALPHA: Final = 0.1
"""Smallest peak rotation, as a share of the critical angle α, at which a standing block rocks visibly."""

MIN_VISIBLE_TWIST_DEG: Final = 0.1
"""Smallest turn about the vertical of a standing stone that counts as turned, degrees; the report prints 0.1°."""

MAX_PLANE_ANGLE_TO_FAULT_OR_NORMAL_DEG: Final = 22.5
"""Largest angle between a plane and the fault normal (or the fault) that it represents, degrees."""

MAX_FALL_ANGLE_FROM_FACE_BISECTOR_DEG: Final = 10.0
"""Largest angle between a fall over a corner and the bisector of the normals of its two faces, degrees."""

COSINE_ROUNDING_ERROR: Final = 1e-9
"""Rounding error of the cosine of an angle between two falls."""


class IllustrativeCase(NamedTuple):
    """Simulated case shown as an example in a report: title, selection rule, record, block, azimuths of its panels."""

    title: str
    selection_rule_text: str
    record_index: int
    block_coordinates: dict[str, float]
    """Coordinates of the block, by dimension of the model."""
    panel_azimuths_deg: tuple[float, ...]
    """Azimuth or orientation of each panel, degrees."""
    variant_name_by_panel: tuple[str, ...] = ()
    """Variant of each panel; empty if all panels are of the study itself."""


class BestExampleCaseOfRecord(NamedTuple):
    """Best example case of one record according to an `IllustrativeCaseRule`: score, block and azimuths.

    A larger score is better.
    """

    score: tuple[float, ...]
    block_index_by_dimension: Sequence[int]
    """Positions along the dimensions of the block."""
    azimuth_or_orientation_index_by_panel: tuple[int, ...]
    """Position along the direction of each panel."""


_RuleTitleCaseAndRecordIndex = tuple[str, BestExampleCaseOfRecord | None, int]
"""Title of a rule, the best case of one record under the rule, or None, and the index of the record."""


class IllustrativeCaseRule(NamedTuple):
    """Rule that finds, among one record's results, the best case to illustrate one kind of behaviour.

    The function of the rule gets these results with their dimensions in the order of the model.
    """

    case_title: str
    rule_text: str
    find_best_case: Callable[[xr.Dataset], BestExampleCaseOfRecord | None]
    needed_cube_variables: tuple[str, ...]
    """Variables that the rule needs; it is skipped for a cube without them."""


def _case_with_largest_score(
    record_cube: xr.Dataset, wanted_fall_flag: int, case_scores: xr.DataArray, eligible_case_mask: xr.DataArray
) -> BestExampleCaseOfRecord | None:
    """Return, among eligible cases with a given outcome, the case with the largest score; None if there is none."""
    may = ((record_cube["overturned"] == wanted_fall_flag) & eligible_case_mask).to_numpy()
    if not may.any():
        return None
    values = case_scores.broadcast_like(record_cube["overturned"]).transpose(*record_cube["overturned"].dims).to_numpy()
    place = int(np.where(may, values, -np.inf).argmax())
    at, *block = (int(index) for index in np.unravel_index(place, may.shape))
    return BestExampleCaseOfRecord((float(values.flat[place]),), block, (at,))


def _standing_case_with_largest_magnitude(
    record_cube: xr.Dataset, variable_name: str, min_absolute_value: float
) -> BestExampleCaseOfRecord | None:
    size = abs(record_cube[variable_name])
    eligible = size >= min_absolute_value
    if ANY_ELEMENT_FALLS_VARIABLE in record_cube:  # the film shows all stones
        eligible = eligible & ~record_cube[ANY_ELEMENT_FALLS_VARIABLE].astype(bool)
    return _case_with_largest_score(record_cube, 0, size, eligible)


def _stoutest_falling_case(record_cube: xr.Dataset, eligible_case_mask: xr.DataArray) -> BestExampleCaseOfRecord | None:
    return _case_with_largest_score(record_cube, 1, record_cube["b_over_h"], eligible_case_mask)


def _stoutest_case_falling_over_corner(record_cube: xr.Dataset) -> BestExampleCaseOfRecord | None:
    off = (record_cube["fall_azimuth"].astype("float64") - record_cube["orientation"]) % 90.0
    return _stoutest_falling_case(record_cube, abs(off - 45.0) < MAX_FALL_ANGLE_FROM_FACE_BISECTOR_DEG)


def _find_case_falling_along_normal_not_along_fault(record_cube: xr.Dataset) -> BestExampleCaseOfRecord | None:
    azimuth = record_cube["azimuth"].to_numpy().astype(np.float64)
    distance = np.abs(
        wrap_axis_difference_to_90_deg(azimuth - float(record_cube["fault_normal"]))
    )  # NaN without a fault normal: no case
    if not (
        distance.min() <= MAX_PLANE_ANGLE_TO_FAULT_OR_NORMAL_DEG
        and distance.max() >= 90 - MAX_PLANE_ANGLE_TO_FAULT_OR_NORMAL_DEG
    ):
        return None
    along, across = int(distance.argmin()), int(distance.argmax())
    flags, rotation = record_cube["overturned"].to_numpy(), record_cube["peak_rotation"].to_numpy()
    splits = np.argwhere((np.abs(flags[along]) == 1) & (flags[across] == 0))
    if splits.size == 0:
        return None
    moves = rotation[across] > MIN_VISIBLE_ROTATION_OVER_ALPHA
    # Prefer a case that moves in both planes, then the broadest, the roughest and the lowest block.
    place = max(map(tuple, splits), key=lambda p: (moves[p], p[1], p[2], -p[0]))
    broad = round(float(record_cube["b_over_h"].values[place[1]]), 9)
    return BestExampleCaseOfRecord((float(moves[place]), broad), place, (along, across))


def _find_opposite_falls_at_neighbouring_directions(record_cube: xr.Dataset) -> BestExampleCaseOfRecord | None:
    model = default_model_of_same_kind_as_results_cube(record_cube)
    x, y, sure = (record_cube[name].to_numpy() for name in ("direction_cosine", "direction_sine", "sure"))
    turns = (
        x[:-1] * x[1:] + y[:-1] * y[1:] < -COSINE_ROUNDING_ERROR
    )  # by more than 90°; where a block stands both parts are 0
    if not turns.any():
        return None
    broad = model.dimension_names.index("b_over_h")
    score, place = max(
        ((bool(sure[at] and sure[at[0] + 1, *at[1:]]), int(at[broad])), at) for at in map(tuple, np.argwhere(turns))
    )
    return BestExampleCaseOfRecord(score, place[1:], (place[0], place[0] + 1))


ILLUSTRATIVE_CASE_RULES: Final = (
    IllustrativeCaseRule(
        "Falls normal to the fault, stands along it",
        "the broadest block of any record that falls in the plane nearest to the fault normal and rocks but stands in "
        "the one nearest to the fault (of several the first record, with the highest friction; where none rocks there, "
        "one that only stands)",
        _find_case_falling_along_normal_not_along_fault,
        ("peak_rotation",),
    ),
    IllustrativeCaseRule(
        BOTH_SIDES_CASE_TITLE,
        "the broadest block that falls at two neighbouring azimuths of the motion, or orientations of the body, but to "
        "azimuths more than 90° apart; first of those that do so in every run of the ensemble",
        _find_opposite_falls_at_neighbouring_directions,
        ("overturned",),
    ),
    IllustrativeCaseRule(
        "Leans furthest of all that stand",
        "the block with the largest rotation, in parts of α, of all that stand",
        lambda record_cube: _standing_case_with_largest_magnitude(
            record_cube, "peak_rotation", MIN_VISIBLE_ROTATION_OVER_ALPHA
        ),
        ("peak_rotation",),
    ),
    IllustrativeCaseRule(
        "Falls, though both planes of its faces say it stands",
        "the broadest block that does so",
        lambda record_cube: _stoutest_falling_case(record_cube, record_cube["plane_overturned"] == 0),
        ("plane_overturned",),
    ),
    IllustrativeCaseRule(
        "Falls over a corner",
        f"the broadest block whose fall lies within {MAX_FALL_ANGLE_FROM_FACE_BISECTOR_DEG:g}° of the middle between "
        f"the "
        "normals of two faces",
        _stoutest_case_falling_over_corner,
        ("plane_overturned", "fall_azimuth"),
    ),
    IllustrativeCaseRule(
        "Stands, and has turned",
        "the block with the largest turn about the vertical of all that stand",
        lambda record_cube: _standing_case_with_largest_magnitude(record_cube, "residual_twist", MIN_VISIBLE_TWIST_DEG),
        ("residual_twist",),
    ),
)
"""Rules in the order in which their cases are shown."""


def find_best_case_for_each_behaviour(cube: xr.Dataset) -> list[IllustrativeCase]:
    """Find the cases that illustrate a study: for each rule of `ILLUSTRATIVE_CASE_RULES`, the best case of all records.

    A rule without any case is left out. The cube is read in batches of records. Its optional variable
    `ANY_ELEMENT_FALLS_VARIABLE` is True where a stone of the scene falls; such a case is not used to show a standing
    stone.
    """
    model = default_model_of_same_kind_as_results_cube(cube)
    cells = model.distinct_direction_indices(cube)
    rules = [rule for rule in ILLUSTRATIVE_CASE_RULES if all(name in cube for name in rule.needed_cube_variables)]
    names = [
        "overturned",
        *model.variable_names_read_for_fall_probability,
        *{name for rule in rules for name in rule.needed_cube_variables},
    ]
    names += [ANY_ELEMENT_FALLS_VARIABLE] * (ANY_ELEMENT_FALLS_VARIABLE in cube)
    batches = starmap(
        partial(_best_example_cases_of_record_batch, model, cells, rules), iterate_record_result_batches(cube, names)
    )
    best = _best_example_case_by_rule_title(chain.from_iterable(batches))
    return [
        _illustrative_case_from_best(cube, rule, *best[rule.case_title], distinct_direction_indices=cells)
        for rule in rules
        if rule.case_title in best
    ]


def _best_example_cases_of_record_batch(
    model: Model,
    distinct_direction_indices: NDArray[np.intp],
    rules: list[IllustrativeCaseRule],
    record_indices: list[int],
    cube_of_record_batch: xr.Dataset,
) -> list[_RuleTitleCaseAndRecordIndex]:
    """Find the best case of each of a few records under each rule.

    A function of its own, so that its arrays of all cases are released before the next records are read.
    """
    half = cube_of_record_batch.isel({model.direction_dimension_name: distinct_direction_indices})
    nominal = model.fall_probability_and_direction_by_case(half, use_ensemble=False)
    candidates = half.assign(
        nominal[["direction_cosine", "direction_sine"]].assign(
            sure=model.fall_probability_and_direction_by_case(half)["falls"] > 0.99
        )
    ).transpose("record", *model.dimension_names, ...)
    records = [(record, candidates.isel(record=at)) for at, record in enumerate(record_indices)]
    return [(rule.case_title, rule.find_best_case(one), record) for record, one in records for rule in rules]


def _best_example_case_by_rule_title(
    best_cases_by_rule_and_record: Iterable[_RuleTitleCaseAndRecordIndex],
) -> dict[str, tuple[BestExampleCaseOfRecord, int]]:
    """Return, for each rule (by title), the case with the largest score of all records, and its record index.

    The first case is returned if several have the same score. Rules that found no case are left out.
    """
    best: dict[str, tuple[BestExampleCaseOfRecord, int]] = {}
    for title, case, record in best_cases_by_rule_and_record:
        if case is not None and (title not in best or case.score > best[title][0].score):
            best[title] = case, record
    return best


def _illustrative_case_from_best(
    cube: xr.Dataset,
    rule: IllustrativeCaseRule,
    best_case: BestExampleCaseOfRecord,
    record_index: int,
    *,
    distinct_direction_indices: NDArray[np.intp],
) -> IllustrativeCase:
    """Convert the best case found by a rule to an `IllustrativeCase`, with coordinates in place of indices.

    `distinct_direction_indices` are the positions, in the cube, of the directions that the rule was given.
    """
    model = default_model_of_same_kind_as_results_cube(cube)
    block = {
        name: float(cube[name].values[at])
        for name, at in zip(model.case_dims_without_direction, best_case.block_index_by_dimension, strict=True)
    }
    directions = cube[model.direction_dimension_name].values[distinct_direction_indices]
    angles = tuple(float(directions[at]) for at in best_case.azimuth_or_orientation_index_by_panel)
    return IllustrativeCase(rule.case_title, rule.rule_text, record_index, block, angles)


FALLS_IN_ONE_VARIANT_ONLY_RULE: Final = IllustrativeCaseRule(
    "Falls in one setting, stands in the other",
    "a block and motion whose outcome differs between the two settings as in most of the cases that differ; among "
    "these one that rocks where it stands, then one whose neighbours in azimuth and slenderness differ likewise, then "
    "the broadest",
    lambda one: _clearest_example_among_marked_cases(one, "split"),
    ("peak_rotation",),
)
"""Rule for a comparison of two settings; its cells have variables of the second setting, named ``other_…``."""

OPPOSITE_FALLS_IN_TWO_VARIANTS_RULE: Final = IllustrativeCaseRule(
    "Falls to opposite sides in the two settings",
    "a block that falls in both settings, to azimuths more than 90° apart; first one whose neighbours in azimuth and "
    "slenderness do so, too, then the broadest",
    lambda one: _clearest_example_among_marked_cases(one, "opposite"),
    (),
)
"""Rule for a comparison in which the same blocks fall in both settings."""


def _clearest_example_among_marked_cases(
    case_masks: xr.Dataset, mask_variable_name: str
) -> BestExampleCaseOfRecord | None:
    """Return the case that is the clearest example among those that are True in a mask variable, or None.

    A case in which the block rocks is preferred, then one whose neighbours are marked too, then the broadest block.
    """
    model = default_model_of_same_kind_as_results_cube(case_masks)
    cells = case_masks[mask_variable_name].to_numpy()
    if not cells.any():
        return None
    alike = np.zeros(cells.shape, np.int64)
    for axis in (0, model.dimension_names.index("b_over_h")):
        for step in (-1, 1):
            alike += np.take(cells, np.clip(np.arange(cells.shape[axis]) + step, 0, cells.shape[axis] - 1), axis)
    rocks = case_masks["rocks"].to_numpy() if "rocks" in case_masks else np.zeros(cells.shape, np.bool_)
    broad = model.dimension_names.index("b_over_h")
    score, place = max(((int(rocks[at]), int(alike[at]), int(at[broad])), at) for at in map(tuple, np.argwhere(cells)))
    ratio = round(float(case_masks["b_over_h"].values[place[broad]]), 9)
    return BestExampleCaseOfRecord((*map(float, score[:2]), ratio), place[1:], (place[0],))


def _count_falls_in_one_cube_only(first_cube: xr.Dataset, second_cube: xr.Dataset) -> tuple[int, int]:
    """Return the number of cases that fall in the first cube only, and the number that fall in the second only.

    Cases with an unknown outcome in either cube do not count.
    """
    one, another = (each["overturned"].to_numpy() for each in (first_cube, second_cube))
    known = np.isfinite(one) & np.isfinite(another)
    return int((known & (one != 0) & (another == 0)).sum()), int((known & (one == 0) & (another != 0)).sum())


def _masks_of_differing_and_rocking_cases(
    model: Model, first_cube: xr.Dataset, second_cube: xr.Dataset, *, mark_falls_in_first_cube: bool
) -> xr.Dataset:
    """Return masks of the cases that fall in only one of two cubes, or to opposite sides, and of rocking blocks.

    ``split``: cases that fall in the first cube and stand in the second if `mark_falls_in_first_cube` is true,
    otherwise the reverse. ``opposite``: cases that fall to opposite sides (3-D: more than 90° apart). ``rocks``: cases
    whose peak rotation is visible in the cube in which ``split`` cases stand.
    """
    one, another = (each.transpose(*model.dimension_names, ...) for each in (first_cube, second_cube))
    flags, others = one["overturned"].to_numpy(), another["overturned"].to_numpy()
    falls, stands = (flags, others) if mark_falls_in_first_cube else (others, flags)
    split = np.isfinite(flags) & np.isfinite(others) & (falls != 0) & (stands == 0)
    if "fall_azimuth" in one:
        apart = np.radians(one["fall_azimuth"].to_numpy().astype(np.float64) - another["fall_azimuth"].to_numpy())
        opposite = np.cos(apart) < -COSINE_ROUNDING_ERROR
    else:
        opposite = flags * others < 0
    marked = {"split": (model.dimension_names, split), "opposite": (model.dimension_names, opposite)}
    standing = another if mark_falls_in_first_cube else one
    if "peak_rotation" in standing:
        rocks = standing["peak_rotation"].to_numpy() > MIN_VISIBLE_ROTATION_OVER_ALPHA
        marked["rocks"] = (model.dimension_names, rocks)
    return xr.Dataset(marked, coords={name: one[name] for name in model.dimension_names})
