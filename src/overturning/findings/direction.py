"""Direction of falls relative to the fault normal, and relative to peaks of the motion."""

import math

import numpy as np
from pydantic import Field

from overturning.arrays import FloatArray
from overturning.findings.results import StudyResults
from overturning.findings.values import Estimate, FindingBaseClass, OptionalNumberOrInfinity, estimate_from_mean
from overturning.model.symmetry import PLANE_SYMMETRY_PERIOD_DEG
from overturning.statistics.alignment_by_rule import FaultNormalAlignmentOfSelectedBlocks
from overturning.statistics.bootstrap import mean_over_earthquakes
from overturning.statistics.by_record import record_masks_by_group
from overturning.statistics.falls import block_selection_rule_for_cube
from overturning.statistics.opposite_azimuths import count_differing_and_all_neighbour_pairs, overturning_indicator
from overturning.statistics.space import shares_of_agreeing_2d_and_3d_outcomes

ALIGNMENT_DESCRIPTION = (
    "mean of cos 2Δ, Δ the angle from the fault normal to a fall: 1 normal to the fault, −1 along it"
)


class EarthquakeFallAxis(FindingBaseClass):
    """Mean axis of the falls in one earthquake, and the alignment of the falls with the fault normal."""

    event: str
    """Name of the earthquake."""
    mean_cos_2_angle_to_fault_normal: OptionalNumberOrInfinity
    """Mean of cos 2Δ; None without falls or fault normal."""
    fall_axis_resultant_length: OptionalNumberOrInfinity
    """Length of the mean of the doubled fall axes: 0 for axes in all directions, 1 for one axis."""
    fall_axis_from_fault_normal_deg: OptionalNumberOrInfinity
    """Axis of the falls relative to the fault normal, (−90, 90]; None if the resultant is too small."""


class BlockSelectionFaultNormalAlignment(FindingBaseClass):
    """Alignment of falls with the fault normal, over those blocks that one selection rule includes."""

    rule: str
    """Rule that selects the blocks."""
    is_study_rule: bool
    """True for the rule that the study uses; it was fixed before the results were known."""
    records_with_counted_falls: int
    """Number of records with falls that count."""
    mean_cos_2_angle_to_fault_normal: Estimate
    """Mean of cos 2Δ over earthquakes, Δ the angle from the fault normal to a fall."""
    largest_possible_alignment: OptionalNumberOrInfinity
    """Alignment if the mean axis of every record were its fault normal."""


class RecordGroupFallAxisAndAlignment(FindingBaseClass):
    """Mean axis of the falls in a group of records, and their alignment with the fault normal."""

    record_group: str
    """Name of the group of records."""
    earthquake_count: int
    """Number of earthquakes with records in the group; those with an alignment are counted there."""
    mean_cos_2_angle_to_fault_normal: Estimate
    """Mean of cos 2Δ over earthquakes, Δ the angle from the fault normal to a fall."""
    largest_possible_alignment: OptionalNumberOrInfinity
    """Alignment if the mean axis of every record were its fault normal."""
    fall_axis_from_fault_normal_deg: OptionalNumberOrInfinity
    """Mean axis relative to the fault normal; None if a test does not reject "no common axis" at 5 %."""
    axis_interval_half_width_deg: OptionalNumberOrInfinity
    """Half of the 95 % interval of the axis."""
    no_common_axis_p_value: OptionalNumberOrInfinity
    """p-value of the test of "no common axis"."""
    earthquakes_with_axis: int
    """Number of earthquakes whose falls have an axis (large enough resultant)."""
    fall_axes_within_45_deg_of_fault_normal: int
    """Number of `earthquakes_with_axis` whose axis lies within 45° of the fault normal."""
    mean_axis_resultant_length_within_records: Estimate
    """Resultant of the doubled fall axes of one record, mean over earthquakes."""
    by_earthquake: list[EarthquakeFallAxis]
    """Falls of each earthquake relative to its fault normal."""
    by_rule: list[BlockSelectionFaultNormalAlignment]
    """Alignment under each rule that selects blocks."""
    smallest_alignment_over_block_selections: OptionalNumberOrInfinity
    """Smallest alignment under the rules of `by_rule`."""
    largest_alignment_over_block_selections: OptionalNumberOrInfinity
    selection_rules_with_interval: int
    """Number of these rules with an interval, and how many of the intervals exclude 0."""
    selection_rules_with_interval_excluding_zero: int


