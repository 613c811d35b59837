"""Findings of a study: all numbers that its report shows, computed from its results."""

import json
from pathlib import Path
from typing import Any

from overturning.files import write_text
from overturning.findings.causes import Criteria, Fit, PublishedOutcome, criteria_of, fit_of, published_of
from overturning.findings.contrast import (
    ElementFinding,
    GroundFinding,
    VariantContrast,
    contrasts_of,
    elements_of,
    ground_of,
)
from overturning.findings.direction import (
    Direction,
    GroupReferences,
    PlaneAgreement,
    direction_of,
    planes_of,
    references_of,
)
from overturning.findings.exactness import (
    ConvergenceFindings,
    EnsembleFindings,
    Twist,
    convergence_of,
    ensemble_of,
    twist_of,
)
from overturning.findings.population import PopulationFindings, population_of
from overturning.findings.results import Results, open_results
from overturning.findings.study import (
    Cases,
    Quality,
    RecordFacts,
    StudyFacts,
    cases_of,
    quality_of,
    records_of,
    study_facts,
)
from overturning.findings.surveys import InferredMotion, SurveyFindings, motions_of, surveys_of
from overturning.findings.values import Finding
from overturning.study.schema import Study


class Findings(Finding):
    """Findings of a study; parts that do not apply to it are null or empty."""

    study: StudyFacts
    cases: Cases
    direction: Direction
    contrasts: list[VariantContrast]
    references: list[GroupReferences]
    planes: PlaneAgreement | None
    elements: list[ElementFinding]
    ground: list[GroundFinding]
    surveys: list[SurveyFindings]
    motions: list[InferredMotion]
    published: list[PublishedOutcome]
    population: PopulationFindings | None
    fit: Fit | None
    criteria: Criteria | None
    twist: Twist | None
    ensemble: EnsembleFindings | None
    convergence: ConvergenceFindings | None
    records: list[RecordFacts]
    quality: Quality


def findings_of(results: Results) -> Findings:
    """Compute the findings of opened results."""
    return Findings(
        study=study_facts(results),
        cases=cases_of(results),
        direction=direction_of(results),
        contrasts=contrasts_of(results),
        references=references_of(results),
        planes=planes_of(results),
        elements=elements_of(results),
        ground=ground_of(results),
        surveys=surveys_of(results),
        motions=motions_of(results),
        published=published_of(results),
        population=population_of(results),
        fit=fit_of(results),
        criteria=criteria_of(results),
        twist=twist_of(results),
        ensemble=ensemble_of(results),
        convergence=convergence_of(results),
        records=records_of(results),
        quality=quality_of(results),
    )


def findings(cube: str | Path, study: Study | None = None) -> Findings:
    """Compute the findings of a study from its results.

    Parameters
    ----------
    cube : str or Path
        Cube of the study (``cube.nc``) in its folder of results, or this folder; ``intensity.nc`` and, if the study has
        them, ``convergence.json`` and ``survey/`` are read from the same folder.
    study : Study, optional
        Study from which question, population and surveys are taken; not given: the study stored in the cube.

    Returns
    -------
    Findings
        Numbers with their intervals, units and number of earthquakes; no sentences.

    Raises
    ------
    ResultError
        If a result is missing or from another version.
    """
    path = Path(cube)
    folder = path if path.is_dir() else path.parent
    with open_results(folder, study) as results:
        return findings_of(results)


def write_findings(found: Findings, path: Path) -> None:
    """Write findings as JSON."""
    write_text(path, found.model_dump_json(indent=1) + "\n")


def findings_schema() -> str:
    """Return the JSON schema of `Findings` as text."""
    schema: dict[str, Any] = Findings.model_json_schema(mode="serialization")
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
