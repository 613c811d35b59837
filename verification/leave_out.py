"""What is left out, counted on the default study's records: the work saved, and that no flag and no side changes."""

import numpy as np

from overturning.dem.run import run_cases
from verification.inputs import half_grid, near_fault
from verification.measures import percent
from verification.tables import Figure

AZIMUTHS = 18


def counts(azimuths: int = AZIMUTHS) -> list[Figure]:
    """Rows of the table in the docs."""
    cases, motions = half_grid(azimuths), near_fault()
    below = np.asarray(cases.friction) < np.asarray(cases.b_over_h)
    short = {name: run_cases(motion, cases, threads=2) for name, motion in motions.items()}
    full = {name: run_cases(motion, cases, threads=2, leave_out=False) for name, motion in motions.items()}
    steps, all_steps = (sum(int(one.block_steps.sum()) for one in run.values()) for run in (short, full))
    flags = [(short[name].overturned, one.overturned) for name, one in full.items()]
    moves = {name: one.block_steps > 0 for name, one in short.items()}
    return [
        Figure("cases, mirrored half left out", cases.size * len(motions)),
        Figure("of them above a threshold, so computed", sum(int(one.sum()) for one in moves.values())),
        Figure("block steps, of those with nothing left out", percent(steps, all_steps), "%"),
        Figure("flags changed by leaving out", sum(int(((a != 0) != (b != 0)).sum()) for a, b in flags), "", "0"),
        Figure("sides changed by leaving out", sum(int((a != b).sum()) for a, b in flags), "", "0"),
        Figure("moving cases with μ < B/H", sum(int((one & below).sum()) for one in moves.values())),
        Figure("of them fallen", sum(int((one.overturned[below] != 0).sum()) for one in short.values())),
        Figure("their largest rotation over α", max(float(one.peak_rotation[below].max()) for one in short.values())),
    ]
