"""Findings of each kind of study, written by hand: no cube, no computation."""

from typing import Any

from overturning.findings.collect import Findings
from overturning.surveys.stones import OCTANTS

SHARE_OF_CHANGED_CASES = {"changed_count": 3, "compared_count": 400, "value": 0.0075, "low": 0.0025, "high": 0.0218}


def estimate_entry(
    value: float | None, low: float | None = None, high: float | None = None, n: int = 12
) -> dict[str, Any]:
    """Return an estimate (value, interval, number of earthquakes) in the form in which findings store it."""
    return {"statistic": "by hand", "value": value, "low": low, "high": high, "earthquake_count": n}


def fall_axis_findings_of_group(name: str, alignment: dict[str, Any]) -> dict[str, Any]:
    """Return findings on the fall axes of one group of records, with the given estimate of the alignment."""
    rule = {
        "records_with_counted_falls": 14,
        "mean_cos_2_angle_to_fault_normal": alignment,
        "largest_possible_alignment": 0.71,
    }
    return {
        "record_group": name,
        "earthquake_count": 12,
        "mean_cos_2_angle_to_fault_normal": alignment,
        "largest_possible_alignment": 0.71,
        "fall_axis_from_fault_normal_deg": None,
        "axis_interval_half_width_deg": None,
        "no_common_axis_p_value": 0.31,
        "earthquakes_with_axis": 12,
        "fall_axes_within_45_deg_of_fault_normal": 9,
        "mean_axis_resultant_length_within_records": estimate_entry(0.73, 0.66, 0.79),
        "by_earthquake": [
            {"event": "Upper Vale", "mean_cos_2_angle_to_fault_normal": 0.52, "fall_axis_resultant_length": 0.62,
            "fall_axis_from_fault_normal_deg": 17.0},
            {"event": "Lower Vale", "mean_cos_2_angle_to_fault_normal": -0.37, "fall_axis_resultant_length": 0.42,
            "fall_axis_from_fault_normal_deg": 61.0},
        ],
        "by_rule": [rule | {"rule": "in some planes", "is_study_rule": True},
                    rule | {"rule": "in all planes", "is_study_rule": False}],
        "smallest_alignment_over_block_selections": 0.06,
        "largest_alignment_over_block_selections": 0.24,
        "selection_rules_with_interval": 5,
        "selection_rules_with_interval_excluding_zero": 1,
    }  # fmt: skip


def variant_comparison_findings(**changes: Any) -> dict[str, Any]:
    """Return findings that compare a study with its variant; ``changes`` replace entries."""
    parts = {
        "variant": "other", "is_primary_comparison": True, "scene_name_of_study": "stack",
        "scene_name_of_variant": "monolith",
        "differing_settings": ["scene"],
        "compared_element_in_study": "stone", "compared_element_in_variant": "stone",
        "soil_thickness_of_variant_m": None,
        "compared_record_count": 14, "cases_not_compared": 23, "share_overturned_in_study": estimate_entry(0.384, 0.203,
        0.557),
        "share_overturned_in_variant": estimate_entry(0.116, 0.042, 0.263),
        "study_minus_variant_share": estimate_entry(0.268,
        0.137, 0.391),
        "share_overturned_only_in_study": estimate_entry(0.271, 0.142, 0.401),
        "share_overturned_only_in_variant": estimate_entry(0.013,
        0.004, 0.029),
        "share_overturned_in_both": estimate_entry(0.109, 0.037, 0.247),
        "share_within_45_deg_of_each_other_if_both_fall": estimate_entry(0.86,
        0.74, 0.92),
        "share_study_stone_falls_first_if_either_falls": estimate_entry(0.81, 0.7, 0.9),
        "share_over_45_deg_apart_if_both_fall": 0.14,
        "share_falling_first_in_study_if_both_fall": estimate_entry(0.57, 0.48, 0.69),
        "share_falling_simultaneously_if_both_fall": estimate_entry(0.0,
        0.0, 0.22),
        "overturned_shares_by_b_over_h": [], "population_fall_rate_in_study": None,
        "population_fall_rate_in_variant": None,
        "primary_statistic_study_minus_variant": estimate_entry(0.268, 0.137, 0.391),
    }  # fmt: skip
    return parts | changes


CLIPPED_COMPONENT_NOTE = (
    "vale.csv: axis 'north' is clipped: 37 samples stand at its rail, 981.2 Gal; the ground moved more than that"
)

