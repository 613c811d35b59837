"""Question and grid of a study, its case counts, its records, and the quality of the computation."""

import json
import math
from typing import Any

import numpy as np

from overturning.findings.processing import RecordProcessing, source_processing_and_notes_by_record_id
from overturning.findings.results import StudyResults
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.model.status import CaseStatus
from overturning.model.variables import mask_of_known_outcomes
from overturning.statistics.by_record import record_masks_by_group
from overturning.statistics.circular import MIN_RESULTANT_WITH_MEAN_DIRECTION, wrap_axis_difference_to_90_deg
from overturning.statistics.opposite_azimuths import (
    overturned_shares_by_record,
    overturned_shares_near_and_off_fault_normal,
)
from overturning.study.schema import Study
from overturning.units import CM, STANDARD_GRAVITY


class ScannedStoneFacts(FindingBaseClass):
    """Volume, tilt and base relief (height up to which base points bear load) of a study's scanned stone."""

    volume_m3: float
    """Volume of the stone, m³."""
    tilt_from_scan_to_stable_pose_deg: float
    """Angle between the vertical of the scan and that of the stone's nearest stable pose, degrees."""
    load_bearing_height_above_lowest_point_mm: float
    """Height above the lowest point up to which points of the base bear, mm; of the run without changes."""


class StudyQuestionAndParameters(FindingBaseClass):
    """Question of a study, its mechanical model, and the parameter values of its cases."""

    name: str
    """Name of the study."""
    title: str
    """Title; the name if the study has none."""
    question: str
    """Question of the study."""
    question_kind: str
    """Kind of question: direction, reference, survey, or a contrast such as vertical."""
    primary_statistic: str
    """Statistic that was fixed before the results were known."""
    comparison_variant_of_primary_statistic: str | None
    """Variant with which the primary statistic is compared."""
    model_kind: str
    """"planes" for vertical planes of motion, "space" for free bodies under all components."""
    free_element_names: list[str]
    """Names of the elements of the scene that can move."""
    variant_names: list[str]
    """Names of the variants."""
    height_m: list[float]
    """Heights of the blocks, m."""
    b_over_h: list[float]
    """Width-to-height ratios B/H of the blocks."""
    friction: list[float]
    """Friction coefficients."""
    azimuth_or_orientation_count: int
    """Number of azimuths of the motion (planes), or of orientations of the body (space)."""
    amplitude_factors: list[float]
    """Factors on the motion."""
    max_ensemble_members_per_case: int
    """Largest number of runs of a cell near a change of outcome."""
    applies_vertical_motion: bool
    """True if the vertical motion of at least one record is applied."""
    scan: ScannedStoneFacts | None = None
    """Scanned stone; None if the study simulates none."""


class CaseCountsAndOverturnedShares(FindingBaseClass):
    """Numbers of cases, of cases without outcome by reason, and shares of cases that overturn."""

    total_cases: int
    """Number of cases."""
    cases_not_copied_by_symmetry: int
    """Number of cases that were computed; the others are copies by symmetry."""
    cases_without_outcome_by_status: dict[str, int]
    """Number of cases without an outcome, by status."""
    cases_at_other_amplitudes: int = 0
    """Number of further cases, at other amplitude factors than 1; no other number here counts them."""
    other_amplitude_cases_without_outcome: int = 0
    """Number of these further cases without an outcome."""
    share_overturned: OptionalNumberOrInfinity
    """Share of the cases with an outcome that overturn."""
    overturned_share_in_azimuths_near_fault_normal: OptionalNumberOrInfinity
    """Share of the cases that overturn, azimuths within 45° of the fault normal; None without a fault or in space."""
    overturned_share_in_azimuths_near_fault_strike: OptionalNumberOrInfinity
    """Share of the cases that overturn, azimuths more than 45° from the fault normal."""


