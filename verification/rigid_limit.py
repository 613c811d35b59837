"""Error and cost over the contact's stiffness, damping and step: what the default contact and step were read from.

Every fourth record of the default study, against the stiffest contact in an eighth of the longest step. Then what
changes from one computation to another: with finer steps, with stiffer springs, and under a shaking changed in its
ninth digit, which no computation settles. Then over the damping ratio in the three kernels, on blocks that do not
slide, against Housner's rocking block. Run it with ``python -m verification.rigid_limit``; it takes about two and a
half minutes. With the folder of another checkout its default gets a row, too.
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
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.cases import SpaceCases
from overturning.dem.body.run import run_in_space
from overturning.dem.numerics import Numerics
from overturning.dem.run import run, run_cases
from overturning.model.cases import Cases
from overturning.model.contact import DAMPING_RATIO, STATIC_PENETRATION, Contact, VertexContact
from overturning.model.results import Results
from overturning.model.scene import gravestone
from overturning.model.shapes import shape_of
from overturning.motion.direction import direction_cosines
from overturning.motion.motion import Motion
from verification.inputs import half_grid, near_fault
from verification.measures import ROCKS, Difference, difference, percent, wrong_sides
from verification.reference.rocking import rocking_outcome
from verification.tables import markdown, publish

PENETRATIONS = (2e-5, 2e-6, 5e-7, STATIC_PENETRATION, 2e-8)
STEPS = ("0.125 stable", "0.25 stable", "0.5 stable", "auto")
REFERENCE = (2e-8, "0.125 stable")
AZIMUTHS, EVERY_RECORD = 18, 4
NUDGE = 1e-9
HEAD = (
    "δ/B", "million block steps", "processor time, s", "wrong flags, %", "wrong sides, %",
    "median error of peak rotation",
    "marked",
)  # fmt: skip
Found = dict[str, Results]
DAMPING_RATIOS = (0.5, 1.0, 2.0, DAMPING_RATIO, 4.0, 6.0, 10.0)
HEIGHTS, RATIOS, NO_SLIP = np.array([0.6, 1.6]), np.arange(0.1, 0.51, 0.05), 10.0
FIRM, OFF, SQUAT = 0.01, 0.01, 0.39
"""A flag is firm that a motion 1 % weaker or stronger keeps; a peak is off by 0.01 α; squat is B/H from 0.4."""
ELSEWHERE = """
import sys, time
import numpy as np
from overturning import Cases, Motion, run_cases
stored = np.load(sys.argv[1])
cases = Cases(*stored["cases"])
motions = [
    Motion(*stored[f"motion{i}"], sampling_interval=float(stored[f"interval{i}"])) for i in range(int(sys.argv[2]))
]
run_cases(motions[0], cases)
begin = time.process_time()
found = [run_cases(motion, cases) for motion in motions]
seconds = time.process_time() - begin
names = [name for name in sys.argv[4:] if hasattr(found[0], name)]
outcomes = {f"{name}{i}": getattr(one, name) for i, one in enumerate(found) for name in names}
np.savez(sys.argv[3], seconds=seconds, **outcomes)
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


def housner(cases: Cases, motion: Motion, azimuth: float, chosen: NDArray[np.bool_]) -> FloatArray:
    """Side and peak rotation over α of cases under the motion 1 % weaker, as it is, stronger, shape (n, 3, 2)."""
    north, east = direction_cosines(azimuth)
    along = motion.north * north + motion.east * east
    sizes = zip(np.asarray(cases.height)[chosen], np.asarray(cases.b_over_h)[chosen], strict=True)
    return np.array([
        [rocking_outcome(factor * along, motion.sampling_interval, *size) for factor in (1 - FIRM, 1.0, 1 + FIRM)]
        for size in sizes
    ])  # fmt: skip


def in_space(cases: Cases, motion: Motion, ratio: float) -> tuple[NDArray[Any], FloatArray, NDArray[Any]]:
    """Sides, peaks over α and steps of square prisms that face along the shaking, which is of one component."""
    parts = []
    for azimuth in np.unique(cases.azimuth_deg):
        chosen = np.asarray(cases.azimuth_deg) == azimuth
        north, east = direction_cosines(float(azimuth))
        along = motion.north * north + motion.east * east
        each = [np.asarray(values)[chosen] for values in (cases.height, cases.b_over_h)]
        found = run_in_space(
            shape_of("rectangle"), Motion(along, 0.0 * along, sampling_interval=motion.sampling_interval),
            SpaceCases(0.0, each[0], each[1], 1.0, NO_SLIP), contact=VertexContact(damping_ratio=ratio),
        )  # fmt: skip
        ahead = np.where(np.cos(np.radians(found.fall_azimuth)) > 0, 1, -1)
        parts.append((np.where(found.overturned == 1, ahead, found.overturned), found.peak_tilt, found.block_steps))
    sides, tilts, steps = (np.concatenate(part) for part in zip(*parts, strict=True))
    return sides, np.radians(tilts) / np.arctan(np.asarray(cases.b_over_h)), steps