RECORD_PROCESSING: dict[str, Any] = {
    "data_processing_state": "processed", "processing_agency": "PEER", "agency_processing": "band-pass filter 0.13 to "
    "24.5 Hz",
    "steps": ["high-pass 0.17 Hz, order 4"], "first_sample_time": "2016-11-13T11:02:14.715Z", "duration_s": 38.4,
    "pga_before_m_s2": 5.41, "pga_after_m_s2": 5.29, "pgv_before_m_s": 0.87, "pgv_after_m_s": 0.83,
    "pgd_before_m": 0.36, "pgd_after_m": 0.33, "user_declared_properties": ["columns time:s north:m/s2 east:m/s2"],
    "contradictions_trusted_by_user": ["vale.csv: axis 'north' has peak 983.3 Gal, the header states 979.6 Gal"],
    "notes": [CLIPPED_COMPONENT_NOTE, "vale.csv: the vertical component of unknown sense is left out"],
    "drift_evidence": "velocity of north ends at 7 % of its peak",
    "doubts": ["clipped samples", "a velocity or displacement that drifts", "contradictions that were trusted"],
}  # fmt: skip

RECORD_FINDING: dict[str, Any] = {
    "id": "vale", "station": "Vale", "event": "Upper Vale", "pulse_group": "with a velocity pulse",
    "has_velocity_pulse": True,
    "fault_normal_deg": 54.0, "pga_m_s2": 5.3, "pga_azimuth_deg": 110.0, "pga_g": 0.54, "pgv_m_s": 0.83,
    "pgv_cm_s": 83.0, "pgv_azimuth_deg": 72.0, "pgd_m": 0.33, "vertical_pga_m_s2": None, "displacement_drifts": True,
    "share_overturned": 0.293, "too_weak_to_move_any_block": False, "mean_fall_direction_deg": 228.0,
    "fall_direction_resultant_length": 0.39, "mean_fall_axis_deg": 63.0, "fall_axis_resultant": 0.68,
    "fall_axis_to_fault_normal_angle_deg": 9.0,
    "processing": RECORD_PROCESSING,
}  # fmt: skip

POPULATION_FALL_RATE_FINDING: dict[str, Any] = {
    "stones": 256, "share_outside_grid": 0.043, "mean_share_of_stones_without_outcome": 0.0,
    "max_share_of_stones_without_outcome": 0.0, "median_shifted_standing_share_of_all_stones": None,
    "median_rotated_standing_share_of_all_stones": None,
    "median_fall_rate": 0.17, "lower_quartile_of_fall_rate_over_records": 0.07,
    "upper_quartile_of_fall_rate_over_records": 0.62,
    "smallest_fall_rate": 0.0, "largest_fall_rate": 0.97, "by_record": [], "records_without_vertical_motion": 28,
    "median_fall_rate_by_jma_degree": [{"jma_degree": "lower", "median_fall_rate": 0.22,
                      "count": {"motions": 33, "records": 23, "earthquakes": 13}}],
    "checks_of_jma_intensity_rules": [{"rule_fall_rate_lower_limit": 0.4, "rule_fall_rate_upper_limit": 0.9,
    "inferred_jma_degree": "upper",
                      "median_jma_intensity_in_fall_rate_range": 6.4, "count": {"motions": 26, "records": 20,
                      "earthquakes": 11},
                      "share_with_intensity_of_inferred_degree": {"value": 0.65, "low": 0.51, "high": 0.88},
                      "share_with_intensity_above_inferred_degree": {"value": 0.35, "low": 0.12, "high": 0.49},
                      "share_of_inferred_degree_with_vertical_increment": {"value": 0.38, "low": 0.21, "high": 0.61}}],
    "fragility_curves": [{"stone_class": "all stones", "measure": "PGV", "unit": "cm/s", "median": 132.0, "low": 112.0,
                          "high": 157.0, "log_std": 0.64, "log_std_between_records": 0.55,
                          "log_std_within_record": 0.27, "data_minimum": 11.0, "data_maximum": 241.0}],
}  # fmt: skip

