"""Error against time of a stacked grave over the step, beside that of another checkout.

The 96 cases of the sweep in `verification.scene_speed`, nothing left out, each checkout in a process of its own, errors
against a twentieth of its own default step. Run it with ``python -m verification.scene_steps CHECKOUT``, the folder of
another state of the sources; without one only this state's rows are made.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import typer

from verification.inputs import near_field
from verification.scene_speed import SHAFT
from verification.tables import ROOT, markdown, publish

BEFORE: Final = ("auto", "0.25 stable", "0.125 stable")
NOW: Final = ("auto", "0.9 stable", "0.5 stable", "0.25 stable")
REFERENCE: Final = "0.05 stable"
SCRIPT: Final = """
import sys, time
from pathlib import Path
import numpy as np
from overturning import Motion
from overturning.model.cases import Cases
from overturning.dem.numerics import Numerics
from overturning.model.geometry import native_size
from overturning.dem.run import run
from overturning.model.scene import load_scene

stored = np.load(sys.argv[1])
motion = Motion(stored["north"], stored["east"], sampling_interval=float(stored["interval"]))
scene = load_scene("three-tier", Path(sys.argv[3]))
height, ratio = native_size(scene)
grid = np.meshgrid(np.arange(0, 360, 30.0), [height], [0.2, 0.25, 0.3, round(ratio, 10)], [0.6, 1.0], indexing="ij")
cases, found = Cases(*(axis.ravel() for axis in grid)), {}
for step in sys.argv[4:]:
    numerics = Numerics(time_step=step, leave_out=False)
    run(scene, motion, cases, numerics)
    times = []
    for _ in range(2):
        begin = time.process_time()
        results = run(scene, motion, cases, numerics)
        times.append(time.process_time() - begin)
    found |= {"flags " + step: results.overturned, "peaks " + step: results.peak_rotation, "time " + step: min(times)}
np.savez(sys.argv[2], **found)
"""
"""What each checkout runs."""


def rows_of(state: str, checkout: Path, steps: Sequence[str]) -> list[tuple[str, str, str, str]]:
    """Time per case and errors of a checkout's steps: state and step, ms, over standing elements, over the shaft."""
    motion = near_field(7)
    with tempfile.TemporaryDirectory() as scratch:
        given, made = f"{scratch}/inputs.npz", f"{scratch}/found.npz"
        np.savez(given, north=motion.north, east=motion.east, interval=motion.sampling_interval)
        environment = os.environ | {"PYTHONPATH": str((checkout / "src").resolve())}
        command = [sys.executable, "-c", SCRIPT, given, made, str(ROOT), *steps, REFERENCE]
        subprocess.run(command, env=environment, cwd=scratch, check=True)
        with np.load(made) as arrays:
            found = dict(arrays)
    flags, peaks = found[f"flags {REFERENCE}"], found[f"peaks {REFERENCE}"]
    rows = []
    for step in steps:
        stands = (flags == 0) & (found[f"flags {step}"] == 0)
        error = np.abs(found[f"peaks {step}"] / np.where(peaks > 0, peaks, np.inf) - 1)
        all_of_them, shaft = (100 * float(np.median(error[:, part][stands[:, part]])) for part in (slice(None), SHAFT))
        time = 1e3 * float(found[f"time {step}"]) / len(flags)
        rows.append(
            (f"{state}, {step.replace('auto', 'default')}", f"{time:.3g}", f"{all_of_them:.2g}", f"{shaft:.2g}")
        )
    return rows


def main(
    checkout: Annotated[Path | None, typer.Argument(help="folder of another state of the sources")] = None,
) -> None:
    """Measure, and put the table into the docs."""
    rows = [*(rows_of("before", checkout, BEFORE) if checkout else []), *rows_of("now", ROOT, NOW)]
    head = ("", "time per case, ms", "error of all peak rotations, %", "of the shaft's, %")
    print(table := markdown(head, rows))
    publish({"scene-steps": table})


if __name__ == "__main__":
    typer.run(main)
