"""Outcomes of stones under the motions of the package, for ``src/overturning/surveys/library-outcomes.npz``.

The module simulates the sizes of `SHIPPED_HEIGHT_INDICES` and `SHIPPED_D_OVER_B_WITH_ZERO_FOR_ROUND`, and all B/H of
the grid, in hours of processor time. An interrupted run goes on with the motion at which it stopped: the outcomes of
each motion are stored in the folder `--folder`, under a name that contains a hash of the package's source files.
"""

from pathlib import Path
from typing import Annotated, Final

import numpy as np
import typer
from numpy.typing import NDArray

from overturning.surveys.library import candidate_motions
from overturning.surveys.stone_outcomes import (
    SHIPPED_OUTCOMES_FILE,
    SIMULATED_B_OVER_H,
    SIMULATED_D_OVER_B,
    SIMULATED_HEIGHTS_M,
    identifying_numbers_of_motion,
    load_or_simulate_outcomes,
    simulated_grid_text_to_detect_outdated_files,
)
from verification.tables import ROOT

SHIPPED_HEIGHT_INDICES: Final = slice(0, 6)
"""Heights of `SIMULATED_HEIGHTS_M` whose outcomes are shipped: those of gravestones, 0.3 to 2.28 m."""

SHIPPED_D_OVER_B_WITH_ZERO_FOR_ROUND: Final = (0.0, *SIMULATED_D_OVER_B)
"""D/B of stones whose outcomes are shipped; 0 stands for round stones."""


def simulate_stone_sizes_under_packaged_motions(
    depth_over_width: float, outcome_cache_folder: Path, threads: int
) -> tuple[NDArray[np.int64], NDArray[np.int8]]:
    """Simulate stones with one ratio of depth to width under all motions of the package.

    Returns the indices of height and B/H of each size, shape (sizes, 2), and the outcomes; the first two axes of these
    are motions and sizes.
    """
    needed = np.zeros((SIMULATED_HEIGHTS_M.size, SIMULATED_B_OVER_H.size), np.bool_)
    needed[SHIPPED_HEIGHT_INDICES] = True
    sizes: list[tuple[int, int]] = [(h, b) for h, b in np.argwhere(needed).tolist()]
    outcomes = []
    for motion in candidate_motions():
        found = load_or_simulate_outcomes(motion, depth_over_width, sizes, outcome_cache_folder, threads)
        outcomes.append(np.stack([found[f"{h}-{b}"] for h, b in sizes]))
        print(f"D/B {depth_over_width:g}: {motion.name}", flush=True)
    return np.array(sizes), np.stack(outcomes)


def main(
    folder: Annotated[Path, typer.Option(help="folder for the outcomes of each motion")] = ROOT / "results" / "library",
    threads: Annotated[int, typer.Option(min=1, help="number of threads")] = 2,
) -> None:
    """Simulate the outcomes that are shipped with the package, and write their file."""
    members: dict[str, NDArray[np.generic]] = {
        "grid": np.array(simulated_grid_text_to_detect_outdated_files()),
        "motions": np.stack([identifying_numbers_of_motion(one) for one in candidate_motions()]),
    }
    for aspect in SHIPPED_D_OVER_B_WITH_ZERO_FOR_ROUND:
        sizes, outcomes = simulate_stone_sizes_under_packaged_motions(aspect, folder, threads)
        members |= {f"sizes {aspect:g}": sizes.astype(np.int8), f"outcomes {aspect:g}": outcomes}
    np.savez_compressed(SHIPPED_OUTCOMES_FILE, allow_pickle=False, **members)


if __name__ == "__main__":
    typer.run(main)