class FallDirectionRelativeToFaultNormal(FindingBaseClass):
    """Direction of the falls of a study relative to the fault normal, by group of records."""

    has_fall_axis_comparable_with_fault: bool
    """False if the falls have no axis that can be compared with a fault."""
    reason_for_no_axis_comparable_with_fault: str
    """Reason why not: "no outcome", "no falls", "one plane", "uneven planes", "falls in every plane", "unknown
    outcomes", "every direction or none" or "no fault normal"; empty if they have one."""
    groups: list[RecordGroupFallAxisAndAlignment]
    """Direction of the falls of each group of records."""
    first_minus_second_group_alignment: Estimate | None
    """Alignment of the first group minus that of the second; None if there is one group."""
    neighbour_outcome_change_share_by_dimension: dict[str, OptionalNumberOrInfinity]
    """Share of neighbouring cells with different outcomes, by dimension."""
    overturned_shares_by_plane_azimuth: list["OverturnedShareInVerticalPlane"] = Field(default_factory=list)
    """Share of the cases that overturn in each plane; empty unless the planes are spread unevenly over the circle."""


class OverturnedShareInVerticalPlane(FindingBaseClass):
    """Share of the cases that overturn in one vertical plane, over all records and blocks."""

    azimuth_deg: float
    """Azimuth of the plane, degrees, 0 to 180."""
    share_overturned: OptionalNumberOrInfinity
    """Share of the cases with an outcome that overturn."""


class AlignmentWithReference(FindingBaseClass):
    """Alignment of falls with one reference direction, such as the azimuth of peak velocity."""

    reference: str
    """Name of the reference direction, such as the fault normal."""
    axis_or_direction: str
    """"axis" (1 along the reference, −1 across) or "direction" (1 towards its head, −1 away from it)."""
    alignment_over_all_b_over_h: Estimate
    """Alignment over all B/H."""
    by_b_over_h_range: dict[str, Estimate]
    """Alignment for ranges of B/H."""


class RecordGroupReferenceAlignment(FindingBaseClass):
    """Alignment of the falls in a group of records with each of several reference directions."""

    record_group: str
    """Name of the group of records."""
    references: list[AlignmentWithReference]
    """Alignment with each reference."""
    best_aligned_references: list[str]
    """The two references with the largest alignment of axes; shorter if fewer are known."""
    best_minus_second_alignment: Estimate | None
    """Difference of the alignments of these two; None if there is one reference."""
    alignment_with_best_reference_axis: Estimate | None
    """Alignment with the axis of the closest reference, all B/H together."""
    alignment_with_fault_normal: Estimate | None
    """Alignment with the fault normal; None if no fault normal is known."""
    b_over_h_range_count_with_alignment_interval: int
    """Number of ranges of B/H in which the alignment with the head of the closest reference has an interval."""
    count_of_alignment_intervals_excluding_zero: int
    """Number of these intervals that exclude 0."""


class PlanarModelAgreement(FindingBaseClass):
    """Shares of cases in which the 2-D and the 3-D model have the same outcome.

    The 2-D model is computed in the two vertical planes that are normal to the side faces of the body.
    """

    compared_case_count: int
    """Number of cases with both outcomes."""
    same_outcome_share: OptionalNumberOrInfinity
    """Share of cases in which the 2-D model predicts correctly whether the stone falls."""
    same_outcome_share_if_b_over_h_neighbour_differs: OptionalNumberOrInfinity
    """Value of `same_outcome_share` for cases whose neighbour in B/H has another outcome."""
    only_3d_overturns_share: OptionalNumberOrInfinity
    """Share of the cases that overturn in the 3-D model only."""
    only_2d_overturns_share: OptionalNumberOrInfinity
    """Share of the cases that overturn in the 2-D model only."""
    same_fall_edge_share: OptionalNumberOrInfinity
    """Share of the falls in both models that go over the edge that the 2-D model predicts."""
    mean_angle_between_fall_axes_deg: OptionalNumberOrInfinity
    """Mean angle between the fall axes of the two models, 0 to 90."""


def _alignment_finding_of_block_selection(
    rule_alignment: FaultNormalAlignmentOfSelectedBlocks, simulated_direction_noun: str, is_rule_used_by_study: bool
) -> BlockSelectionFaultNormalAlignment:
    """Return the mean cos 2Δ of falls over the blocks that one rule selects, Δ the angle from fault normal to fall.

    `simulated_direction_noun`, such as "plane", completes the name of the rule.
    """
    return BlockSelectionFaultNormalAlignment(
        rule=rule_alignment.rule.description_template.format(simulated_direction_noun),
        is_study_rule=is_rule_used_by_study,
        records_with_counted_falls=rule_alignment.records_with_falls_and_fault_normal,
        mean_cos_2_angle_to_fault_normal=estimate_from_mean(
            rule_alignment.mean_cos_of_doubled_angle, ALIGNMENT_DESCRIPTION
        ),
        largest_possible_alignment=rule_alignment.mean_resultant_length_of_doubled_fall_axes,
    )


