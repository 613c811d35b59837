"""Shifts and twists of the standing stones of surveys, next to those of the standing stones of a 3-D study."""

from pydantic import Field

from overturning.findings.results import StudyResults
from overturning.findings.surveys import CemeteryGroundFinding, cemetery_ground_findings
from overturning.findings.values import Finding, Number
from overturning.surveys.displacements import (
    SHIFTED_M,
    TWISTED_DEG,
    DisplacementComparison,
    MeasureName,
    StoredDisplacementComparison,
)
from overturning.units import CM


class ObservedMeasure(Finding):
    """Observed share or median of a survey's stones, with its exact 95 % interval."""

    value: Number
    """Share or median; None without stones."""
    low: Number
    """Lower end of the interval; None without stones, and for a median of fewer than six stones."""
    high: Number
    """Upper end of the interval."""
    level: float = 0.95
    """Probability of the interval."""


class ComputedMeasure(Finding):
    """Computed share or median of stones: mean and range over the friction coefficients of the study."""

    value: Number
    """Mean over frictions; None if nothing of the kind was computed."""
    low: Number
    """Smallest value of a friction; None if the study has one friction."""
    high: Number
    """Largest value of a friction; None if the study has one friction."""


class DisplacementMeasureFinding(Finding):
    """Observed and computed value of a share (0 to 1), a median shift (cm) or a median twist (degrees)."""

    measure: MeasureName
    """Share that fell, share of the standing stones that are shifted or twisted, share of clockwise twists, medians."""
    stones: int
    """Number of observed stones of the share or median."""
    observed: ObservedMeasure
    computed: ComputedMeasure


class SurveyDisplacementsOfSite(Finding):
    """Observed and computed falls, shifts and twists of the stones at one survey site, or at all together."""

    site: str
    """Name of the site; empty for stones without one, and for all sites together."""
    fell: int
    """Number of stones that fell."""
    stood: int
    """Number of stones that stood."""
    cells: int
    """Number of different computed cases that resemble the stones."""
    never_stand: int
    """Standing stones like which none stands in the study; they are compared in no displacement."""
    without_outcome: int
    """Stones like which no computed case has an outcome; they are compared in no computed value."""
    measures: list[DisplacementMeasureFinding]


class SurveyDisplacements(Finding):
    """Comparison of a survey with a 3-D study: falls, shifts and twists of the stones."""

    stones: str
    """Name of the survey file."""
    sha256: str
    """SHA-256 hash of the survey file."""
    record: str
    """Record for whose site the study was computed."""
    doubts: list[str]
    """Doubts about the survey file, such as the unit of its azimuths."""
    remarks: list[str]
    """Comment lines at the start of the survey file that are not empty."""
    shifted_from_cm: float = SHIFTED_M / CM
    """Shift from which a standing stone counts as shifted, cm."""
    twisted_from_deg: float = TWISTED_DEG
    """Absolute twist from which a standing stone counts as twisted, degrees."""
    together: SurveyDisplacementsOfSite
    """All sites together."""
    sites: list[SurveyDisplacementsOfSite] = Field(default_factory=list)
    """Each site by itself; empty if the survey has only one."""
    grounds: list[CemeteryGroundFinding] = Field(default_factory=list)
    """Soil below the cemeteries; empty if the record is used as it is for all stones."""


def all_survey_displacements(results: StudyResults) -> list[SurveyDisplacements]:
    """Return the comparison of falls, shifts and twists for each survey of a 3-D study; [] for a 2-D study."""
    return [survey_displacement_findings(one) for one in results.survey_displacements]


def survey_displacement_findings(stored: StoredDisplacementComparison) -> SurveyDisplacements:
    """Return the report's numbers on falls, shifts and twists of the stones of a survey."""
    return SurveyDisplacements(
        stones=stored.stones,
        sha256=stored.sha256,
        record=stored.record,
        doubts=list(stored.doubts),
        remarks=list(stored.remarks),
        together=_displacements_of_site("", stored.together),
        sites=[_displacements_of_site(site, one) for site, one in stored.sites],
        grounds=cemetery_ground_findings(stored.grounds),
    )


def _displacements_of_site(site: str, found: DisplacementComparison) -> SurveyDisplacementsOfSite:
    """Return the report's numbers on falls, shifts and twists of the stones at one site."""
    measures = []
    for one in found.measures:
        scale = 1 / CM if one.name == "shift_m" else 1.0
        observed, computed = (
            {
                end: scale * getattr(one, f"{kind}{suffix}")
                for end, suffix in (("value", ""), ("low", "_low"), ("high", "_high"))
            }
            for kind in ("observed", "computed")
        )
        measures.append(
            DisplacementMeasureFinding(
                measure=one.name,
                stones=one.stones,
                observed=ObservedMeasure(**observed),
                computed=ComputedMeasure(**computed),
            )
        )
    return SurveyDisplacementsOfSite(
        site=site,
        fell=found.fell,
        stood=found.stood,
        cells=found.cells,
        never_stand=found.never_stand,
        without_outcome=found.without_outcome,
        measures=measures,
    )
