"""Error and cost over the contact's stiffness and the step: what the default contact and step were read from.

Every fourth record of the default study, against the stiffest contact in an eighth of the longest step. Then what changes from
one computation to another: with finer steps, with stiffer springs, and under a shaking changed in its ninth digit, which no
computation settles. Run it with ``python -m verification.rigid_limit``; it takes about a minute and a half. With the folder of
another checkout its default gets a row, too.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from overturning.dem.cases import Cases
from overturning.dem.contact import STATIC_PENETRATION, Contact
from overturning.dem.results import Results
from overturning.dem.run import run_cases
from overturning.motion.motion import Motion
from verification.inputs import half_grid, near_fault
from verification.measures import Difference, difference, percent, wrong_sides
from verification.tables import markdown, publish

PENETRATIONS = (2e-5, 2e-6, 5e-7, STATIC_PENETRATION, 2e-8)
STEPS = ("0.125 stable", "0.25 stable", "0.5 stable", "auto")
REFERENCE = (2e-8, "0.125 stable")
AZIMUTHS, EVERY_RECORD = 18, 4
NUDGE = 1e-9
HEAD = (
    "δ/B", "million block steps", "processor time, s", "wrong flags, %", "wrong sides, %", "median error of peak rotation",
    "marked",
)  # fmt: skip
Found = dict[str, Results]
ELSEWHERE = """
import sys, time
import numpy as np
from overturning import Cases, Motion, run_cases
stored = np.load(sys.argv[1])
cases = Cases(*stored["cases"])
motions = [Motion(*stored[f"motion{i}"], sampling_interval=float(stored[f"interval{i}"])) for i in range(int(sys.argv[2]))]
run_cases(motions[0], cases)
begin = time.process_time()
found = [run_cases(motion, cases) for motion in motions]
seconds = time.process_time() - begin
names = [name for name in sys.argv[4:] if hasattr(found[0], name)]
np.savez(sys.argv[3], seconds=seconds, **{f"{name}{i}": getattr(one, name) for i, one in enumerate(found) for name in names})
"""
"""What another checkout runs; the overturned flags and the rest as the names after the output file."""


def nudged(motion: Motion) -> Motion:
    """The motion, stronger by `NUDGE`."""
    return Motion((1 + NUDGE) * motion.north, (1 + NUDGE) * motion.east, sampling_interval=motion.sampling_interval)


def elsewhere(checkout: Path, cases: Cases, motions: dict[str, Motion]) -> tuple[Found, float]:
    """Answers of another checkout at its default contact and step, and processor time, s."""
    names = list(Results.__dataclass_fields__)
    inputs = {"cases": np.stack([cases.azimuth_deg, cases.height, cases.b_over_h, cases.friction])}
    for i, motion in enumerate(motions.values()):
        inputs |= {
            f"motion{i}": np.stack([motion.north, motion.east]),
            f"interval{i}": np.array(motion.sampling_interval),
        }
    with tempfile.TemporaryDirectory() as scratch:
        given, made = f"{scratch}/inputs.npz", f"{scratch}/found.npz"
        np.savez(given, allow_pickle=False, **inputs)
        command = [sys.executable, "-c", ELSEWHERE, given, str(len(motions)), made, *names]
        environment = os.environ | {"PYTHONPATH": str((checkout / "src").resolve())}
        subprocess.run(command, env=environment, cwd=scratch, check=True)
        with np.load(made) as arrays:
            found = {
                name: Results(**{key: arrays[f"{key}{i}"] for key in names if f"{key}{i}" in arrays})
                for i, name in enumerate(motions)
            }
            return found, float(arrays["seconds"])


def main(
    checkout: Annotated[Path | None, typer.Argument(help="folder of another state of the sources")] = None,
) -> None:
    """Measure and put the tables into the docs."""
    cases, motions = half_grid(AZIMUTHS), dict(list(near_fault().items())[::EVERY_RECORD])
    moved = {name: nudged(motion) for name, motion in motions.items()}
    run_cases(next(iter(motions.values())), half_grid(1))

    def run(penetration: float, step: str = "auto", under: dict[str, Motion] = motions, refinement: int = 1) -> Found:
        given: dict[str, Any] = {"contact": Contact(static_penetration=penetration), "refinement": refinement}
        return {name: run_cases(one, cases, time_step=step, **given) for name, one in under.items()}

    def wrong(far: Difference) -> tuple[str, str]:
        of = far.counts.cases
        return f"{percent(far.counts.flags, of):.2f}", f"{percent(wrong_sides(far.counts), of):.2f}"

    def cost(name: str, found: Found, seconds: float) -> tuple[str, ...]:
        far = difference(found, exact)
        numbers = f"{far.block_steps / 1e6:.1f}", f"{seconds:.2f}", *wrong(far), f"{np.median(far.rotation):.2g}"
        return name, *numbers, str(far.unstable)

    exact, of_all, costs = run(*REFERENCE), [], []
    if checkout is not None:
        costs.append(cost("of the other checkout", *elsewhere(checkout, cases, motions)))
    for penetration in PENETRATIONS:
        cells = []
        for step in STEPS:
            begin = time.process_time()
            found = run(penetration, step)
            seconds = time.process_time() - begin
            cells.append("–" if (penetration, step) == REFERENCE else " / ".join(wrong(difference(found, exact))))
        costs.append(cost(f"{penetration:g}", found, seconds))  # of the last step, which is the automatic one
        of_all.append((f"{penetration:g}", *cells))
        print(of_all[-1], costs[-1], flush=True)
    table = markdown(("δ/B", *(step.removesuffix(" stable") for step in STEPS)), of_all)
    own, finer = run(STATIC_PENETRATION), run(STATIC_PENETRATION, refinement=8)
    stiffer = run(STATIC_PENETRATION / 4)
    pairs = {
        "the default, and steps 8 times finer": (own, finer),
        "the default, and springs 4 times stiffer": (own, stiffer),
        "steps 8 and 16 times finer": (finer, run(STATIC_PENETRATION, refinement=16)),
        "springs 4 and 16 times stiffer": (stiffer, run(STATIC_PENETRATION / 16)),
        "the default, and the default under the changed shaking": (own, run(STATIC_PENETRATION, under=moved)),
        "steps 8 times finer, and these under the changed shaking": (
            finer,
            run(STATIC_PENETRATION, under=moved, refinement=8),
        ),
    }
    changes = [(name, *wrong(difference(one, other))) for name, (one, other) in pairs.items()]
    publish({
        "rigid-limit": markdown(HEAD, costs),
        "rigid-limit-map": table,
        "chaos": markdown(("between", "flags that differ, %", "sides that differ, %"), changes),
    })  # fmt: skip


if __name__ == "__main__":
    typer.run(main)
