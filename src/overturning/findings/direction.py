"""Direction of falls relative to the fault normal, and relative to peaks of the motion."""

import math

import numpy as np

from overturning.findings.results import Results
from overturning.findings.values import Estimate, Finding, Number, estimate
from overturning.statistics.alignment_by_rule import RuleAlignment
from overturning.statistics.bootstrap import mean_over_earthquakes
from overturning.statistics.by_record import record_groups
from overturning.statistics.falls import flag_changes_between_neighbours, rule_of
from overturning.statistics.space import plane_agreement

ALIGNMENT = "mean of cos 2Δ, Δ the angle from the fault normal to a fall: 1 normal to the fault, −1 along it"


class EarthquakeAxis(Finding):
    """Falls of an earthquake relative to its fault normal."""

    event: str
    alignment: Number
    """Mean of cos 2Δ; None without falls or fault normal."""
    resultant: Number
    axis_from_normal_deg: Number
    """Axis of the falls relative to the fault normal, (−90, 90]; None if the resultant is too small."""


class AlignmentUnderRule(Finding):
    """Alignment under one rule that selects the blocks whose falls count."""

    rule: str
    used: bool
    """True for the rule of the study, which was fixed before the results were known."""
    records: int
    alignment: Estimate
    largest_possible: Number


class GroupDirection(Finding):
    """Direction of the falls of a group of records."""

    group: str
    earthquakes: int
    alignment: Estimate
    largest_possible: Number
    """Alignment if the mean axis of every record were its fault normal."""
    axis_from_normal_deg: Number
    """Mean axis relative to the fault normal; None if a test does not reject "no common axis" at 5 %."""
    axis_half_width_deg: Number
    """Half of the 95 % interval of the axis."""
    no_common_axis_p: Number
    """p-value of the test of "no common axis"."""
    earthquakes_with_axis: int
    closer_to_normal: int
    """Number of these earthquakes whose axis lies within 45° of the fault normal."""
    agreement_within_record: Estimate
    by_earthquake: list[EarthquakeAxis]
    by_rule: list[AlignmentUnderRule]


class Direction(Finding):
    """Direction of falls relative to the fault normal."""

    shows_axis: bool
    """False if the falls have no axis that can be compared with a fault."""
    groups: list[GroupDirection]
    difference: Estimate | None
    """Alignment of the first group minus that of the second; None if there is one group."""
    changes_between_neighbours: dict[str, Number]
    """Share of neighbouring cells with different outcomes, by dimension."""


class ReferenceMean(Finding):
    """Alignment of falls with a reference."""

    reference: str
    kind: str
    """"axis" (1 along the reference, −1 across) or "direction" (1 towards its head, −1 away from it)."""
    all_b_over_h: Estimate
    by_range: dict[str, Estimate]
    """The same for ranges of B/H."""


class GroupReferences(Finding):
    """Alignment of the falls of a group of records with references."""

    group: str
    references: list[ReferenceMean]
    closest: list[str]
    """The two references with the largest alignment of axes; shorter if fewer are known."""
    closest_minus_next: Estimate | None


class PlaneAgreement(Finding):
    """Agreement of the 2-D model of the faces of a body with its 3-D outcome."""

    cases: int
    flag: Number
    """Share of cases in which the 2-D model predicts correctly whether the stone falls."""
    flag_near_boundary: Number
    """The same for cases whose neighbour in B/H has another outcome."""
    only_space: Number
    only_planes: Number
    edge: Number
    """Share of the falls in both models that go over the edge that the 2-D model predicts."""
    axes_apart_deg: Number


def _under_rule(one: RuleAlignment, direction: str, used: bool) -> AlignmentUnderRule:
    return AlignmentUnderRule(
        rule=one.rule.name.format(direction),
        used=used,
        records=one.records,
        alignment=estimate(one.alignment, ALIGNMENT),
        largest_possible=one.largest,
    )


def direction_of(results: Results) -> Direction:
    """Compute the direction of falls relative to the fault normal, by group of records."""
    cube, groups = results.cube, []
    lengths, own = results.record_means["axis_resultant"].to_numpy(), rule_of(cube)
    members, word = record_groups(cube), "plane" if results.model.one_component else results.model.direction
    for name, summary in results.axes.items():
        axes = results.axes_by_group[name]
        rows = zip(*(axes[key].to_numpy() for key in ("event", "cosine", "resultant", "axis")), strict=True)
        agreement = mean_over_earthquakes(np.where(members[name], lengths, np.nan), results.events)
        groups.append(
            GroupDirection(
                group=name,
                earthquakes=summary.earthquakes,
                alignment=estimate(summary.alignment, ALIGNMENT),
                largest_possible=summary.largest,
                axis_from_normal_deg=summary.axis_deg,
                axis_half_width_deg=summary.half_width_deg,
                no_common_axis_p=summary.axis_p_value,
                earthquakes_with_axis=summary.with_axis,
                closer_to_normal=summary.closer_to_normal,
                agreement_within_record=estimate(agreement, "resultant of the doubled fall axes of one record"),
                by_earthquake=[
                    EarthquakeAxis(event=str(event), alignment=mean, resultant=length, axis_from_normal_deg=axis)
                    for event, mean, length, axis in rows
                ],
                by_rule=[_under_rule(one, word, one.rule is own) for one in results.alignment_by_rule.get(name, [])],
            )
        )
    changes = dict[str, Number]()
    for dim in (results.model.direction, "b_over_h"):
        changed, pairs = flag_changes_between_neighbours(cube, dim)
        changes[dim] = changed / pairs if pairs else None
    difference = results.axes_difference
    return Direction(
        shows_axis=results.tells_axes,
        groups=groups,
        difference=estimate(difference, f"difference of {ALIGNMENT}") if difference and difference.n else None,
        changes_between_neighbours=changes,
    )


def references_of(results: Results) -> list[GroupReferences]:
    """Compute the alignment of 3-D falls with references; empty for planar models and without falls."""
    if results.model.one_component or not results.fallen > 0:
        return []
    found, ranges = results.followed
    groups = []
    for group, references in found.items():
        means = []
        for (name, axial), (whole, *each) in references.means.items():
            kind, of = ("axis", "mean of cos 2Δ") if axial else ("direction", "mean of cos Δ")
            text = f"{of}, Δ the angle from the {name} to a fall"
            by_range = {label: estimate(one, text) for label, one in zip(ranges, each, strict=True)}
            means.append(
                ReferenceMean(reference=name, kind=kind, all_b_over_h=estimate(whole, text), by_range=by_range)
            )
        closer = references.closer[:1]
        groups.append(
            GroupReferences(
                group=group,
                references=means,
                closest=list(references.closest),
                closest_minus_next=estimate(closer[0], "difference of the means of cos 2Δ") if closer else None,
            )
        )
    return groups


def planes_of(results: Results) -> PlaneAgreement | None:
    """Compute the agreement of the 2-D model of the faces with the 3-D outcome; None without 2-D outcomes."""
    if "plane_overturned" not in results.cube:
        return None
    whole = {str(name): float(one) for name, one in plane_agreement(results.plane_counts).items()}
    return PlaneAgreement(
        cases=0 if math.isnan(whole["cases"]) else int(whole["cases"]),
        flag=whole["flag"],
        flag_near_boundary=whole["flag_beside"],
        only_space=whole["only_space"],
        only_planes=whole["only_plane"],
        edge=whole["face"],
        axes_apart_deg=whole["axis"],
    )
