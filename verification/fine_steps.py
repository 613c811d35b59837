"""What the steps after a change of contact give: the centred scheme with one thing changed at a time, on real records.

Run it with ``python -m verification.fine_steps``. Each variant is compiled in a process of its own, into an empty
cache.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from verification.tables import ROOT, markdown, publish

VARIANTS: dict[str, dict[str, float]] = {
    "as it is": {},
    "finest step half as long": {"finest": 0.04},
    "finest step twice as long": {"finest": 0.16},
    "every change in a finest step": {"GENTLE": 0.0},
    "four steps of each length": {"dwell": 4.0},
    "sixteen steps of each length": {"dwell": 16.0},
    "whole steps while standing": {"RIGID": 1e9},
    "no step done once more, only shorter": {"tries": 0.0},
}  # fmt: skip
HEAD = (
    "", "million block steps", "processor time, s", "wrong flags, %", "wrong sides, %", "median error of peak rotation",
    "90th percentile", "marked", "largest energy error",
)  # fmt: skip
REFERENCE = "0.125 stable"


def measure(changes: dict[str, float], reference: Path, azimuths: int = 6, every_record: int = 4) -> list[str]:
    """Run a variant in this process, before the kernel is imported; the first run leaves the reference in a file."""
    from overturning.dem.kernel import clock

    pace: dict[str, Any] = {name: value for name, value in changes.items() if name in clock.Pace._fields}
    setattr(clock, "BLOCK", clock.BLOCK._replace(**pace))  # noqa: B010, a constant but for this
    from overturning.dem.block import state

    for name, value in changes.items() - pace.items():
        if not hasattr(state, name):
            raise ValueError(f"the kernel has no constant {name}")
        setattr(state, name, value)
    from overturning.dem.run import run_cases
    from overturning.model.results import Results
    from verification.inputs import half_grid, near_fault
    from verification.measures import difference, percent, wrong_sides

    cases, motions = half_grid(azimuths), dict(list(near_fault().items())[::every_record])
    run_cases(next(iter(motions.values())), half_grid(2))
    names = Results.__dataclass_fields__
    if not reference.exists():
        exact = {name: run_cases(motion, cases, time_step=REFERENCE, threads=2) for name, motion in motions.items()}
        kept = {f"{name}-{key}": getattr(one, key) for name, one in exact.items() for key in names}
        np.savez(reference, allow_pickle=False, **kept)
    with np.load(reference) as arrays:
        exact = {name: Results(**{key: arrays[f"{name}-{key}"] for key in names}) for name in motions}
    start = time.process_time()
    found = {name: run_cases(motion, cases) for name, motion in motions.items()}
    seconds = time.process_time() - start
    far = difference(found, exact)
    return [
        f"{far.block_steps / 1e6:.1f}", f"{seconds:.2f}", f"{percent(far.counts.flags, far.counts.cases):.2f}",
        f"{percent(wrong_sides(far.counts), far.counts.cases):.2f}", f"{np.median(far.rotation):.2g}",
        f"{np.quantile(far.rotation, 0.9):.2g}", str(far.unstable), f"{far.energy_error:.2g}",
    ]  # fmt: skip


def main() -> None:
    """Measure each variant and put the table into the docs."""
    lines: list[tuple[str, ...]] = []
    with tempfile.TemporaryDirectory() as folder:
        for name, changes in VARIANTS.items():
            environment = {**os.environ, "NUMBA_CACHE_DIR": f"{folder}/{len(lines)}"}
            command = [sys.executable, "-m", "verification.fine_steps", json.dumps(changes), f"{folder}/reference.npz"]
            done = subprocess.run(command, cwd=ROOT, env=environment, check=True, capture_output=True, text=True)
            lines.append((name, *json.loads(done.stdout)))
            print(*lines[-1], sep=" | ", flush=True)
    publish({"fine-steps": markdown(HEAD, lines)})


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measure(json.loads(sys.argv[1]), Path(sys.argv[2]))))
    else:
        main()