DIRECTION_STUDY_FINDINGS: dict[str, Any] = {
    "study": {
        "name": "by-hand", "title": "By hand", "question": "Which way?", "question_kind": "direction",
        "primary_statistic": "alignment", "comparison_variant_of_primary_statistic": None, "model_kind": "planes",
        "free_element_names": ["stone"], "variant_names": [], "height_m": [0.6, 1.2], "b_over_h": [0.1, 0.6],
        "friction": [0.5, 0.8], "azimuth_or_orientation_count": 72, "amplitude_factors": [1.0],
        "max_ensemble_members_per_case": 24,
        "applies_vertical_motion": False,
    },
    "study_counts": {
        "records": 28, "earthquakes": 14, "earthquakes_in_several_groups": 6,
        "heights": 4, "b_over_h_values": 11, "frictions": 6, "blocks": 264,
        "azimuth_or_orientation_step_deg": 5.0, "smallest_azimuth_or_orientation_deg": 0.0,
        "largest_azimuth_or_orientation_deg": 355.0,
        "unsimulated_azimuth_ranges_deg": [(90.0, 120.0)], "records_with_fall_axis_imposed_by_azimuths": [],
        "falls_to_both_sides_are_mirror_images": True,
        "free_elements": 1,
        "reported_element": "stone", "has_square_base": False, "records_with_applied_vertical_motion": 0,
        "records_with_unused_vertical_motion": 0,
        "records_without_stated_pulse": [], "doubts_about_earthquake_assignment": [], "other_amplitude_factor_count": 0,
    },
    "cases": {"total_cases": 133056, "cases_not_copied_by_symmetry": 66528,
    "cases_without_outcome_by_status": {"step limit": 19},
    "share_overturned": 0.353,
              "overturned_share_in_azimuths_near_fault_normal": 0.37,
              "overturned_share_in_azimuths_near_fault_strike": 0.34},
    "direction": {
        "has_fall_axis_comparable_with_fault": True, "reason_for_no_axis_comparable_with_fault": "",
        "groups": [fall_axis_findings_of_group("with a velocity pulse", estimate_entry(0.15, -0.18, 0.41, 12)),
                   fall_axis_findings_of_group("without (control)", estimate_entry(0.05, -0.32, 0.36, 8))],
        "first_minus_second_group_alignment": estimate_entry(0.103, -0.39, 0.53),
        "neighbour_outcome_change_share_by_dimension": {},
    },
    "contrasts": [], "reference_alignments": [], "planar_model_agreement": None, "element_outcomes": [],
    "element_displacements": [],
    "site_fall_rates": [], "unconverged_soil_responses": [], "soil_responses_with_strain_beyond_curves": [],
    "surveys": [],
    "inferred_motions": [],
    "published_peaks": [], "published_agreement": [], "published_comparisons": [],
    "population": POPULATION_FALL_RATE_FINDING,
    "logistic_fit": {"coefficients": [], "fitted_outcome_count": 22176, "earthquake_count": 14,
    "confidence_level": 0.95,
    "reason_for_missing_fit_or_interval": "",
                     "fall_probabilities_after_doubling": [{"doubled_quantity": "PGA and PGV",
                     "fall_probability_after_doubling_from_half": 0.94,
                                      "fall_probability_after_doubling_from_half_low": 0.77,
                                      "fall_probability_after_doubling_from_half_high": 0.991},
                                     {"doubled_quantity": "PGV alone",
                                     "fall_probability_after_doubling_from_half": 0.84,
                                      "fall_probability_after_doubling_from_half_low": 0.58,
                                      "fall_probability_after_doubling_from_half_high": 0.93}]},
    "criteria_scores": {
        "scores": [{"criterion": "West", "predicted_fall_condition": "PGA above a limit", "hit_rate": 0.99,
        "false_alarm_rate": 0.56,
                    "skill": estimate_entry(0.43, 0.29, 0.58),
                    "mean_skill_at_fixed_height_and_b_over_h": estimate_entry(0.23,
                    0.08, 0.34),
                    "mean_skill_within_pulse_criterion_range": 0.31},
                   {"criterion": "B/H alone", "predicted_fall_condition": "B/H below 0.33", "hit_rate": 0.74,
                   "false_alarm_rate": 0.19,
                    "skill": estimate_entry(0.55, 0.41, 0.66),
                    "mean_skill_at_fixed_height_and_b_over_h": estimate_entry(0.0),
                    "mean_skill_within_pulse_criterion_range": 0.0}],
        "significantly_best_criterion": "", "largest_skill_criterion": "West",
        "best_minus_other_skill_by_other_criterion": {"Ishiyama": estimate_entry(0.101, -0.03, 0.19)},
        "insignificant_differences_from_best_skill": [{"first_criterion": "West", "second_criterion": "Ishiyama",
                                 "first_minus_second": estimate_entry(0.101, -0.03, 0.19)}],
        "share_of_cases_beyond_pulse_criterion_range": 0.28,
    },
    "twist_of_moved_standing_stones": None,
    "ensemble": {"share_of_cells_repeated": 0.47, "repeats_every_cell": False, "fewest_runs_per_cell": 8,
                 "most_runs_per_cell": 24, "mean_runs_per_cell": 12.5, "runs_per_cell_in_first_batch": 8,
                 "share_of_repeated_cells_with_fall_and_stand": 0.16,
                 "share_of_repeated_cells_falling_to_both_sides": 0.26},
    "convergence": None,
    "maps": {"height_m": 0.6, "friction": 0.8, "smallest_b_over_h": 0.1,
             "records": [{"record": "vale", "station": "Vale", "event": "Upper Vale", "reason_for_choice": "median",
                          "mean_cos_2_angle_to_fault_normal": 0.52}]},
    "records": [RECORD_FINDING],
    "record_notes": {"record_count_with_notes_or_doubts": 1,
                     "doubts": [{"doubt": d, "record_count": 1,
                     "records": ["vale"]} for d in RECORD_PROCESSING["doubts"]]},
    "status_case_counts": [{"status": "simulated", "case_count": 101528}, {"status": "step limit", "case_count": 19}],
    "sources": [{"record": "vale", "source": "by hand", "licence": "none"}],
    "numerical_quality": {"mean_energy_error_share_of_input": 1e-4, "largest_energy_error_share_of_input": 0.007,
    "largest_penetration_m": 1e-5,
                          "results_cube_sha256": "abcdef", "software_versions": {"overturning": "x.y"}},
}  # fmt: skip

