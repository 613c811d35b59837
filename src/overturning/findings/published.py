"""Comparison of a study with published peaks of its motions and published outcomes."""

from typing import Final

from overturning.findings.causes import published_cases_recomputed_by_height_and_friction
from overturning.findings.results import StudyResults
from overturning.findings.values import FindingBaseClass
from overturning.units import CM, GAL

PUBLISHED_PEAK_MEASURES_UNITS_TOLERANCES: Final = (
    ("pga", "pga_gal", "PGA", "Gal", GAL, 0.01),
    ("pgv", "pgv_cm_s", "PGV", "cm/s", CM, 0.05),
    ("pgd", "pgd_cm", "PGD", "cm", CM, 0.20),
)
"""Variable, key of the study, measure, unit, factor to SI, and difference that the choices of a processing explain."""


class PublishedPeakComparison(FindingBaseClass):
    """Published peak of one component of a record, and the peak of the motion that the study uses."""

    component: str
    measure: str
    unit: str
    published_peak: float
    study_motion_peak: float
    study_over_published_peak_minus_1: float
    """Share by which the computed peak is larger."""
    max_relative_difference_from_processing: float
    """Largest difference that the processing of a record explains."""
    agrees: bool


class BlockCountAgreeingWithPublished(FindingBaseClass):
    """Number of blocks, in one variant of a study, whose outcomes all agree with published outcomes."""

    variant: str
    blocks: int
    """Number of heights times frictions."""
    fully_agreeing_block_count: int
    heights_agreeing_at_some_friction_m: list[float]
    """Heights for which all published outcomes are found with at least one friction."""


def compare_peaks_with_published(results: StudyResults) -> list[PublishedPeakComparison]:
    """Compare PGA, PGV and other peaks of the study's motions with published peaks along the same azimuths."""
    ids, rows = [name.id for name in results.record_ids_and_names], []
    for row in results.study.published:
        measures = results.intensity_measures.isel(record=ids.index(row.record)).sel(azimuth=row.azimuth)
        for variable, key, measure, unit, factor, tolerance in PUBLISHED_PEAK_MEASURES_UNITS_TOLERANCES:
            published = getattr(row, key)
            if published is not None:
                computed = float(measures[variable]) / factor
                difference = computed / published - 1.0
                rows.append(
                    PublishedPeakComparison(
                        component=row.label or f"{row.record}, {row.azimuth:g}°",
                        measure=measure,
                        unit=unit,
                        published_peak=published,
                        study_motion_peak=computed,
                        study_over_published_peak_minus_1=difference,
                        max_relative_difference_from_processing=tolerance,
                        agrees=abs(difference) <= tolerance,
                    )
                )
    return rows


def count_fully_agreeing_published_blocks_by_variant(results: StudyResults) -> list[BlockCountAgreeingWithPublished]:
    """Count, for each variant, the blocks whose outcomes all agree with published ones.

    A block is a pair of height and friction coefficient.
    """
    wanted = tuple(row.overturns for row in results.study.published)
    rows = []
    for variant in results.cubes_by_variant if wanted else ():
        found = published_cases_recomputed_by_height_and_friction(results, variant)
        agreeing = [block for block, overturns in found.items() if overturns == wanted]
        rows.append(
            BlockCountAgreeingWithPublished(
                variant=variant,
                blocks=len(found),
                fully_agreeing_block_count=len(agreeing),
                heights_agreeing_at_some_friction_m=sorted({round(height, 9) for height, _ in agreeing}),
            )
        )
    return rows
