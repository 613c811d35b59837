"""Extent of a study: its records, blocks and maps, the outcomes of its cells, and the sources of its records."""

from collections import Counter

import numpy as np

from overturning.findings.results import StudyResults
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.labels import earthquake_assignment_notes, unsimulated_azimuth_ranges_deg
from overturning.model.plane_weights import plane_azimuth_period_deg
from overturning.model.symmetry import PLANE_SYMMETRY_PERIOD_DEG
from overturning.statistics.by_record import record_masks_by_group
from overturning.statistics.map_choice import choose_records_for_report_maps
from overturning.statistics.opposite_azimuths import overturned_shares_by_record
from overturning.study.cube import default_height_and_friction_of_figures, element_name_to_show, record_sources
from overturning.study.scenes import variant_scene


class StudyExtentSummary(FindingBaseClass):
    """Numbers of records, earthquakes, blocks and azimuths or orientations, and properties of the motions."""

    records: int
    earthquakes: int
    earthquakes_in_several_groups: int
    """Number of earthquakes with records in more than one group, which count in each of them."""
    heights: int
    b_over_h_values: int
    """Number of values of B/H."""
    frictions: int
    blocks: int
    """Number of blocks: heights times slendernesses times frictions, times ratios of depth to width in 3-D."""
    azimuth_or_orientation_step_deg: OptionalNumberOrInfinity
    """Angle between neighbouring azimuths of the motion, or orientations of the body; None if it varies."""
    smallest_azimuth_or_orientation_deg: OptionalNumberOrInfinity = None
    """Smallest azimuth of the motion, or orientation of the body, degrees clockwise from north."""
    largest_azimuth_or_orientation_deg: OptionalNumberOrInfinity = None
    """Largest azimuth of the motion, or orientation of the body, degrees clockwise from north."""
    unsimulated_azimuth_ranges_deg: list[tuple[float, float]]
    """Ranges of azimuths, degrees, in which no plane was computed."""
    records_with_fall_axis_imposed_by_azimuths: list[str]
    """Records whose outcomes are known at azimuths spread so unevenly that they impose the axis of the falls."""
    falls_to_both_sides_are_mirror_images: bool
    """True if a fall in one plane to one side is the mirror image of a fall to the other side."""
    free_elements: int
    """Number of free elements of the scene."""
    reported_element: str
    """Name of the element whose falls are reported."""
    has_square_base: bool
    """True for a prism with a square base."""
    records_with_applied_vertical_motion: int
    """Number of records whose vertical motion was applied."""
    records_with_unused_vertical_motion: int
    """Number of records whose vertical motion the study leaves out."""
    records_without_stated_pulse: list[str]
    """Records of no group, because it is not stated whether they have a velocity pulse."""
    doubts_about_earthquake_assignment: list[str]
    """Doubts about the assignment of records to earthquakes."""
    other_amplitude_factor_count: int
    """Number of other factors under which each record was computed."""


class RecordChosenForMap(FindingBaseClass):
    """Record whose map the report shows, and the reason why it was chosen."""

    record: str
    station: str
    event: str
    reason_for_choice: str
    """Reason for the choice: "every record", "most aligned", "median", "least aligned", "clearest axis" or
    "first with falls"."""
    mean_cos_2_angle_to_fault_normal: OptionalNumberOrInfinity
    """Mean cos 2Δ of the falls under this record: 1 normal to the fault, −1 along it."""


class ReportMapSelection(FindingBaseClass):
    """Records whose polar maps the report shows, with the height, friction and smallest B/H of these maps."""

    height_m: OptionalNumberOrInfinity
    friction: OptionalNumberOrInfinity
    smallest_b_over_h: float
    records: list[RecordChosenForMap]


class CaseCountOfStatus(FindingBaseClass):
    """Number of cases with one status, such as "simulated"."""

    status: str
    case_count: int


class RecordSourceAndLicence(FindingBaseClass):
    """Source and licence of the file from which a record was read."""

    record: str
    source: str
    licence: str