class RecordPeaksAndFallDirection(FindingBaseClass):
    """Peaks of one record, and mean direction and axis of the falls under it (azimuths clockwise from north)."""

    id: str
    """Identifier of the record."""
    station: str
    """Station; may be empty."""
    event: str
    """Earthquake; may be empty."""
    pulse_group: str
    """Group in which the record is counted; empty if it is not stated whether the record has a pulse."""
    has_velocity_pulse: bool | None
    """True if the record has a velocity pulse; None if it is not stated."""
    fault_normal_deg: OptionalNumberOrInfinity
    """Azimuth of the fault normal; None if it is not known."""
    pga_m_s2: OptionalNumberOrInfinity
    """Largest horizontal peak acceleration over the azimuths of the study."""
    pga_azimuth_deg: OptionalNumberOrInfinity
    """Axis of this peak, 0 to 180."""
    pga_g: OptionalNumberOrInfinity
    """The same in units of the standard acceleration of gravity."""
    pgv_m_s: OptionalNumberOrInfinity
    """Largest horizontal peak velocity over the azimuths of the study."""
    pgv_cm_s: OptionalNumberOrInfinity
    pgv_azimuth_deg: OptionalNumberOrInfinity
    """Axis of this peak, 0 to 180."""
    pgd_m: OptionalNumberOrInfinity
    """Largest horizontal peak displacement over the azimuths of the study."""
    vertical_pga_m_s2: OptionalNumberOrInfinity
    """Peak vertical acceleration; None without a vertical component."""
    displacement_drifts: bool
    """True if the integrated displacement drifts, so that `pgd_m` is not a ground displacement."""
    share_overturned: OptionalNumberOrInfinity
    """Share of the cases with an outcome that overturn."""
    too_weak_to_move_any_block: bool
    """True if the record is too weak to move any block of the study."""
    mean_fall_direction_deg: OptionalNumberOrInfinity
    """Mean fall direction; None if its resultant is too small."""
    fall_direction_resultant_length: OptionalNumberOrInfinity
    """Length of the mean of the fall directions as unit vectors, 0 to 1."""
    mean_fall_axis_deg: OptionalNumberOrInfinity
    """Mean fall axis, 0 to 180; None if its resultant is too small."""
    fall_axis_resultant: OptionalNumberOrInfinity
    """Length of the mean of the doubled fall axes as unit vectors, 0 to 1."""
    fall_axis_to_fault_normal_angle_deg: OptionalNumberOrInfinity
    """Angle between the mean fall axis and the fault normal, 0 to 90."""
    processing: RecordProcessing | None
    """Origin, processing and notes of the record; None if the cube does not state them."""


class EnergyErrorPenetrationAndSoftwareVersions(FindingBaseClass):
    """Energy error and contact penetration of the cases, hash of the results cube, and software versions."""

    mean_energy_error_share_of_input: OptionalNumberOrInfinity
    """Mean error of the energy balance over simulated cells, as a share of the input."""
    largest_energy_error_share_of_input: OptionalNumberOrInfinity
    """Largest such error."""
    largest_penetration_m: OptionalNumberOrInfinity
    """Largest penetration of a contact, m."""
    results_cube_sha256: str
    """SHA-256 hash of the content of the cube."""
    software_versions: dict[str, str]
    """Versions of the software that computed the cube."""


def study_question_and_parameters(results: StudyResults) -> StudyQuestionAndParameters:
    """Return the question of a study, its mechanical model and the parameter values of its cases."""
    study, cube = results.study, results.reference_element_cube

    def rounded_cube_coordinate_values(coordinate_name: str) -> list[float]:
        """Return the values of a coordinate of the results cube, such as the heights, rounded to 9 decimals."""
        return [round(float(one), 9) for one in cube[coordinate_name].to_numpy()]

    return StudyQuestionAndParameters(
        name=study.name,
        title=study.title or study.name,
        question=study.question,
        question_kind=study.asks,
        primary_statistic=study.primary.statistic,
        comparison_variant_of_primary_statistic=study.primary.against,
        model_kind="planes" if results.model.is_planar else "space",
        free_element_names=list(results.free_element_names),
        variant_names=list(study.variants),
        height_m=rounded_cube_coordinate_values("height"),
        b_over_h=rounded_cube_coordinate_values("b_over_h"),
        friction=rounded_cube_coordinate_values("friction"),
        azimuth_or_orientation_count=int(cube.sizes[results.model.direction_dimension_name]),
        amplitude_factors=[float(one) for one in study.amplitude],
        max_ensemble_members_per_case=study.ensemble.members,
        applies_vertical_motion=bool(results.count_of_records_with_applied_vertical),
        scan=scanned_stone_volume_tilt_and_relief(study),
    )


def scanned_stone_volume_tilt_and_relief(study: Study) -> ScannedStoneFacts | None:
    """Return volume, tilt and relief of a study's scanned stone; None if it has none.

    The relief is the height above the lowest point of the base up to which its points bear load.
    """
    body = study.body
    if body is None or body.scan is None or body.relief is None:
        return None
    return ScannedStoneFacts(
        volume_m3=body.scan.volume,
        tilt_from_scan_to_stable_pose_deg=body.scan.tilt,
        load_bearing_height_above_lowest_point_mm=round(1000.0 * body.relief, 6),
    )


