"""Status of a case."""

from enum import IntEnum


class CaseStatus(IntEnum):
    """Status of a simulated case: how its outcome was obtained, or why it has none."""

    SIMULATED = 0
    """Computed to the end."""
    AT_REST = 1
    """Below the thresholds of rocking and sliding for the whole record, so not computed."""
    UNDECIDED = 2
    """May still fall 20/p seconds after the record (p: rocking frequency)."""
    UNSTABLE = 3
    """Energy balance violated, rotation unbounded, or an invalid contact."""
    FAILED = 4
    """Not computed because of an error."""
    OVER_BUDGET = 5
    """Needs more block steps (time steps × free elements) than a case may take; see `NumericalOptions`."""

    @property
    def trajectory_has_known_outcome(self) -> bool:
        """True if the outcome is known: the case was simulated to its end, or the base motion is too weak."""
        return self in (CaseStatus.SIMULATED, CaseStatus.AT_REST)
