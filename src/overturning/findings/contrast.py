"""Comparison of the study with its variants, case by case."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.findings.results import StudyResults
from overturning.findings.soil import FALL_RATE_DESCRIPTION
from overturning.findings.values import Estimate, FindingBaseClass, OptionalNumberOrInfinity, estimate_from_mean
from overturning.model.scene import Scene
from overturning.model.variables import mask_of_known_outcomes
from overturning.statistics.bootstrap import mean_over_earthquakes, mean_share_over_earthquakes
from overturning.statistics.elements import (
    ElementFallCounts,
    compare_falls_of_two_stones_over_earthquakes,
    count_falls_of_two_stones,
)
from overturning.statistics.opposite_azimuths import overturned_shares_by_record
from overturning.study.scenes import (
    NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
    compared_element_names_of_study_and_variant,
    names_of_settings_in_which_variants_differ,
    select_outcomes_of_element,
    settings_changed_by_variant,
    variant_scene,
)
from overturning.surveys.population import fall_rates_of_stones_with_outcome_in_both_cubes


class VariantContrast(FindingBaseClass):
    """Comparison of a study with one variant (the study with changed settings), over cases with an outcome in both."""

    variant: str
    """Name of the variant."""
    is_primary_comparison: bool
    """True for the variant against which the primary statistic is compared."""
    scene_name_of_study: str
    """Name of the scene of the study, and of that of the variant."""
    scene_name_of_variant: str
    compared_element_in_study: str
    """Name of the element that is compared in the study, and of that in the variant."""
    compared_element_in_variant: str
    differing_settings: list[str]
    """Settings that differ: scene, contact, vertical, site."""
    soil_thickness_of_variant_m: OptionalNumberOrInfinity
    """Thickness of the soil of the variant above the rock, m; None without soil."""
    compared_record_count: int
    """Number of compared records; if only vertical motion differs, those with a vertical component."""
    cases_not_compared: int
    """Number of cases under these records without an outcome in the study or in the variant."""
    share_overturned_in_study: Estimate
    """Share of the cases that overturn in the study."""
    share_overturned_in_variant: Estimate
    """Share of the cases that overturn in the variant."""
    study_minus_variant_share: Estimate
    """Share in the study minus share in the variant, record by record."""
    share_overturned_only_in_study: Estimate
    """Share of the cases that overturn in the study only."""
    share_overturned_only_in_variant: Estimate
    """Share of the cases that overturn in the variant only."""
    share_overturned_in_both: Estimate
    """Share of the cases that overturn in both."""
    share_within_45_deg_of_each_other_if_both_fall: Estimate
    """Share of the falls in both that go within 45° of each other."""
    share_over_45_deg_apart_if_both_fall: OptionalNumberOrInfinity
    """Share of the falls in both that go more than 45° apart; None without such falls."""
    share_falling_first_in_study_if_both_fall: Estimate
    """Share of the falls in both that are earlier in the study."""
    share_falling_simultaneously_if_both_fall: Estimate
    """Share of the falls in both that are at the same time."""
    share_study_stone_falls_first_if_either_falls: Estimate
    """Share, of the cases with a fall in either, in which the stone of the study falls first or alone; a case with
    falls at the same time counts half."""
    overturned_shares_by_b_over_h: list["OverturnedSharesAtBOverH"]
    """Shares of the cases that overturn, for each B/H."""
    population_fall_rate_in_study: Estimate | None
    """Fall rate of the population in the study under the records as they are, over the stones with an outcome in both;
    None without a population."""
    population_fall_rate_in_variant: Estimate | None
    primary_statistic_study_minus_variant: Estimate
    """Difference of the primary statistic: of the fall rates if that is the fall rate, otherwise of the shares."""


class OverturnedSharesAtBOverH(FindingBaseClass):
    """Shares of the cases with one value of B/H that overturn, in the study and in one of its variants."""

    b_over_h: float
    """Width-to-height ratio B/H of the block."""
    share_overturned_in_study: Estimate
    """Share of the cases that overturn in the study."""
    share_overturned_in_variant: Estimate
    """Share of the cases that overturn in the variant."""
    study_minus_variant_share: Estimate
    """First share minus the second, record by record."""


class ElementFallSummaryForOneVariant(FindingBaseClass):
    """Number of falls, share of cases with a fall, and median fall time of one element of a scene."""

    variant: str
    """Name of the variant; "nominal" for the study itself."""
    scene: str
    """Name of the scene."""
    element: str
    """Name of the element."""
    cases_with_outcome: int
    """Number of cases with an outcome."""
    falls: int
    """Number of cases in which the element falls."""
    share_overturned: OptionalNumberOrInfinity
    """Share of the cases in which the element falls."""
    falls_with_no_earlier_fall: int
    """Number of falls in which no other element falls before."""
    share_of_falls_with_no_earlier_fall: OptionalNumberOrInfinity
    """Share of its falls in which no other element falls before; None without falls."""
    share_of_falls_without_other_falls: OptionalNumberOrInfinity
    """Share of its falls in which no other element falls at all; None without falls."""
    median_fall_time_s: OptionalNumberOrInfinity
    """Median time of the falls from the start of the record, s."""


SHARE_OVERTURNED_DESCRIPTION = "share of the cases that overturn"


def indices_of_records_where_variant_can_differ(results: StudyResults, variant: str) -> NDArray[np.intp]:
    """Return the indices of the records under which outcomes of the study and of its variant `variant` are compared.

    If the variant differs in vertical motion only, records without a vertical component are left out: their outcomes
    are the same in the study and the variant.
    """
    every = np.arange(results.reference_element_cube.sizes["record"])
    if names_of_settings_in_which_variants_differ(results.study, NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant) != [
        "vertical"
    ]:
        return every
    applied = [
        results.cube_of_default_element(name)["vertical"].to_numpy() == 1
        for name in (NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant)
    ]
    return every[np.logical_or(*applied)]


def compare_study_with_variants(results: StudyResults) -> list[VariantContrast]:
    """Compare the outcomes of the study with those of each variant that has records to compare."""
    places = {name: indices_of_records_where_variant_can_differ(results, name) for name in results.study.variants}
    return [_compare_study_with_variant(results, name, some) for name, some in places.items() if some.size]


def _compare_study_with_variant(
    results: StudyResults, variant_name: str, record_indices: NDArray[np.intp]
) -> VariantContrast:
    """Compare the outcomes of the study and of one variant under the records with the given indices."""
    elements = compared_element_names_of_study_and_variant(results.study, variant_name)
    cubes = [
        select_outcomes_of_element(results.cubes_by_variant[name], element).isel(record=record_indices)
        for name, element in zip((NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant_name), elements, strict=True)
    ]
    events = results.record_events[record_indices]
    counts = count_falls_of_two_stones(*cubes)
    found = compare_falls_of_two_stones_over_earthquakes(counts, events)
    paired = _keep_outcomes_known_in_both(*cubes)
    shares = (overturned_shares_by_record(cube).to_numpy() for cube in paired)
    here, there, difference = _estimates_of_overturned_shares(events, *shares)
    stones = results.study.population
    rates = None if stones is None else fall_rates_of_stones_with_outcome_in_both_cubes(cubes[0], cubes[1], stones)
    means = (mean_share_over_earthquakes(rate, events) for rate in rates or ())
    mean_rates = [estimate_from_mean(mean, FALL_RATE_DESCRIPTION) for mean in means]
    with_rate = results.study.primary.statistic == "fall_rate"
    rate_difference = mean_over_earthquakes(rates[0] - rates[1], events) if rates and with_rate else None
    scenes = [variant_scene(results.study, name) for name in (NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant_name)]
    site = settings_changed_by_variant(results.study, variant_name).site
    same_direction = found.same_direction_share_if_both_fall
    b_over_h = results.reference_element_cube["b_over_h"].to_numpy()
    return VariantContrast(
        variant=variant_name,
        is_primary_comparison=variant_name == results.study.primary.against,
        scene_name_of_study=scenes[0].name,
        scene_name_of_variant=scenes[1].name,
        compared_element_in_study=elements[0],
        compared_element_in_variant=elements[1],
        differing_settings=names_of_settings_in_which_variants_differ(
            results.study, NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant_name
        ),
        soil_thickness_of_variant_m=sum(layer.thickness_m for layer in site.layers) if site is not None else None,
        compared_record_count=int(record_indices.size),
        cases_not_compared=cubes[0]["overturned"].size - int(counts["compared"].sum()),
        share_overturned_in_study=here,
        share_overturned_in_variant=there,
        study_minus_variant_share=difference,
        share_overturned_only_in_study=estimate_from_mean(
            found.share_of_cases_only_this_falls, "share of the cases that overturn in the study only"
        ),
        share_overturned_only_in_variant=estimate_from_mean(
            found.share_of_cases_only_other_falls, "share of the cases that overturn in the variant only"
        ),
        share_overturned_in_both=estimate_from_mean(
            found.share_of_cases_both_fall, "share of the cases that overturn in both"
        ),
        share_within_45_deg_of_each_other_if_both_fall=estimate_from_mean(
            same_direction, "share of the falls in both that go within 45° of each other"
        ),
        share_over_45_deg_apart_if_both_fall=1.0 - same_direction.mean,
        share_falling_first_in_study_if_both_fall=estimate_from_mean(
            found.this_earlier_share_if_both_fall, "share of the falls in both that are earlier in the study"
        ),
        share_falling_simultaneously_if_both_fall=estimate_from_mean(
            found.share_of_simultaneous_falls_if_both_fall, "share of the falls in both that are at the same time"
        ),
        share_study_stone_falls_first_if_either_falls=estimate_from_mean(
            found.this_first_or_alone_share_if_any_falls,
            "share of the cases with a fall in either in which the stone of the study falls first or alone",
        ),
        overturned_shares_by_b_over_h=_overturned_shares_at_each_b_over_h(b_over_h, paired, events),
        population_fall_rate_in_study=mean_rates[0] if mean_rates else None,
        population_fall_rate_in_variant=mean_rates[1] if mean_rates else None,
        primary_statistic_study_minus_variant=(
            difference
            if rate_difference is None
            else estimate_from_mean(rate_difference, f"difference of the {FALL_RATE_DESCRIPTION}")
        ),
    )


def _estimates_of_overturned_shares(
    record_events: NDArray[np.str_], study_shares: FloatArray, variant_shares: FloatArray
) -> tuple[Estimate, Estimate, Estimate]:
    """Return means over earthquakes of overturned shares by record: of study, variant, and study minus variant."""
    difference = mean_over_earthquakes(study_shares - variant_shares, record_events)
    return (
        estimate_from_mean(mean_share_over_earthquakes(study_shares, record_events), SHARE_OVERTURNED_DESCRIPTION),
        estimate_from_mean(mean_share_over_earthquakes(variant_shares, record_events), SHARE_OVERTURNED_DESCRIPTION),
        estimate_from_mean(difference, f"difference of the {SHARE_OVERTURNED_DESCRIPTION}"),
    )


def _overturned_shares_at_each_b_over_h(
    b_over_h_values: FloatArray, study_and_variant_cubes: tuple[xr.Dataset, xr.Dataset], record_events: NDArray[np.str_]
) -> list[OverturnedSharesAtBOverH]:
    """Return the overturned shares in study and variant at each B/H; both cubes have outcomes in the same cases."""
    shapes = [overturned_shares_by_record(cube, "b_over_h").to_numpy() for cube in study_and_variant_cubes]
    found = []
    for ratio, one, other in zip(b_over_h_values, *shapes, strict=True):
        here, there, difference = _estimates_of_overturned_shares(record_events, one, other)
        found.append(OverturnedSharesAtBOverH(
            b_over_h=round(float(ratio), 9), share_overturned_in_study=here, share_overturned_in_variant=there,
            study_minus_variant_share=difference,
        ))  # fmt: skip
    return found


def _keep_outcomes_known_in_both(cube: xr.Dataset, other_cube: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset]:
    """Mask in two results cubes each outcome that is unknown in either, so that shares are of the same cases.

    The cubes have the same cases in the same order. Otherwise shares could differ although no case changes.
    """
    flags = [one["overturned"] for one in (cube, other_cube)]
    # A stack has no dimension of aspects, a body has one of length 1.
    known = [mask_of_known_outcomes(flag).data for flag in flags]
    both = [flag.copy(data=one.reshape(flag.shape)) for flag, one in zip(flags, reversed(known), strict=True)]
    masked = [flag.where(one) for flag, one in zip(flags, both, strict=True)]
    return cube.assign(overturned=masked[0]), other_cube.assign(overturned=masked[1])


def element_fall_findings(results: StudyResults) -> list[ElementFallSummaryForOneVariant]:
    """Count the falls of each element of the scene, for the study and for each of its variants.

    Empty if study and variants all have the same scene, and this has a single element.
    """
    study = results.study
    several = any("element" in cube.dims for cube in results.cubes_by_variant.values())
    if not several and not any(variant.scene for variant in study.variants.values()):
        return []
    return [
        _fall_outcomes_of_element(name, variant_scene(study, name), row, "element" in cube.dims)
        for name, cube in results.cubes_by_variant.items()
        for row in results.element_fall_counts_by_variant[name]
    ]


def _fall_outcomes_of_element(
    variant_name: str, scene: Scene, fall_counts: ElementFallCounts, scene_has_several_elements: bool
) -> ElementFallSummaryForOneVariant:
    """Return number, share and median time of the falls of one scene element in the study or one of its variants."""
    falls, first_falls = fall_counts.fall_count, fall_counts.count_of_falls_with_no_earlier_fall
    return ElementFallSummaryForOneVariant(
        variant=variant_name, scene=scene.name,
        element=fall_counts.element_name if scene_has_several_elements else scene.free_element_names[0],
        cases_with_outcome=fall_counts.known_outcome_case_count, falls=falls, share_overturned=fall_counts.fall_share,
        falls_with_no_earlier_fall=first_falls,
        share_of_falls_with_no_earlier_fall=first_falls / falls if falls else None,
        share_of_falls_without_other_falls=fall_counts.count_of_falls_without_other_falls / falls if falls else None,
        median_fall_time_s=fall_counts.median_fall_time_s,
    )  # fmt: skip