CONVERGENCE_CHECK_FINDINGS: dict[str, Any] = {
    "result": {
        "seed": 1, "wanted_case_count": 400, "rerun_case_count": 400, "rerun_cases_at_rest": 99,
        "study_cell_count": 133056, "simulated_study_cell_count": 66528,
        "study_block_steps": 4000, "max_cost_relative_to_study": 1.0, "time_step_refinement": 8,
        "contact_stiffness_factor": 4.0,
        "finer_step_rerun": {"block_steps": 6000, "changes_by_element": []},
        "stiffer_contact_rerun": {"block_steps": 1000, "changes_by_element": []},
        "tests_of_finer_step_changes": {"changed_cases": 4, "retested_cases": 4, "confirmed_cases": 2,
        "chaotic_cases": 2, "block_steps": 900},
        "amplitude_change_rerun": None, "rigid_block_comparison": None,
    },
    "only_random_sample_was_rerun": True, "share_below_rocking_and_sliding_thresholds": 0.245,
    "fall_azimuth_changes_with_amplitude": None,
    "records_with_more_changes_than_average": [
        {"record": "vale", "changes": {"changed_count": 7, "compared_count": 88, "value": 0.08, "low": 0.041,
        "high": 0.157}},
    ],
    "changes_under_tiny_amplitude_increase": {"changed_count": 2, "compared_count": 400, "value": 0.005, "low": 0.0,
    "high": 0.018},
    "comparisons": [
        {"more_exact_computation_kind": "finer", "step_count_or_stiffness_factor": 8.0, "element": "",
        "refusal_reason": "",
        "fall_or_stand_changes": SHARE_OF_CHANGED_CASES,
         "fall_or_stand_changes_if_ensemble_agrees": {"changed_count": 2, "compared_count": 390, "value": 0.021,
         "low": 0.004,
         "high": 0.033},
         "fall_side_changes": {"changed_count": 9, "compared_count": 150, "value": 0.06, "low": 0.034, "high": 0.113},
         "fall_side_changes_if_ensemble_agrees": {"changed_count": 1, "compared_count": 90, "value": 0.011, "low": 0.0,
         "high": 0.061}},
    ],
}  # fmt: skip

REFERENCE_ALIGNMENT_FINDING: dict[str, Any] = {
    "record_group": "with a velocity pulse",
    "references": [], "best_aligned_references": ["peak velocity", "fault normal"],
    "best_minus_second_alignment": estimate_entry(0.29, 0.11, 0.47),
    "alignment_with_best_reference_axis": estimate_entry(0.58, 0.42, 0.69,
    13),
    "alignment_with_fault_normal": estimate_entry(0.27, -0.03, 0.51, 13),
    "b_over_h_range_count_with_alignment_interval": 6,
    "count_of_alignment_intervals_excluding_zero": 0,
}  # fmt: skip

REMARK = (
    "An invented ruin: twelve columns, nine of which fell, most of them towards the south-east. It shows a file's form."
)
"""Remark of surveys/example-ruin.csv."""

