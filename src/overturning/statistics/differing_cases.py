"""Illustrative cases whose outcomes differ between two results cubes."""

from functools import partial

import numpy as np
import xarray as xr

from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.statistics.by_record import iterate_results_by_record
from overturning.statistics.illustrative import (
    FALLS_IN_ONE_VARIANT_ONLY_RULE,
    OPPOSITE_FALLS_IN_TWO_VARIANTS_RULE,
    IllustrativeCase,
    _best_example_case_by_rule_title,
    _count_falls_in_one_cube_only,
    _illustrative_case_from_best,
    _masks_of_differing_and_rocking_cases,
    _RuleTitleCaseAndRecordIndex,
)


def clearest_case_with_differing_outcomes(
    first_cube: xr.Dataset, second_cube: xr.Dataset, variant_names: tuple[str, str]
) -> IllustrativeCase | None:
    """Return the clearest case whose outcome differs between two variants of a study; None if no outcome differs.

    The block falls in one cube and stands in the other. Of the cases that fall in only one cube, the function chooses
    one from the cube with more of them. If there is none, it chooses a case that falls to opposite sides in both cubes.

    Parameters
    ----------
    first_cube, second_cube : Dataset
        Cubes of one element and amplitude with the same cases in the same order.
    variant_names : tuple of str
        Names of their variants, for the panels of the case.
    """
    model = default_model_of_same_kind_as_results_cube(first_cube)
    cells = model.distinct_direction_indices(first_cube)
    names = ["overturned", "fall_azimuth", "peak_rotation"]
    found_cases: list[_RuleTitleCaseAndRecordIndex] = []
    pairs = partial(zip, strict=True)
    record_pairs = pairs(iterate_results_by_record(first_cube, names), iterate_results_by_record(second_cube, names))
    counts = [_count_falls_in_one_cube_only(*pair) for pair in record_pairs]
    only_this, only_other = np.sum(counts, axis=0)
    for record, pair in enumerate(
        pairs(iterate_results_by_record(first_cube, names), iterate_results_by_record(second_cube, names))
    ):
        this, that = (each.isel({"record": 0, model.direction_dimension_name: cells}) for each in pair)
        one = _masks_of_differing_and_rocking_cases(model, this, that, mark_falls_in_first_cube=only_this >= only_other)
        found_cases += [
            (rule.case_title, rule.find_best_case(one), record)
            for rule in (FALLS_IN_ONE_VARIANT_ONLY_RULE, OPPOSITE_FALLS_IN_TWO_VARIANTS_RULE)
        ]
    best = _best_example_case_by_rule_title(found_cases)
    for rule in (FALLS_IN_ONE_VARIANT_ONLY_RULE, OPPOSITE_FALLS_IN_TWO_VARIANTS_RULE):
        if rule.case_title in best:
            case = _illustrative_case_from_best(
                first_cube, rule, *best[rule.case_title], distinct_direction_indices=cells
            )
            return case._replace(panel_azimuths_deg=2 * case.panel_azimuths_deg, variant_name_by_panel=variant_names)
    return None