def count_records_and_blocks_with_direction_range(results: StudyResults) -> StudyExtentSummary:
    """Return the numbers of records, earthquakes and blocks of a study, and the range of azimuths or orientations."""
    study, cube, model = results.study, results.reference_element_cube, results.model
    sizes = {name: int(cube.sizes[name]) for name in ("height", "b_over_h", "friction")}
    directions = cube[model.direction_dimension_name].to_numpy().astype(np.float64)
    steps = np.unique(np.diff(directions).round(9))
    groups = list(record_masks_by_group(cube).values())
    in_group = [name for members in groups for name in set(results.record_events[members].tolist())]
    neither = ~np.any(groups, axis=0)
    mirrored = not model.is_planar or plane_azimuth_period_deg(cube) == PLANE_SYMMETRY_PERIOD_DEG
    plan = study.body
    return StudyExtentSummary(
        records=len(results.record_ids_and_names),
        earthquakes=results.earthquake_count,
        earthquakes_in_several_groups=sum(number > 1 for number in Counter(in_group).values()),
        heights=sizes["height"],
        b_over_h_values=sizes["b_over_h"],
        frictions=sizes["friction"],
        blocks=sizes["height"] * sizes["b_over_h"] * sizes["friction"] * int(cube.sizes.get("aspect", 1)),
        azimuth_or_orientation_step_deg=float(steps[0]) if steps.size == 1 else float("nan"),
        smallest_azimuth_or_orientation_deg=directions.min(),
        largest_azimuth_or_orientation_deg=directions.max(),
        unsimulated_azimuth_ranges_deg=unsimulated_azimuth_ranges_deg(cube),
        records_with_fall_axis_imposed_by_azimuths=results.ids_of_records_with_fall_axis_due_to_gaps,
        falls_to_both_sides_are_mirror_images=mirrored,
        free_elements=len(variant_scene(study).free_element_names),
        reported_element=element_name_to_show(cube),
        has_square_base=plan is not None
        and plan.vertices is None
        and plan.plan == "rectangle"
        and set(plan.aspect) == {1.0},
        records_with_applied_vertical_motion=results.count_of_records_with_applied_vertical,
        records_with_unused_vertical_motion=results.count_of_records_with_unused_vertical,
        records_without_stated_pulse=[
            name.id for name, alone in zip(results.record_ids_and_names, neither, strict=True) if alone
        ],
        doubts_about_earthquake_assignment=earthquake_assignment_notes(cube),
        other_amplitude_factor_count=len(study.amplitude) - 1,
    )


def choose_fall_maps_for_report(results: StudyResults) -> ReportMapSelection:
    """Choose the records of which the report shows polar maps of falls, and the height and friction of these maps."""
    cube, means = results.reference_element_cube, results.mean_fall_directions_and_axes_by_record
    axis, length = means["mean_axis"].to_numpy(), means["axis_resultant"].to_numpy()
    normal = cube["fault_normal"].to_numpy().astype(np.float64)
    alignment = length * np.cos(np.radians(2.0 * (axis - normal)))
    block = default_height_and_friction_of_figures(cube, results.study)
    names, shares = results.record_ids_and_names, overturned_shares_by_record(cube).to_numpy()
    return ReportMapSelection(
        height_m=block["height"][0] if "height" in block else float("nan"),
        friction=block["friction"][0] if "friction" in block else float("nan"),
        smallest_b_over_h=float(cube["b_over_h"].min()),
        records=[
            RecordChosenForMap(
                record=names[place].id,
                station=names[place].station_name,
                event=names[place].earthquake_name,
                reason_for_choice=reason,
                mean_cos_2_angle_to_fault_normal=float(alignment[place]),
            )
            for place, reason in choose_records_for_report_maps(cube, alignment, length, shares)
        ],
    )


def case_counts_by_status(results: StudyResults) -> list[CaseCountOfStatus]:
    """Return the number of cases with each status, such as "simulated"; a status without cases is left out."""
    return [
        CaseCountOfStatus(status=name, case_count=count)
        for name, (count, _) in results.case_and_missing_outcome_counts_by_status.items()
        if count
    ]


def source_and_licence_of_records(results: StudyResults) -> list[RecordSourceAndLicence]:
    """Return the source and the licence of the file of each record of the study."""
    return [
        RecordSourceAndLicence(record=str(row["id"]), source=str(row["source"]), licence=str(row["licence"]))
        for row in record_sources(results.reference_element_cube)
    ]