def case_counts_and_overturned_shares(results: StudyResults) -> CaseCountsAndOverturnedShares:
    """Count the cases of a study, and those without an outcome; compute the shares that overturn.

    The shares are of all cases with a known outcome, and (2-D) of those at azimuths within and beyond 45° of the fault
    normal.
    """
    within, beyond = overturned_shares_near_and_off_fault_normal(results.reference_element_cube)
    scaled = None if results.other_amplitudes_cube is None else results.other_amplitudes_cube["overturned"]
    return CaseCountsAndOverturnedShares(
        total_cases=int(results.reference_element_cube["overturned"].size),
        cases_not_copied_by_symmetry=int(
            (results.reference_element_cube[results.model.symmetry_copy_flag_variable_name] == 0).sum().compute()
        ),
        cases_without_outcome_by_status={
            name: count for name, (_, count) in results.case_and_missing_outcome_counts_by_status.items() if count
        },
        cases_at_other_amplitudes=0 if scaled is None else int(scaled.size),
        other_amplitude_cases_without_outcome=0
        if scaled is None
        else int((~mask_of_known_outcomes(scaled)).sum().compute()),
        share_overturned=results.share_overturned,
        overturned_share_in_azimuths_near_fault_normal=within,
        overturned_share_in_azimuths_near_fault_strike=beyond,
    )


def peaks_and_fall_directions_of_records(results: StudyResults) -> list[RecordPeaksAndFallDirection]:
    """Return, for each record, its names, peaks and processing, and mean direction and axis of the falls under it."""
    cube, intensity, found = (
        results.reference_element_cube,
        results.intensity_measures,
        results.mean_fall_directions_and_axes_by_record,
    )
    azimuth, processing = intensity["azimuth"].to_numpy(), source_processing_and_notes_by_record_id(results)
    shares, groups = overturned_shares_by_record(cube).to_numpy(), record_masks_by_group(cube)
    at_rest = cube["status"] == CaseStatus.AT_REST
    still = at_rest.all([name for name in at_rest.dims if name != "record"]).compute().to_numpy()
    normals = cube["fault_normal"].to_numpy().astype(np.float64)
    angles = {kind: found[f"mean_{kind}"].to_numpy() for kind in ("direction", "axis")}
    lengths = {kind: found[f"{kind}_resultant"].to_numpy() for kind in ("direction", "axis")}
    records = []
    for index, name in enumerate(results.record_ids_and_names):
        peaks: dict[str, Any] = {}
        for measure, unit in (("pga", "m_s2"), ("pgv", "m_s"), ("pgd", "m")):
            along = intensity[measure].isel(record=index).to_numpy()
            peaks[f"{measure}_{unit}"] = float(along.max())
            if measure != "pgd":
                peaks[f"{measure}_azimuth_deg"] = float(azimuth[int(along.argmax())] % 180)
        peaks |= {"pga_g": peaks["pga_m_s2"] / STANDARD_GRAVITY, "pgv_cm_s": peaks["pgv_m_s"] / CM}
        clear = {kind: lengths[kind][index] >= MIN_RESULTANT_WITH_MEAN_DIRECTION for kind in lengths}
        mean = {kind: float(angles[kind][index]) if clear[kind] else math.nan for kind in angles}
        pulse = float(cube["pulse"].to_numpy()[index])
        records.append(
            RecordPeaksAndFallDirection(
                id=name.id,
                station=name.station_name,
                event=name.earthquake_name,
                pulse_group=next((group for group, members in groups.items() if members[index]), ""),
                has_velocity_pulse=None if math.isnan(pulse) else pulse == 1.0,
                fault_normal_deg=normals[index],
                **peaks,
                vertical_pga_m_s2=float(intensity["pga_vertical"].to_numpy()[index]),
                displacement_drifts=name.id in processing and bool(processing[name.id].drift_evidence),
                share_overturned=float(shares[index]),
                too_weak_to_move_any_block=bool(still[index]),
                mean_fall_direction_deg=mean["direction"],
                fall_direction_resultant_length=float(lengths["direction"][index]),
                mean_fall_axis_deg=mean["axis"],
                fall_axis_resultant=float(lengths["axis"][index]),
                fall_axis_to_fault_normal_angle_deg=float(
                    np.abs(wrap_axis_difference_to_90_deg(mean["axis"] - normals[index]))
                ),
                processing=processing.get(name.id),
            )
        )
    return records


def numerical_errors_and_software_versions(results: StudyResults) -> EnergyErrorPenetrationAndSoftwareVersions:
    """Return energy error (share of the input) and penetration (m) of the cases, cube hash and software versions."""
    cube = results.reference_element_cube
    simulated = cube["status"] == CaseStatus.SIMULATED
    energy, depth = (cube[name].where(simulated) for name in ("energy_error", "peak_penetration"))
    return EnergyErrorPenetrationAndSoftwareVersions(
        mean_energy_error_share_of_input=float(energy.mean().compute()),
        largest_energy_error_share_of_input=float(energy.max().compute()),
        largest_penetration_m=float(depth.max().compute()),
        results_cube_sha256=cube.attrs["content_sha256"],
        software_versions=json.loads(cube.attrs["versions"]),
    )
