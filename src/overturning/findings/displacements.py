"""Slip and twist of the stones of a 3-D scene at the end, and falls over the rim of what a stone stands on."""

from overturning.findings.results import StudyResults
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.statistics.elements import summarise_element_displacements
from overturning.study.scenes import variant_scene


class ElementDisplacementFindings(FindingBaseClass):
    """Final slip and rotation of one element of a 3-D scene, relative to its support."""

    variant: str
    """Name of the variant; "nominal" for the study itself."""
    scene: str
    """Name of the scene."""
    element: str
    """Name of the element."""
    standing_case_count: int
    """Number of cases in which the element stands."""
    median_slip_if_standing_cm: OptionalNumberOrInfinity
    """Median of the horizontal slip over the standing cases, cm."""
    percentile_90_slip_if_standing_cm: OptionalNumberOrInfinity
    """90th percentile of the horizontal slip over the standing cases, cm."""
    median_abs_twist_if_standing_deg: OptionalNumberOrInfinity
    """Median of the absolute rotation about the vertical over the standing cases, degrees."""
    percentile_90_abs_twist_if_standing_deg: OptionalNumberOrInfinity
    """90th percentile of the absolute rotation about the vertical over the standing cases, degrees."""
    cases_with_fall: int
    """Number of cases in which the element falls."""
    share_of_falls_by_sliding_off: OptionalNumberOrInfinity
    """Share of its falls in which it slides over the rim of what it stands on; None without falls, and for the lowest
    stone, since the ground has no rim."""


def final_slip_and_twist_of_standing_elements(results: StudyResults) -> list[ElementDisplacementFindings]:
    """Summarise, by variant, slip and absolute twist (rotation about the vertical) of each element where it stands.

    Empty for planar models and for studies of a single body, whose rotation is in the finding
    `twist_of_moved_standing_stones`.
    """
    if not results.study.is_stack:
        return []
    return [
        ElementDisplacementFindings(
            variant=variant,
            scene=variant_scene(results.study, variant).name,
            element=row.element_name
            if "element" in cube.dims
            else variant_scene(results.study, variant).free_element_names[0],
            standing_case_count=row.standing_case_count,
            median_slip_if_standing_cm=100.0 * row.standing_median_and_p90_slip_m[0],
            percentile_90_slip_if_standing_cm=100.0 * row.standing_median_and_p90_slip_m[1],
            median_abs_twist_if_standing_deg=row.standing_median_and_p90_twist_deg[0],
            percentile_90_abs_twist_if_standing_deg=row.standing_median_and_p90_twist_deg[1],
            cases_with_fall=row.fallen_case_count,
            share_of_falls_by_sliding_off=row.count_of_falls_over_support_rim / row.fallen_case_count
            if place and row.count_of_falls_over_support_rim is not None and row.fallen_case_count
            else None,
        )
        for variant, cube in results.cubes_by_variant.items()
        for place, row in enumerate(summarise_element_displacements(cube))
    ]
