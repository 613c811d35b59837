"""What is left out, counted on the default study's records: the work saved, and that no flag and no side changes."""

import numpy as np

from benchmarks.study_records import half_grid, near_fault
from overturning.dem.run import run_cases

AZIMUTHS = 18


def counts() -> list[tuple[str, float, str, str]]:
    """Rows of the table in docs/method.md."""
    cases, motions = half_grid(AZIMUTHS), near_fault()
    below = np.asarray(cases.friction) < np.asarray(cases.b_over_h)
    moving = flags = sides = steps = all_steps = unable = fallen = 0
    rocking = 0.0
    for motion in motions.values():
        short = run_cases(motion, cases, threads=2)
        full = run_cases(motion, cases, threads=2, leave_out=False)
        moves = short.block_steps > 0
        moving += int(moves.sum())
        flags += int(((short.overturned != 0) != (full.overturned != 0)).sum())
        sides += int((short.overturned != full.overturned).sum())
        steps, all_steps = steps + int(short.block_steps.sum()), all_steps + int(full.block_steps.sum())
        unable += int((moves & below).sum())
        fallen += int((short.overturned[below] != 0).sum())
        rocking = max(rocking, float(short.peak_rotation[below].max()))
    return [
        ("cases, mirrored half left out", cases.size * len(motions), "", ""),
        ("of them above a threshold, so computed", moving, "", ""),
        ("block steps, of those with nothing left out", 100 * steps / all_steps, "%", ""),
        ("flags changed by leaving out", flags, "", "0"),
        ("sides changed by leaving out", sides, "", "0"),
        ("moving cases with μ < B/H", unable, "", ""),
        ("of them fallen", fallen, "", ""),
        ("their largest rotation over α", rocking, "", ""),
    ]