SURVEY_COMPARISON: dict[str, Any] = {
    "survey_file_name": "ruin", "sha256": "abc", "record": "vale", "survey_file_warnings": [],
    "survey_file_comments": [REMARK],
    "fell": 22, "stood": 7, "has_few_falls_in_known_direction": True,
    "fell_in_unknown_direction": 3, "falls_in_known_direction": 19, "observed_mean_direction_deg": 131.0,
    "observed_fall_direction_resultant_length": 0.57,
    "observed_falls_by_octant": {"N": 12.0, "S": 7.0}, "predicted_falls_by_octant": {"N": 10.4, "S": 8.6},
    "predicted_mean_direction_deg": 147.0, "predicted_fall_direction_resultant_length": 0.29,
    "stones_with_b_over_h_far_outside_grid": 0, "has_no_stone_with_prediction": False,
    "stones_with_height_outside_grid": 8,
    "observed_fall_share": {"value": 0.759, "low": 0.565, "high": 0.897},
    "computed_fall_share": {"value": 0.42, "low": 0.31, "high": 0.64},
    "log_likelihood_ratio": 2.83, "likelihood_ratio_p_value_if_directions_random": 0.021,
    "predicted_side_counts_by_observed_side": {},
    "has_falls_with_known_face_and_b_over_h": False,
    "known_direction_falls_without_face_or_b_over_h": 17, "known_direction_falls_without_any_computed_fall": 2,
    "stones_without_computed_outcome": 5, "known_direction_falls_without_computed_outcome": 3,
    "known_direction_falls_without_prediction": 3,
    "falls_with_predicted_direction": 14,
    "goodness_of_fit_tests": [{"name": "chi-square", "sample_size": 19, "statistic": 4.63, "p_value": 0.23}],
    "uniformity_test": {"name": "Watson", "sample_size": 19, "statistic": 0.349, "p_value": 0.0015},
    "stones_with_correct_most_probable_outcome": None, "stones_with_checked_most_probable_outcome": None,
    "known_direction_falls_without_face_azimuth": 17,
    "known_direction_falls_without_b_over_h": 6, "stones_with_b_over_h_slightly_outside_grid": 4,
    "assumed_random_direction_share": 0.05,
    "sites": [{"site": "upper", "fell": 13, "stood": 6, "falls_in_known_direction": 11,
               "observed_fall_share": {"value": 0.684, "low": 0.434, "high": 0.874},
               "computed_fall_share": {"value": 0.47, "low": 0.33, "high": 0.61},
               "log_likelihood_ratio": 1.72, "likelihood_ratio_p_value_if_directions_random": 0.037},
              {"site": "", "fell": 9, "stood": 0, "falls_in_known_direction": 8, "observed_fall_share": None,
               "computed_fall_share": {"value": 0.36, "low": 0.27, "high": 0.52},
               "log_likelihood_ratio": -0.26, "likelihood_ratio_p_value_if_directions_random": 0.58}],
}  # fmt: skip


def _displacement_measure_finding(name: str, stones: int, observed: list[Any], computed: list[Any]) -> dict[str, Any]:
    """Return the finding on one displacement measure; ``observed`` and ``computed`` are [value, low, high]."""
    ends = ("value", "low", "high")
    pairs = {kind: dict(zip(ends, of, strict=True)) for kind, of in (("observed", observed), ("computed", computed))}
    return {"share_or_median_name": name, "observed_stone_count": stones, **pairs}


_SITE_DISPLACEMENT_FINDINGS: dict[str, Any] = {
    "site": "", "fell": 21, "stood": 33, "matching_computed_cases": 417,
    "standing_stones_without_standing_simulation": 2,
    "stones_without_computed_outcome": 4, "stones_far_outside_b_over_h_or_aspect_range": 3,
    "compared_shares_and_medians": [
        _displacement_measure_finding("fell", 54, [0.389, 0.259, 0.531], [0.44, 0.37, 0.52]),
        _displacement_measure_finding("shifted", 32, [0.281, 0.137, 0.467], [0.15, 0.08, 0.23]),
        _displacement_measure_finding("twisted", 33, [0.182, 0.07, 0.355], [0.11, None, None]),
        _displacement_measure_finding("clockwise", 6, [0.833, 0.359, 0.996], [0.58, None, None]),
        _displacement_measure_finding("shift_m", 9, [2.4, 1.3, 5.6], [1.9, None, None]),
        _displacement_measure_finding("twist_deg", 6, [8.3, None, None], [None, None, None])
    ],
    "fall_direction_findings": {
        "falls_in_known_direction": 17, "observed_mean_direction_deg": 133.0,
        "observed_fall_direction_resultant_length": 0.54,
        "predicted_mean_direction_deg": 148.0,
        "predicted_fall_direction_resultant_length": 0.29, "observed_falls_by_octant": dict.fromkeys(OCTANTS, 2.5),
        "predicted_falls_by_octant": dict.fromkeys(OCTANTS, 2.3), "log_likelihood_ratio": 1.9,
        "likelihood_ratio_p_value_if_directions_random": 0.026, "known_direction_falls_without_any_computed_fall": 3,
        "known_direction_falls_without_prediction": 6,
        "falls_with_predicted_direction": 8, "has_no_stone_with_prediction": False,
        "assumed_random_direction_share": 0.05,
    },
}  # fmt: skip
SURVEY_DISPLACEMENTS: dict[str, Any] = {
    "survey_file_name": "plots", "sha256": "abc", "record": "vale", "survey_file_warnings": ["angles may be in gon"],
    "survey_file_comments": [],
    "all_sites": _SITE_DISPLACEMENT_FINDINGS, "sites": [], "cemetery_soil_findings": [],
}  # fmt: skip


def _observed_mean_direction_finding(mean: float | None, half_width: float | None, p_value: float) -> dict[str, Any]:
    """Return the finding on a mean direction of observed falls, degrees."""
    return {
        "sample_size": 19,
        "mean_deg": mean,
        "interval_half_width_deg": half_width,
        "mean_resultant_length": 0.57,
        "uniformity_p_value": p_value,
    }