def _reason_for_no_comparable_fall_axis(results: StudyResults) -> str:
    """Return the reason why falls have no axis to compare with a fault, such as "no falls"; "" if they have one."""
    if math.isnan(results.share_overturned):
        return "no outcome"
    if results.share_overturned <= 0:
        return "no falls"
    if results.simulated_azimuths_impose_fall_axis:
        return "uneven planes" if np.unique(_plane_azimuths_modulo_180_deg(results)).size > 1 else "one plane"
    if results.is_2d_and_every_case_overturns:
        return "falls in every plane"
    imposed = bool(results.ids_of_records_with_fall_axis_due_to_gaps)
    if not results.any_record_has_fall_axis:
        return "unknown outcomes" if imposed else "every direction or none"
    if results.has_falls_with_known_fault_normal:
        return ""
    return "unknown outcomes" if imposed and results.any_fault_normal_is_stated else "no fault normal"


def _plane_azimuths_modulo_180_deg(results: StudyResults) -> FloatArray:
    """Return the azimuth modulo 180°, degrees, of each simulated vertical plane of a 2-D study."""
    return np.asarray(
        results.reference_element_cube["azimuth"].to_numpy().astype(np.float64) % PLANE_SYMMETRY_PERIOD_DEG
    )


def _overturned_share_by_plane(results: StudyResults) -> list[OverturnedShareInVerticalPlane]:
    """Return, for each vertical plane of a 2-D study, the share of its cases that overturn."""
    falls, planes = overturning_indicator(results.reference_element_cube), _plane_azimuths_modulo_180_deg(results)
    others = [name for name in falls.dims if name != "azimuth"]
    fallen, known = (part.sum(others).compute().to_numpy() for part in (falls, falls.notnull()))
    shares = []
    for plane in np.unique(planes):
        own = planes == plane
        share = float(fallen[own].sum() / known[own].sum()) if known[own].any() else math.nan
        shares.append(OverturnedShareInVerticalPlane(azimuth_deg=float(plane), share_overturned=share))
    return shares


def fall_direction_findings(results: StudyResults) -> FallDirectionRelativeToFaultNormal:
    """Compute, by group of records, the fall axis relative to the fault normal, and the mean cos 2Δ of the falls.

    Δ is the angle from the fault normal to a fall.
    """
    cube, groups = results.reference_element_cube, []
    lengths, own = (
        results.mean_fall_directions_and_axes_by_record["axis_resultant"].to_numpy(),
        block_selection_rule_for_cube(cube),
    )
    members, word = (
        record_masks_by_group(cube),
        "plane" if results.model.is_planar else results.model.direction_dimension_name,
    )
    for name, summary in results.fall_axis_to_fault_normal_summary_by_record_group.items():
        axes = results.fall_axes_from_fault_normal_by_record_group[name]
        rows = zip(*(axes[key].to_numpy() for key in ("event", "cosine", "resultant", "axis")), strict=True)
        agreement = mean_over_earthquakes(np.where(members[name], lengths, np.nan), results.record_events)
        rules = [
            _alignment_finding_of_block_selection(one, word, one.rule is own)
            for one in results.fault_normal_alignments_by_record_group.get(name, [])
        ]
        known = [
            one.mean_cos_2_angle_to_fault_normal.value
            for one in rules
            if one.mean_cos_2_angle_to_fault_normal.value is not None
        ]
        groups.append(
            RecordGroupFallAxisAndAlignment(
                record_group=name,
                earthquake_count=summary.earthquake_count,
                mean_cos_2_angle_to_fault_normal=estimate_from_mean(
                    summary.mean_cos_of_doubled_angle_to_fault_normal, ALIGNMENT_DESCRIPTION
                ),
                largest_possible_alignment=summary.mean_resultant_length_of_doubled_fall_axes,
                fall_axis_from_fault_normal_deg=summary.mean_axis_from_fault_normal_deg,
                axis_interval_half_width_deg=summary.mean_axis_interval_half_width_deg,
                no_common_axis_p_value=summary.p_value_of_no_common_axis,
                earthquakes_with_axis=summary.earthquakes_with_axis,
                fall_axes_within_45_deg_of_fault_normal=summary.earthquakes_with_axis_within_45_deg_of_normal,
                mean_axis_resultant_length_within_records=estimate_from_mean(
                    agreement, "resultant of the doubled fall axes of one record"
                ),
                by_earthquake=[
                    EarthquakeFallAxis(
                        event=str(event),
                        mean_cos_2_angle_to_fault_normal=mean,
                        fall_axis_resultant_length=length,
                        fall_axis_from_fault_normal_deg=axis,
                    )
                    for event, mean, length, axis in rows
                ],
                by_rule=rules,
                smallest_alignment_over_block_selections=min(known, default=math.nan),
                largest_alignment_over_block_selections=max(known, default=math.nan),
                selection_rules_with_interval=sum(
                    one.mean_cos_2_angle_to_fault_normal.low is not None for one in rules
                ),
                selection_rules_with_interval_excluding_zero=sum(
                    one.mean_cos_2_angle_to_fault_normal.excludes_zero for one in rules
                ),
            )
        )
    changes = dict[str, OptionalNumberOrInfinity]()
    for dim in (results.model.direction_dimension_name, "b_over_h"):
        changed, pairs = count_differing_and_all_neighbour_pairs(cube, dim)
        changes[dim] = changed / pairs if pairs else None
    difference, reason = results.first_minus_second_record_group_alignment, _reason_for_no_comparable_fall_axis(results)
    return FallDirectionRelativeToFaultNormal(
        has_fall_axis_comparable_with_fault=results.has_fall_axis_comparable_with_fault_normal,
        reason_for_no_axis_comparable_with_fault=reason,
        groups=groups,
        first_minus_second_group_alignment=estimate_from_mean(difference, f"difference of {ALIGNMENT_DESCRIPTION}")
        if difference and difference.earthquake_count
        else None,
        neighbour_outcome_change_share_by_dimension=changes,
        overturned_shares_by_plane_azimuth=_overturned_share_by_plane(results) if reason == "uneven planes" else [],
    )


