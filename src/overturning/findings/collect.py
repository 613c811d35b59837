"""Findings of a study: all numbers that its report shows, computed from its results."""

import json
import warnings
from pathlib import Path
from typing import Any

from pydantic import Field

from overturning.files import convert_argument_to_path, write_text
from overturning.findings.causes import (
    CriteriaFindings,
    LogisticFitFindings,
    PublishedAndComputedBlockOutcome,
    compare_outcomes_with_published,
    logistic_fit_findings,
    skill_of_published_criteria,
)
from overturning.findings.contrast import (
    ElementFallSummaryForOneVariant,
    VariantContrast,
    compare_study_with_variants,
    element_fall_findings,
)
from overturning.findings.direction import (
    FallDirectionRelativeToFaultNormal,
    PlanarModelAgreement,
    RecordGroupReferenceAlignment,
    fall_alignments_with_references,
    fall_direction_findings,
    planar_model_agreement,
)
from overturning.findings.displacements import ElementDisplacementFindings, final_slip_and_twist_of_standing_elements
from overturning.findings.exactness import (
    EnsembleDisagreementFindings,
    FinalTwistOfMovedStandingStones,
    OutcomeChangesInConvergenceCheck,
    convergence_findings,
    ensemble_findings,
    final_twist_findings,
)
from overturning.findings.extent import (
    CaseCountOfStatus,
    RecordSourceAndLicence,
    ReportMapSelection,
    StudyExtentSummary,
    case_counts_by_status,
    choose_fall_maps_for_report,
    count_records_and_blocks_with_direction_range,
    source_and_licence_of_records,
)
from overturning.findings.inferred_motion import InferredMotionOfSurvey, inferred_motions_of_all_surveys
from overturning.findings.opening import note_on_findings_missing_without_study_file, open_study_results
from overturning.findings.population import StonePopulationFindings, population_findings
from overturning.findings.processing import DoubtsAboutRecordData, summarise_record_notes_and_doubts
from overturning.findings.published import (
    BlockCountAgreeingWithPublished,
    PublishedPeakComparison,
    compare_peaks_with_published,
    count_fully_agreeing_published_blocks_by_variant,
)
from overturning.findings.results import StudyResults
from overturning.findings.soil import (
    SoilProfileFallRatesAtAmplitude,
    notes_on_soil_strain_beyond_curves,
    notes_on_unconverged_soil_analyses,
    population_fall_rates_by_soil_and_amplitude,
)
from overturning.findings.study import (
    CaseCountsAndOverturnedShares,
    EnergyErrorPenetrationAndSoftwareVersions,
    RecordPeaksAndFallDirection,
    StudyQuestionAndParameters,
    case_counts_and_overturned_shares,
    numerical_errors_and_software_versions,
    peaks_and_fall_directions_of_records,
    study_question_and_parameters,
)
from overturning.findings.survey_displacements import (
    SurveyFallAndDisplacementFindings,
    observed_and_computed_displacements_by_survey,
)
from overturning.findings.surveys import SurveyPredictionFindings, observed_and_predicted_falls_by_survey
from overturning.findings.values import FindingBaseClass
from overturning.stored import read_json_result
from overturning.study.schema import Study


class Findings(FindingBaseClass):
    """All numbers in the report of a study; fields that do not apply to the study are null or empty."""

    study: StudyQuestionAndParameters
    """Question and grid."""
    study_counts: StudyExtentSummary
    cases: CaseCountsAndOverturnedShares
    """Number of cases and their outcomes."""
    direction: FallDirectionRelativeToFaultNormal
    """Direction of falls relative to the fault normal."""
    contrasts: list[VariantContrast]
    """Comparison with each variant."""
    reference_alignments: list[RecordGroupReferenceAlignment]
    """Alignment of 3-D falls with references."""
    planar_model_agreement: PlanarModelAgreement | None
    """Agreement of the 2-D model in the face planes with the 3-D outcome."""
    element_outcomes: list[ElementFallSummaryForOneVariant]
    """Falls of each element of scenes of several elements."""
    element_displacements: list[ElementDisplacementFindings]
    """Final slip and twist of each element of 3-D scenes."""
    site_fall_rates: list[SoilProfileFallRatesAtAmplitude]
    """Falls of the population on each soil."""
    unconverged_soil_responses: list[str]
    """Soil computations that did not converge."""
    soil_responses_with_strain_beyond_curves: list[str]
    """Soil computations whose effective strain exceeds the largest strain of the curve of a layer."""
    surveys: list[SurveyPredictionFindings]
    """Comparison of each survey of fallen stones with the prediction."""
    survey_displacements: list[SurveyFallAndDisplacementFindings] = Field(default_factory=list)
    """Comparison of each survey with the displacements computed in a 3-D study."""
    inferred_motions: list[InferredMotionOfSurvey]
    """Motion inferred from each survey."""
    published_peaks: list[PublishedPeakComparison]
    """Published peaks of the motions and computed ones."""
    published_agreement: list[BlockCountAgreeingWithPublished]
    """Blocks for which all published outcomes are found."""
    published_comparisons: list[PublishedAndComputedBlockOutcome]
    """Outcomes next to published ones."""
    population: StonePopulationFindings | None
    """Falls of the population of stones."""
    logistic_fit: LogisticFitFindings | None
    """Logistic fit of the probability of overturning."""
    criteria_scores: CriteriaFindings | None
    """Skill of published criteria."""
    twist_of_moved_standing_stones: FinalTwistOfMovedStandingStones | None
    """Rotation about the vertical of stones that stand."""
    ensemble: EnsembleDisagreementFindings | None
    """Cells whose repeated runs disagree."""
    convergence: OutcomeChangesInConvergenceCheck | None
    """Cases that change in a second, finer computation."""
    maps: ReportMapSelection
    records: list[RecordPeaksAndFallDirection]
    """Records and the falls under each."""
    record_notes: DoubtsAboutRecordData
    """Notes and doubts about the data of the records."""
    status_case_counts: list[CaseCountOfStatus]
    sources: list[RecordSourceAndLicence]
    numerical_quality: EnergyErrorPenetrationAndSoftwareVersions
    """Energy error, penetration and versions."""


