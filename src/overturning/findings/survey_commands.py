"""Results that the commands on surveys print."""

from pydantic import Field

from overturning.findings.inferred_motion import InferredMotionOfSurvey
from overturning.findings.observed import ObservedSurveyFindings
from overturning.findings.survey_displacements import SurveyFallAndDisplacementFindings
from overturning.findings.surveys import SurveyPredictionFindings
from overturning.findings.values import FindingBaseClass


class ResultsPrintedBySurveyCommands(FindingBaseClass):
    """Results that the commands `overturning survey` and `overturning backwards` print."""

    observed_surveys: list[ObservedSurveyFindings] = Field(default_factory=list)
    surveys: list[SurveyPredictionFindings] = Field(default_factory=list)
    inferred_motions: list[InferredMotionOfSurvey] = Field(default_factory=list)
    survey_displacements: list[SurveyFallAndDisplacementFindings] = Field(default_factory=list)