def _observed_site_findings(site: str, **changes: Any) -> dict[str, Any]:
    """Return the findings on the observed falls of one site; ``changes`` replace entries."""
    return {
        "site": site, "stones": 34, "fell": 22, "stands": 7, "standing_shifted_or_twisted": 4, "not_counted": 5,
        "not_counted_by_reason": {"fixed": 3, "broken": 2}, "fell_in_unknown_direction": 3,
        "fell_share_of_counted": {"value": 0.759, "low": 0.565, "high": 0.897},
        "stands_share_of_counted": {"value": 0.241, "low": 0.103, "high": 0.435},
        "not_counted_share": {"value": 0.147, "low": 0.05, "high": 0.311},
        "direction": _observed_mean_direction_finding(131.0, 23.0, 0.0024),
        "axis": _observed_mean_direction_finding(None, None, 0.28),
        "falls_by_sector": [12.0, 7.0], **changes,
    }  # fmt: skip


OBSERVED_SURVEY_FINDINGS: dict[str, Any] = {
    "survey_file_name": "ruin", "doubts": [], "smallest_magnetic_declination_deg": -7.5,
    "largest_magnetic_declination_deg": -7.25,
    "all_sites": _observed_site_findings(""),
    "sites": [
        _observed_site_findings("upper", axis=_observed_mean_direction_finding(122.0, 8.0, 0.013)),
        _observed_site_findings("", fell_share_of_counted=None, stands_share_of_counted=None,
        axis=_observed_mean_direction_finding(99.0,
        None, 0.0005))
    ],
}  # fmt: skip

INFERRED_MOTION: dict[str, Any] = {
    "survey_file_name": "ruin", "fell": 22, "stood": 7, "peak_velocity_axis_credible_arc_middle_deg": 122.0,
    "velocity_axis_credible_arc_width_deg": 86.0,
    "strengths": [{"measure": "PGV", "unit": "cm/s", "posterior_low": 36.7, "posterior_high": 171.0, "prior_low": 8.2,
                   "prior_high": 340.0}],
    "everything_fell": False, "velocity_axis_credible_arc_half_width_deg": 43.0,
    "posterior_probability_of_strongest_pgv_level": 0.07,
    "posterior_probability_of_weakest_pgv_level": 0.0,
    "lowest_candidate_pgv_level_cm_s": 6.0, "highest_candidate_pgv_level_cm_s": 400.0,
    "assumed_fixed_stone_share": 0.02,
    "fit_p_value": 0.33,
    "any_motion_fits": True,
    "has_no_upper_strength_bound": True, "has_no_lower_strength_bound": False, "direction_likelihood_exponent": 0.3,
    "likeliest_motions": [{"motion_name": "vale", "posterior_probability": 0.19, "prior_probability": 0.04}],
    "stones_without_height": 3,
    "stones_without_b_over_h": 5, "has_assumed_sizes": True, "assumed_range_of_unknown_heights_m": {"low_m": 0.61,
    "high_m": 0.92},
    "assumed_range_of_unknown_widths_m": {"low_m": 0.31, "high_m": 0.42},
    "sites": [
        {"site": "upper", "fell": 13, "stood": 6, "peak_velocity_axis_credible_arc_middle_deg": 118.0,
        "velocity_axis_credible_arc_width_deg": 98.0,
         "velocity_axis_credible_arc_half_width_deg": 49.0, "everything_fell": False, "fit_p_value": 0.004,
         "any_motion_fits": False,
         "strengths": [{"measure": "PGV", "unit": "cm/s", "posterior_low": 31.2, "posterior_high": 214.0,
                        "prior_low": 8.2, "prior_high": 340.0}]},
        {"site": "", "fell": 9, "stood": 0, "peak_velocity_axis_credible_arc_middle_deg": 127.0,
        "velocity_axis_credible_arc_width_deg": 162.0,
         "velocity_axis_credible_arc_half_width_deg": 81.0, "everything_fell": True, "fit_p_value": 0.41,
         "any_motion_fits": True,
         "strengths": [{"measure": "PGV", "unit": "cm/s", "posterior_low": 44.1, "posterior_high": float("inf"),
                        "prior_low": 8.2, "prior_high": 340.0}]},
    ],
}  # fmt: skip

ONE_RECORD_COUNTS = {"records": 1, "earthquakes": 1, "earthquakes_in_several_groups": 0}


def findings_with_changed_entries(base: dict[str, Any], **parts: Any) -> dict[str, Any]:
    """Return a copy of findings with some entries replaced; entries that are dictionaries are merged."""
    own = {name: base[name] | part if isinstance(base[name], dict) and isinstance(part, dict) else part
           for name, part in parts.items()}  # fmt: skip
    return base | own


