"""Status of a case."""

from overturning.model.status import CaseStatus


def test_a_case_has_an_outcome_if_it_ended_or_nothing_moves() -> None:
    assert [one.name for one in CaseStatus if one.has_outcome] == ["SIMULATED", "AT_REST"]
