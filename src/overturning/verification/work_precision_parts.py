"""The parts of error against run time, which can be computed beside one another."""

from collections.abc import Callable
from typing import Any, Final

from overturning.verification.finer_steps import against_finer_steps, energy_balance, over_stiffness
from overturning.verification.rigid_solutions import against_exact_sliding, against_rigid_rocking
from overturning.verification.work_precision import Say

PARTS: Final[dict[str, Callable[[Say], list[dict[str, Any]]]]] = {
    "sliding": lambda say: against_finer_steps("sliding", say),
    "rocking": lambda say: against_finer_steps("rocking", say),
    "stiffness": lambda say: over_stiffness("rocking", say) + over_stiffness("sliding", say),
    "rigid": lambda say: against_rigid_rocking(say) + against_exact_sliding(say),
    "energy": energy_balance,
}
"""Rows of the table by name of the part."""