def findings_without_axis_comparable_with_fault(reason: str, **parts: Any) -> dict[str, Any]:
    """Return findings of a study whose falls have no axis to compare with a fault; ``parts`` replace other entries."""
    direction = {"has_fall_axis_comparable_with_fault": False, "reason_for_no_axis_comparable_with_fault": reason}
    return findings_with_changed_entries(DIRECTION_STUDY_FINDINGS, direction=direction, **parts)


def study_section_of_findings(question_kind: str, **study: Any) -> dict[str, Any]:
    """Return the section `study` of findings for a kind of question, e.g. "scene"; keywords add or replace entries."""
    return {
        "question_kind": question_kind,
        "comparison_variant_of_primary_statistic": "other",
        "primary_statistic": "share",
        **study,
    }


ELEMENT_FALL_STATISTICS_FINDING = {
    "variant": "nominal", "scene": "stack", "element": "shaft", "cases_with_outcome": 12096, "falls": 4880,
    "falls_with_no_earlier_fall": 4711,
    "share_overturned": 0.403, "share_of_falls_with_no_earlier_fall": 0.965,
    "share_of_falls_without_other_falls": 0.914,
    "median_fall_time_s": 4.95}  # fmt: skip
ELEMENT_DISPLACEMENT_STATISTICS_FINDING = {
    "variant": "nominal", "scene": "stack", "element": "shaft", "standing_case_count": 7216,
    "median_slip_if_standing_cm": 0.3,
    "percentile_90_slip_if_standing_cm": 2.7, "median_abs_twist_if_standing_deg": 0.4,
    "percentile_90_abs_twist_if_standing_deg": 6.2, "cases_with_fall": 4880,
    "share_of_falls_by_sliding_off": 0.126}  # fmt: skip
SITE_FALL_RATES_FINDING = {
    "variant": "other", "has_equivalent_linear_layer": True, "layers": [{"thickness_m": 20.0,
    "shear_wave_velocity_m_s": 180.0}],
    "amplitude_factor": 1.5, "median_pga_m_s2": 4.12, "mean_fall_rate": 0.31, "median_fall_rate": 0.28,
    "records_with_at_least_half_fallen": 9, "median_angle_to_fall_axis_without_soil_deg": 14.0,
    "records_with_fall_axis_with_and_without_soil": 21}  # fmt: skip
STUDY_MINUS_VARIANT_FALL_RATE_FINDINGS = {
    "population_fall_rate_in_study": estimate_entry(0.31, 0.22, 0.43),
    "population_fall_rate_in_variant": estimate_entry(0.47, 0.33, 0.59),
    "primary_statistic_study_minus_variant": estimate_entry(-0.164, -0.278, -0.049)}  # fmt: skip
PLANAR_MODEL_AGREEMENT_FINDING = {
    "compared_case_count": 66528, "same_outcome_share": 0.967,
    "same_outcome_share_if_b_over_h_neighbour_differs": 0.854,
    "only_3d_overturns_share": 0.021,
    "only_2d_overturns_share": 0.012, "same_fall_edge_share": 0.743,
    "mean_angle_between_fall_axes_deg": 23.0}  # fmt: skip
TWIST_OF_STANDING_STONES = {
    "moved_standing_stone_count": 31000,
    "median_abs_twist_deg": 0.4,
    "percentile_90_abs_twist_deg": 6.2,
    "largest_abs_twist_deg": 88.0,
}

