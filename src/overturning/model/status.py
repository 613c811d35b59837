"""How the outcome of a case came about."""

from enum import IntEnum


class Status(IntEnum):
    """How a cell's flag was found, or why it is missing."""

    SIMULATED = 0
    """Computed to the end."""
    AT_REST = 1
    """Below the thresholds of rocking and sliding for the whole record, so not computed."""
    UNDECIDED = 2
    """Neither fallen nor at rest 20/p seconds after the record."""
    UNSTABLE = 3
    """Energy balance lost, rotation without bound, or a contact left."""
    FAILED = 4
    """Not computed because of an error."""
    OVER_BUDGET = 5
    """Needs more block steps than the budget of a case."""
