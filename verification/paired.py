"""`python -m verification.paired FOLDER`: this checkout's kernel against another's, in alternating processes.

For a change that must not cost speed: FOLDER is a checkout of the state before it. Processor times of whole sweeps of
three default records, per scheme; a machine's speed drifts, so only the ratios within a pair of runs count.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from typing import Annotated

import numpy as np
import typer

from verification.inputs import half_grid, near_fault
from verification.tables import ROOT

RECORDS, AZIMUTHS = 3, 12

CHILD = """
import json, sys, time
import numpy as np
import overturning
stored = np.load(sys.argv[1])
cases = overturning.Cases(*stored["cases"])
motions = [
    overturning.Motion(*stored[f"motion{i}"], sampling_interval=float(stored[f"interval{i}"]))
    for i in range(int(sys.argv[2]))
]
speed = {}
for scheme in ("centred", "cundall"):
    overturning.run_cases(motions[0], cases, scheme=scheme)
    start = time.process_time()
    steps = sum(int(overturning.run_cases(motion, cases, scheme=scheme).block_steps.sum()) for motion in motions)
    speed[scheme] = [time.process_time() - start, steps]
print(json.dumps(speed))
"""


def main(
    folder: Annotated[Path, typer.Argument(help="checkout of the other state")],
    pairs: Annotated[int, typer.Option(min=1, help="pairs of runs")] = 5,
) -> None:
    """Print processor times, million block steps per second and their ratios."""
    motions, cases = list(near_fault().values())[:: 28 // RECORDS][:RECORDS], half_grid(AZIMUTHS)
    with tempfile.TemporaryDirectory() as scratch:
        stored = Path(scratch) / "inputs.npz"
        inputs = {"cases": np.stack([cases.azimuth_deg, cases.height, cases.b_over_h, cases.friction])}
        inputs |= {f"motion{i}": np.stack([motion.north, motion.east]) for i, motion in enumerate(motions)}
        inputs |= {f"interval{i}": np.array(motion.sampling_interval) for i, motion in enumerate(motions)}
        np.savez(stored, allow_pickle=False, **inputs)

        def run(checkout: Path) -> dict[str, list[float]]:
            command = [sys.executable, "-c", CHILD, str(stored), str(RECORDS)]
            environment = os.environ | {"PYTHONPATH": str((checkout / "src").resolve())}
            done = subprocess.run(command, env=environment, cwd=scratch, check=True, stdout=subprocess.PIPE, text=True)
            return dict(json.loads(done.stdout))

        runs = [(run(ROOT), run(folder)) for _ in range(pairs)]
    for scheme in runs[0][0]:
        rate = [[one[scheme][1] / one[scheme][0] / 1e6 for one in pair] for pair in runs]
        time = median(here[scheme][0] / there[scheme][0] for here, there in runs)
        print(
            f"{scheme}: {median(r[0] for r in rate):.1f} against {median(r[1] for r in rate):.1f} million block "
            "steps/s,",
            end=" ",
        )
        print(
            f"ratio of speeds {median(r[0] / r[1] for r in rate):.3f}, of times {time:.3f} (medians of {pairs} pairs)"
        )


if __name__ == "__main__":
    typer.run(main)