def fall_alignments_with_references(results: StudyResults) -> list[RecordGroupReferenceAlignment]:
    """Compute the alignment of falls with reference directions of the motion, for each group of records.

    A reference is the fault normal or an azimuth such as that of the peak velocity. The alignment is the mean of
    cos Δ (direction) or cos 2Δ (axis), Δ the angle from the reference to a fall, over earthquakes. Empty for planar
    models, and without falls.
    """
    if results.model.is_planar or not results.share_overturned > 0:
        return []
    found, ranges = results.fall_alignments_by_group_and_b_over_h_labels
    groups = []
    for group, references in found.items():
        means = []
        for (name, axial), (whole, *each) in references.cosines_per_b_over_h_by_reference_and_axial.items():
            kind, of = ("axis", "mean of cos 2Δ") if axial else ("direction", "mean of cos Δ")
            text = f"{of}, Δ the angle from the {name} to a fall"
            by_b_over_h_range = {label: estimate_from_mean(one, text) for label, one in zip(ranges, each, strict=True)}
            means.append(
                AlignmentWithReference(
                    reference=name,
                    axis_or_direction=kind,
                    alignment_over_all_b_over_h=estimate_from_mean(whole, text),
                    by_b_over_h_range=by_b_over_h_range,
                )
            )
        closer, axes = (
            references.best_minus_second_axis_cosines_per_b_over_h[:1],
            {one.reference: one for one in means if one.axis_or_direction == "axis"},
        )
        ends = [
            one
            for one in means
            if one.axis_or_direction == "direction" and one.reference in references.two_best_aligned_reference_names[:1]
        ]
        heads = [one for each in ends for one in each.by_b_over_h_range.values() if one.low is not None]
        groups.append(
            RecordGroupReferenceAlignment(
                record_group=group,
                references=means,
                best_aligned_references=list(references.two_best_aligned_reference_names),
                best_minus_second_alignment=estimate_from_mean(closer[0], "difference of the means of cos 2Δ")
                if closer
                else None,
                alignment_with_best_reference_axis=axes[
                    references.two_best_aligned_reference_names[0]
                ].alignment_over_all_b_over_h
                if references.two_best_aligned_reference_names
                else None,
                alignment_with_fault_normal=axes["fault normal"].alignment_over_all_b_over_h
                if "fault normal" in axes
                else None,
                b_over_h_range_count_with_alignment_interval=len(heads),
                count_of_alignment_intervals_excluding_zero=sum(one.excludes_zero for one in heads),
            )
        )
    return groups


def planar_model_agreement(results: StudyResults) -> PlanarModelAgreement | None:
    """Return the shares of cases in which 2-D simulations of a body give the outcome of the 3-D model.

    The 2-D simulations are those in the vertical planes normal to the side faces of the body; None if there are none.
    """
    if "plane_overturned" not in results.reference_element_cube:
        return None
    whole = {
        str(name): float(one)
        for name, one in shares_of_agreeing_2d_and_3d_outcomes(results.agreement_counts_of_2d_and_3d_outcomes).items()
    }
    return PlanarModelAgreement(
        compared_case_count=0 if math.isnan(whole["cases"]) else int(whole["cases"]),
        same_outcome_share=whole["flag"],
        same_outcome_share_if_b_over_h_neighbour_differs=whole["flag_beside"],
        only_3d_overturns_share=whole["only_space"],
        only_2d_overturns_share=whole["only_plane"],
        same_fall_edge_share=whole["face"],
        mean_angle_between_fall_axes_deg=whole["axis"],
    )