def damping_ratios(motions: dict[str, Motion]) -> str:
    """Table of what each damping ratio leaves of Housner's answers, in the three kernels."""
    axes = np.meshgrid(np.arange(1.24, 180.0, 15.0), HEIGHTS, RATIOS, indexing="ij")
    azimuth, height, ratio = (axis.ravel() for axis in axes)
    cases = Cases(azimuth, height, ratio, NO_SLIP)
    exact = np.concatenate([
        housner(cases, motion, float(one), azimuth == one) for motion in motions.values() for one in np.unique(azimuth)
    ])  # fmt: skip
    firm, peak = (exact[:, :, 0] == exact[:, 1:2, 0]).all(axis=1), exact[:, 1, 1]
    rocks = firm & (exact[:, 1, 0] == 0) & (peak > ROCKS)
    squat = np.tile(np.asarray(cases.b_over_h) > SQUAT, len(motions))
    lines = []
    for damping in DAMPING_RATIOS:
        cells = [f"{damping:g}"]
        for kernel in ("block", "general", "space"):
            answers: list[tuple[NDArray[Any], NDArray[Any], NDArray[Any]]] = []
            for motion in motions.values():
                if kernel == "space":
                    answers.append(in_space(cases, motion, damping))
                else:
                    numerics = Numerics(general=kernel == "general")
                    found = run(gravestone(Contact(damping_ratio=damping)), motion, cases, numerics)
                    answers.append((found.overturned.ravel(), found.peak_rotation.ravel(), found.block_steps))
            side, turned, steps = (np.concatenate(part) for part in zip(*answers, strict=True))
            stands, away = rocks & (side == 0), np.abs(turned - peak)
            off = [f"{percent((away[of] > OFF).sum(), of.sum()):.1f}" for of in (stands, stands & squat)]
            wrong = f"{(firm & (side != exact[:, 1, 0])).sum()}"
            cells.append(" / ".join([wrong, *off, f"{np.median(away[stands]):.2g}", f"{steps.sum() / 1e6:.1f}"]))
        lines.append(tuple(cells))
        print(lines[-1], flush=True)
    standing = f"{rocks.sum()} of which rock and stand, {(rocks & squat).sum()} of them squat."
    about = f"{firm.sum()} firm cells of {firm.size}, {standing}"
    return markdown(("ξ", "block", "general kernel", "body in space"), lines) + f"\n\n{about}"


def main(
    checkout: Annotated[Path | None, typer.Argument(help="folder of another state of the sources")] = None,
) -> None:
    """Measure and put the tables into the docs."""
    cases, motions = half_grid(AZIMUTHS), dict(list(near_fault().items())[::EVERY_RECORD])
    moved = {name: nudged(motion) for name, motion in motions.items()}
    run_cases(next(iter(motions.values())), half_grid(1))

    def under_contact(
        penetration: float, step: str = "auto", under: dict[str, Motion] = motions, refinement: int = 1
    ) -> Found:
        given: dict[str, Any] = {"contact": Contact(static_penetration=penetration), "refinement": refinement}
        return {name: run_cases(one, cases, time_step=step, **given) for name, one in under.items()}

    def wrong(far: Difference) -> tuple[str, str]:
        of = far.counts.cases
        return f"{percent(far.counts.flags, of):.2f}", f"{percent(wrong_sides(far.counts), of):.2f}"

    def cost(name: str, found: Found, seconds: float) -> tuple[str, ...]:
        far = difference(found, exact)
        numbers = f"{far.block_steps / 1e6:.1f}", f"{seconds:.2f}", *wrong(far), f"{np.median(far.rotation):.2g}"
        return name, *numbers, str(far.unstable)

    exact, of_all, costs = under_contact(*REFERENCE), [], []
    if checkout is not None:
        costs.append(cost("of the other checkout", *elsewhere(checkout, cases, motions)))
    for penetration in PENETRATIONS:
        cells = []
        for step in STEPS:
            begin = time.process_time()
            found = under_contact(penetration, step)
            seconds = time.process_time() - begin
            cells.append("–" if (penetration, step) == REFERENCE else " / ".join(wrong(difference(found, exact))))
        costs.append(cost(f"{penetration:g}", found, seconds))  # of the last step, which is the automatic one
        of_all.append((f"{penetration:g}", *cells))
        print(of_all[-1], costs[-1], flush=True)
    table = markdown(("δ/B", *(step.removesuffix(" stable") for step in STEPS)), of_all)
    own, finer = under_contact(STATIC_PENETRATION), under_contact(STATIC_PENETRATION, refinement=8)
    stiffer = under_contact(STATIC_PENETRATION / 4)
    pairs = {
        "the default, and steps 8 times finer": (own, finer),
        "the default, and springs 4 times stiffer": (own, stiffer),
        "steps 8 and 16 times finer": (finer, under_contact(STATIC_PENETRATION, refinement=16)),
        "springs 4 and 16 times stiffer": (stiffer, under_contact(STATIC_PENETRATION / 16)),
        "the default, and the default under the changed shaking": (own, under_contact(STATIC_PENETRATION, under=moved)),
        "steps 8 times finer, and these under the changed shaking": (
            finer,
            under_contact(STATIC_PENETRATION, under=moved, refinement=8),
        ),
    }
    changes = [(name, *wrong(difference(one, other))) for name, (one, other) in pairs.items()]
    publish({
        "rigid-limit": markdown(HEAD, costs),
        "rigid-limit-map": table,
        "damping-ratio": damping_ratios(motions),
        "chaos": markdown(("between", "flags that differ, %", "sides that differ, %"), changes),
    })  # fmt: skip


if __name__ == "__main__":
    typer.run(main)
