"""Status of a case."""

from overturning.model.status import CaseStatus


def test_only_cases_simulated_to_the_end_or_at_rest_have_an_outcome() -> None:
    assert [one.name for one in CaseStatus if one.trajectory_has_known_outcome] == ["SIMULATED", "AT_REST"]