def findings_from_results(results: StudyResults) -> Findings:
    """Compute all numbers in the report of a study from its opened results files."""
    records = peaks_and_fall_directions_of_records(results)
    return Findings(
        study=study_question_and_parameters(results),
        study_counts=count_records_and_blocks_with_direction_range(results),
        cases=case_counts_and_overturned_shares(results),
        direction=fall_direction_findings(results),
        contrasts=compare_study_with_variants(results),
        reference_alignments=fall_alignments_with_references(results),
        planar_model_agreement=planar_model_agreement(results),
        element_outcomes=element_fall_findings(results),
        element_displacements=final_slip_and_twist_of_standing_elements(results),
        site_fall_rates=population_fall_rates_by_soil_and_amplitude(results),
        unconverged_soil_responses=notes_on_unconverged_soil_analyses(results),
        soil_responses_with_strain_beyond_curves=notes_on_soil_strain_beyond_curves(results),
        surveys=observed_and_predicted_falls_by_survey(results),
        survey_displacements=observed_and_computed_displacements_by_survey(results),
        inferred_motions=inferred_motions_of_all_surveys(results),
        published_peaks=compare_peaks_with_published(results),
        published_agreement=count_fully_agreeing_published_blocks_by_variant(results),
        published_comparisons=compare_outcomes_with_published(results),
        population=population_findings(results),
        logistic_fit=logistic_fit_findings(results),
        criteria_scores=skill_of_published_criteria(results),
        twist_of_moved_standing_stones=final_twist_findings(results),
        ensemble=ensemble_findings(results),
        convergence=convergence_findings(results),
        maps=choose_fall_maps_for_report(results),
        records=records,
        record_notes=summarise_record_notes_and_doubts({one.id: one.processing for one in records}),
        status_case_counts=case_counts_by_status(results),
        sources=source_and_licence_of_records(results),
        numerical_quality=numerical_errors_and_software_versions(results),
    )


def findings(cube: str | Path, study: Study | None = None) -> Findings:
    """Compute all numbers in the report of a study from its results files.

    Parameters
    ----------
    cube : str or Path
        Cube of the study (``cube.nc``) in its folder of results, or this folder; ``intensity.nc`` and, if the study has
        them, cubes of variants, ``convergence.json`` and ``survey/`` are read from the same folder.
    study : Study, optional
        Study from which question, primary statistic, population and surveys are taken; not given: that in
        ``study.yaml`` in the same folder. Without this file, a warning names the parts that the findings lack.

    Returns
    -------
    Findings
        Numbers with their intervals, units and number of earthquakes; no sentences.

    Raises
    ------
    ResultError
        If a result is missing, damaged or from another version, or if `cube` is a file other than the whole cube of a
        study, such as the cube of a variant.
    ArgumentError
        If `cube` is no path.
    """
    path = convert_argument_to_path("cube", cube, "the path of cube.nc, or of its folder: other results are next to it")
    with open_study_results(path, study) as results:
        for name in results.names_of_cubes_changed_after_run:
            why = "its outcomes were changed after the run; the findings are of the changed ones and state their hash"
            warnings.warn(f"{results.results_folder / name}: {why}", stacklevel=3)
        if study is None and (lacking := note_on_findings_missing_without_study_file(results)):
            warnings.warn(lacking, stacklevel=3)  # The caller of `overturning.findings`, a module that can be called.
        return findings_from_results(results)


def read_findings(path: Path) -> Findings:
    """Read the numbers of a study's report (`Findings`) from JSON; raise a `ResultError` if missing or damaged.

    The error is also raised for a file from another version.
    """
    return read_json_result(Findings, path, "findings")


def write_findings(findings: Findings, path: Path) -> None:
    """Write the numbers of a study's report (`Findings`) to a JSON file."""
    write_text(path, findings.model_dump_json(indent=1) + "\n")


def findings_schema() -> str:
    """Return, as text, the JSON schema of the file with all numbers of a study's report (`Findings`)."""
    schema: dict[str, Any] = Findings.model_json_schema(mode="serialization")
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
