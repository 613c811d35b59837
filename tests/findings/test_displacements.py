"""Slip and twist of stones that stand, and falls over a rim, from cubes written by hand."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import xarray as xr

from overturning.findings.displacements import final_slip_and_twist_of_standing_elements
from overturning.findings.exactness import final_twist_findings
from overturning.findings.results import StudyResults
from overturning.study.load import load_study
from overturning.study.scenes import NAME_OF_STUDY_ITSELF_AMONG_VARIANTS

STACK_STUDY_FILE = Path(__file__).parents[2] / "config" / "stack-3d.yaml"


def displacement_cube_of_one_record(elements: list[str], **values: Any) -> xr.Dataset:
    """Return a cube of one record; `values` are arrays (elements, 5 orientations) by variable, 0 if not given."""
    shape = (len(elements), 5)
    names = ("overturned", "residual_slip_north", "residual_slip_east", "residual_twist", "slid_off")
    return xr.Dataset(
        {
            name: (("record", "element", "orientation"), np.broadcast_to(values.get(name, 0.0), shape)[None])
            for name in names
        },
        {"element": elements},
    )


@pytest.fixture
def stack_and_single_shaft_results() -> StudyResults:
    """Return results of a stack: the shaft falls in 2 of 5 cases (once over the rim), and of a shaft that stands."""
    stack = displacement_cube_of_one_record(
        ["base", "shaft"],
        overturned=[[0] * 5, [0, 0, 0, 1, 1]],
        slid_off=[[0] * 5, [0, 0, 0, 0, 1]],
        residual_slip_north=[[0.03] * 5, [0.0, 0.01, -0.02, 9.0, 9.0]],
        residual_slip_east=[[-0.04] * 5, [0.0] * 5],
        residual_twist=[[-2.0, 2.0, -2.0, 2.0, np.nan], [1.0, -3.0, 5.0, 90.0, 90.0]],  # NaN: too weak to move it
    )
    alone = displacement_cube_of_one_record(["shaft"], residual_twist=[[7.0, -7.0, 7.0, -7.0, 7.0]])
    cubes = {NAME_OF_STUDY_ITSELF_AMONG_VARIANTS: stack, "shaft-alone": alone.isel(element=0, drop=True)}
    return cast(StudyResults, SimpleNamespace(study=load_study(STACK_STUDY_FILE), cubes_by_variant=cubes))


def test_median_slip_and_twist_are_of_standing_cases(stack_and_single_shaft_results: StudyResults) -> None:
    base, shaft, alone = final_slip_and_twist_of_standing_elements(stack_and_single_shaft_results)
    assert [one.element for one in (base, shaft)] == ["base", "shaft"]
    assert (base.variant, shaft.variant, alone.variant) == (
        NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
        NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
        "shaft-alone",
    )
    assert (base.standing_case_count, base.cases_with_fall, base.share_of_falls_by_sliding_off) == (5, 0, None)
    assert base.median_slip_if_standing_cm == pytest.approx(5.0), "3-4-5 cm, whatever its azimuth"
    assert (base.median_abs_twist_if_standing_deg, base.percentile_90_abs_twist_if_standing_deg) == (2.0, 2.0), (
        "of 0, 2, 2, 2, 2 degrees"
    )
    assert (shaft.standing_case_count, shaft.cases_with_fall, shaft.share_of_falls_by_sliding_off) == (3, 2, 0.5)
    assert shaft.median_slip_if_standing_cm == pytest.approx(1.0)
    assert shaft.percentile_90_slip_if_standing_cm == pytest.approx(1.8), "of 0, 1, 2 cm: 0.8 of the way to the last"
    assert (shaft.median_abs_twist_if_standing_deg, shaft.percentile_90_abs_twist_if_standing_deg) == pytest.approx(
        (3.0, 4.6)
    )
    assert (alone.element, alone.standing_case_count, alone.cases_with_fall) == ("shaft", 5, 0)
    assert alone.median_abs_twist_if_standing_deg == 7.0


def test_findings_have_no_sliding_off_of_the_lowest_stone_nor_twist_of_a_stack(
    stack_and_single_shaft_results: StudyResults,
) -> None:
    """The ground has no rim to slide over; the twist of stacked stones is among the displacements of the elements."""
    fallen = displacement_cube_of_one_record(
        ["base", "shaft"], overturned=[[1] * 5, [1] * 5], slid_off=[[0] * 5, [1, 0, 0, 0, 0]]
    )
    both = cast(
        StudyResults,
        SimpleNamespace(
            study=stack_and_single_shaft_results.study, cubes_by_variant={NAME_OF_STUDY_ITSELF_AMONG_VARIANTS: fallen}
        ),
    )
    base, shaft = final_slip_and_twist_of_standing_elements(both)
    assert (base.cases_with_fall, base.share_of_falls_by_sliding_off) == (5, None)
    assert (shaft.cases_with_fall, shaft.share_of_falls_by_sliding_off) == (5, 0.2)
    assert final_twist_findings(both) is None
