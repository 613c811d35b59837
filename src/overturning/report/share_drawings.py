"""Drawing of the overturned shares of a study and a variant for the report."""

from typing import TYPE_CHECKING

from overturning.figures.answer import (
    PlottedEstimate,
    overturned_shares_and_difference_figure,
)
from overturning.findings.collect import Findings
from overturning.findings.contrast import VariantContrast
from overturning.findings.values import Estimate

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def legend_names_of_study_and_variant(findings: Findings, contrast: VariantContrast) -> tuple[str, str]:
    """Return two legend names: one for the study, and one for the variant with which it is compared."""
    if contrast.differing_settings == ["vertical"]:
        names = ("with vertical motion", "without vertical motion")
        return names if findings.study.applies_vertical_motion else names[::-1]
    if contrast.differing_settings == ["scene"]:
        return contrast.scene_name_of_study, contrast.scene_name_of_variant
    if contrast.differing_settings == ["site"]:
        soil = (
            f"soil of {contrast.variant}"
            if contrast.soil_thickness_of_variant_m is None
            else f"{contrast.soil_thickness_of_variant_m:g} m of soil"
        )
        return "ground as recorded", soil
    return "this study", f"variant {contrast.variant}"


def convert_to_plotted_estimate(estimate: Estimate) -> PlottedEstimate:
    """Convert an estimate of the findings (value, interval, earthquakes) to the data type that figures draw."""
    return PlottedEstimate(estimate.value, estimate.low, estimate.high, estimate.earthquake_count)


def draw_overturned_shares_of_study_and_variant(contrast: VariantContrast, legend_names: tuple[str, str]) -> "Figure":
    """Draw the shares of cases that fall in the study and in a variant, and their difference, in total and by B/H."""
    shapes = contrast.overturned_shares_by_b_over_h if len(contrast.overturned_shares_by_b_over_h) > 1 else []
    rows = ["all cases", *(f"B/H {each.b_over_h:.3g}" for each in shapes)]
    here = [
        convert_to_plotted_estimate(contrast.share_overturned_in_study),
        *(convert_to_plotted_estimate(each.share_overturned_in_study) for each in shapes),
    ]
    there = [
        convert_to_plotted_estimate(contrast.share_overturned_in_variant),
        *(convert_to_plotted_estimate(each.share_overturned_in_variant) for each in shapes),
    ]
    differences = [
        convert_to_plotted_estimate(contrast.study_minus_variant_share),
        *(convert_to_plotted_estimate(each.study_minus_variant_share) for each in shapes),
    ]
    if (
        contrast.population_fall_rate_in_study is not None
        and contrast.population_fall_rate_in_variant is not None
        and contrast.primary_statistic_study_minus_variant != contrast.study_minus_variant_share
    ):
        rows = ["stones of a cemetery", "all blocks", *rows[1:]]
        here, there = (
            [convert_to_plotted_estimate(contrast.population_fall_rate_in_study), *here],
            [convert_to_plotted_estimate(contrast.population_fall_rate_in_variant), *there],
        )
        differences = [convert_to_plotted_estimate(contrast.primary_statistic_study_minus_variant), *differences]
    return overturned_shares_and_difference_figure(
        rows, dict(zip(legend_names, (here, there), strict=True)), differences
    )