STUDY_FINDINGS: dict[str, dict[str, Any]] = {
    "direction": findings_with_changed_entries(DIRECTION_STUDY_FINDINGS, convergence=CONVERGENCE_CHECK_FINDINGS),
    "reference": findings_with_changed_entries(
        DIRECTION_STUDY_FINDINGS, study=study_section_of_findings("reference", primary_statistic="alignment",
        model_kind="space"),
        reference_alignments=[REFERENCE_ALIGNMENT_FINDING,
        REFERENCE_ALIGNMENT_FINDING | {"record_group": "without (control)"}],
        planar_model_agreement=PLANAR_MODEL_AGREEMENT_FINDING, twist_of_moved_standing_stones=TWIST_OF_STANDING_STONES,
        logistic_fit=None,
        criteria_scores=None, population=None),
    "vertical": findings_without_axis_comparable_with_fault(
        "no fault normal", study=study_section_of_findings("vertical", applies_vertical_motion=True), population=None,
        study_counts=ONE_RECORD_COUNTS | {"records_with_applied_vertical_motion": 1},
        contrasts=[variant_comparison_findings(differing_settings=["vertical"],
        study_minus_variant_share=estimate_entry(-0.006,
        n=1),
                                         primary_statistic_study_minus_variant=estimate_entry(-0.006, n=1))]),
    "scene": findings_with_changed_entries(
        DIRECTION_STUDY_FINDINGS, study=study_section_of_findings("scene"), study_counts={"free_elements": 3,
        "reported_element": "shaft",
        "falls_to_both_sides_are_mirror_images": False},
        contrasts=[variant_comparison_findings(compared_element_in_study="shaft",
        compared_element_in_variant="monolith")],
        element_outcomes=[ELEMENT_FALL_STATISTICS_FINDING], logistic_fit=None, criteria_scores=None),
    "stack in 3-D": findings_with_changed_entries(
        DIRECTION_STUDY_FINDINGS, study=study_section_of_findings("scene", model_kind="space"),
        study_counts={"free_elements": 3, "reported_element": "shaft", "falls_to_both_sides_are_mirror_images": False},
        contrasts=[variant_comparison_findings(share_over_45_deg_apart_if_both_fall=0.21,
        compared_element_in_study="shaft",
        compared_element_in_variant="shaft")],
        element_outcomes=[ELEMENT_FALL_STATISTICS_FINDING], twist_of_moved_standing_stones=TWIST_OF_STANDING_STONES,
        element_displacements=[ELEMENT_DISPLACEMENT_STATISTICS_FINDING,
                               ELEMENT_DISPLACEMENT_STATISTICS_FINDING | {"variant": "other",
                               "share_of_falls_by_sliding_off": 0.0}],
        logistic_fit=None, criteria_scores=None),
    "site": findings_with_changed_entries(
        DIRECTION_STUDY_FINDINGS, study=study_section_of_findings("site", primary_statistic="fall_rate"),
        site_fall_rates=[SITE_FALL_RATES_FINDING],
        contrasts=[variant_comparison_findings(differing_settings=["site"], soil_thickness_of_variant_m=20.0,
        **STUDY_MINUS_VARIANT_FALL_RATE_FINDINGS)],
        unconverged_soil_responses=["other, vale: north not converged"],
        soil_responses_with_strain_beyond_curves=["other, ford: east converged"]),
    "survey": findings_with_changed_entries(
        DIRECTION_STUDY_FINDINGS, study=study_section_of_findings("survey"), surveys=[SURVEY_COMPARISON],
        inferred_motions=[INFERRED_MOTION],
        published_peaks=[{"component": "north", "measure": "PGA", "unit": "Gal", "published_peak": 1023.3,
                          "study_motion_peak": 1019.4, "study_over_published_peak_minus_1": -0.0038,
                          "max_relative_difference_from_processing": 0.01,
                          "agrees": True}],
        published_agreement=[{"variant": "nominal", "blocks": 12, "fully_agreeing_block_count": 9,
                              "heights_agreeing_at_some_friction_m": [0.4, 0.95]}],
        published_comparisons=[{"variant": "nominal", "record": "vale", "motion_azimuth_deg": 61.0, "height_m": 0.7,
                                "friction": 0.8, "published_overturns": True, "computed_overturns": False}]),
    "nothing falls": findings_without_axis_comparable_with_fault("no falls", cases={"share_overturned": 0.0},
    population=None),
    "uneven planes": findings_with_changed_entries(
        findings_without_axis_comparable_with_fault("uneven planes", study_counts={
            "unsimulated_azimuth_ranges_deg": [(100.0, 240.0)], "azimuth_or_orientation_step_deg": 20.0,
            "smallest_azimuth_or_orientation_deg": 60.0,
            "largest_azimuth_or_orientation_deg": 100.0}),
        direction={"has_fall_axis_comparable_with_fault": False,
        "reason_for_no_axis_comparable_with_fault": "uneven planes", "groups": [],
                   "overturned_shares_by_plane_azimuth": [{"azimuth_deg": 60.0, "share_overturned": 0.41},
                                                 {"azimuth_deg": 80.0, "share_overturned": 0.23}]},
        maps={"records": [{"record": "vale", "station": "Vale", "event": "Upper Vale",
        "reason_for_choice": "first with falls",
                           "mean_cos_2_angle_to_fault_normal": None}]},
    ),
    "everything falls": findings_without_axis_comparable_with_fault("falls in every plane",
    cases={"share_overturned": 1.0}),
    "unknown outcomes": findings_without_axis_comparable_with_fault(
        "unknown outcomes", study_counts={"records_with_fall_axis_imposed_by_azimuths": ["vale", "ford"]}),
    "no fault normal": findings_without_axis_comparable_with_fault("no fault normal", study_counts={"records": 3}),
}  # fmt: skip


def handwritten_findings_of_study(name: str) -> Findings:
    """Return the entry ``name`` of `STUDY_FINDINGS` as validated `Findings`."""
    return Findings.model_validate(STUDY_FINDINGS[name])
