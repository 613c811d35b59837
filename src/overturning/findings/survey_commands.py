"""Results that the commands on surveys print."""

from pydantic import Field

from overturning.findings.inferred_motion import InferredMotionOfSurvey
from overturning.findings.observed import ObservedSurveyFindings
from overturning.findings.survey_displacements import SurveyDisplacementFindings
from overturning.findings.surveys import SurveyFindings
from overturning.findings.values import FindingBaseClass


class SurveyCommandResults(FindingBaseClass):
    """Results that the commands `overturning survey` and `overturning backwards` print."""

    observed_surveys: list[ObservedSurveyFindings] = Field(default_factory=list)
    surveys: list[SurveyFindings] = Field(default_factory=list)
    inferred_motions: list[InferredMotionOfSurvey] = Field(default_factory=list)
    survey_displacements: list[SurveyDisplacementFindings] = Field(default_factory=list)
