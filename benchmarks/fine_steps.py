"""What the steps after a change of contact give: the centred scheme with one thing changed at a time, on real records.

Run it with ``python -m benchmarks.fine_steps``. Each variant is compiled in a process of its own, into an empty cache.
"""

import json
import os
import subprocess
import sys
import tempfile
import time

import numpy as np

from benchmarks.study_records import ROOT, half_grid, near_fault

VARIANTS: dict[str, dict[str, float]] = {
    "as it is": {},
    "one tick for half as long": {"EARLY_TICKS": 16.0},
    "one tick for twice as long": {"EARLY_TICKS": 64.0},
    "then steps twice as long": {"LATE_STEP": 8},
    "then steps half as long": {"LATE_STEP": 2},
    "fine steps for two whole steps": {"SETTLING": 10.0},
    "half the tail": {"TAIL": 4.0, "LEAST_TAIL": 1.0},
    "twice the tail": {"TAIL": 16.0, "LEAST_TAIL": 4.0},
    "half as many ticks": {"TICKS": 64, "EARLY_TICKS": 16.0, "LATE_STEP": 2, "TAIL_STEP": 16},
    "no step done once more, only shorter": {"MOST_TRIES": 0.0},
    "up to four tries": {"MOST_TRIES": 4.0},
}  # fmt: skip
REFERENCE = "0.03125 stable"


def measure(changes: dict[str, float], folder: str) -> None:
    """Run a variant and leave its answers in a file; the first run of all is the reference."""
    from overturning.dem import columns

    for name, value in changes.items():
        setattr(columns, name, value)
    from overturning.dem.run import run_cases
    from overturning.dem.status import Status

    cases, motions = half_grid(12), dict(list(near_fault().items())[::4])
    reference = f"{folder}/reference.npz"
    run_cases(next(iter(motions.values())), half_grid(2))
    if not os.path.exists(reference):
        np.savez(
            reference,
            **{
                f"{name}-{key}": getattr(found, key)
                for name, motion in motions.items()
                for found in [run_cases(motion, cases, time_step=REFERENCE, threads=2)]
                for key in ("overturned", "peak_rotation")
            },
        )
    fine = np.load(reference)
    start = time.process_time()
    results = {name: run_cases(motion, cases) for name, motion in motions.items()}
    seconds = time.process_time() - start
    flags = sides = cells = marked = 0
    errors, energy = [], []
    for name, found in results.items():
        exact = fine[f"{name}-overturned"]
        known = (found.overturned > -128) & (exact > -128)
        cells, marked = cells + known.sum(), marked + (found.status == Status.UNSTABLE).sum()
        flags += ((found.overturned != 0) != (exact != 0))[known].sum()
        sides += (found.overturned != exact)[known].sum()
        stands = known & (found.overturned == 0) & (exact == 0) & (fine[f"{name}-peak_rotation"] > 0.05)
        errors.append(np.abs(found.peak_rotation - fine[f"{name}-peak_rotation"])[stands])
        energy.append(found.energy_error[found.status == 0])
    error = np.concatenate(errors)
    row = [
        f"{sum(r.block_steps.sum() for r in results.values()) / 1e6:.1f}", f"{seconds:.2f}",
        f"{100 * flags / cells:.2f}", f"{100 * sides / cells:.2f}", f"{np.median(error):.2g}",
        f"{np.quantile(error, 0.9):.2g}", str(marked), f"{np.concatenate(energy).max():.2g}",
    ]  # fmt: skip
    print(json.dumps(row))


def main() -> None:
    """Measure each variant and put the table into the docs."""
    from benchmarks.bench import insert

    lines = [
        "| | million block steps | processor time, s | wrong flags, % | wrong sides, % | median error of peak rotation "
        "| 90th percentile | marked | largest energy error |",
        "|---" * 9 + "|",
    ]
    with tempfile.TemporaryDirectory() as folder:
        for name, changes in VARIANTS.items():
            environment = {**os.environ, "NUMBA_CACHE_DIR": f"{folder}/{len(lines)}"}
            command = [sys.executable, "-m", "benchmarks.fine_steps", json.dumps(changes), folder]
            done = subprocess.run(command, cwd=ROOT, env=environment, check=True, capture_output=True, text=True)
            lines.append(f"| {name} | " + " | ".join(json.loads(done.stdout)) + " |")
            print(lines[-1], flush=True)
    insert(ROOT / "docs" / "method.md", "fine-steps", "\n".join(lines))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        measure(json.loads(sys.argv[1]), sys.argv[2])
    else:
        main()
