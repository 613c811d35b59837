"""`python -m verification.faults`: fifty faults, each followed by the one command, and whether the cube is the same."""

import os
import random
import shutil
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Final

import typer

from overturning.study.resume import DAMAGED
from verification.faults.kinds import KINDS, STUDY, Kind, mounts_undone
from verification.project import Project
from verification.tables import markdown, publish

SEED: Final = 18


def objection(kind: Kind, place: Project, dice: random.Random, seconds: float, wanted: bytes, brief: bool) -> str:
    """Do a fault to a place and run the command, and but for a brief look once more; what is wrong then, or nothing."""
    with mounts_undone(place):
        try:
            damaged = kind.fault(place, dice, seconds)
        except AssertionError as other:
            return f"while it lasted: {other}"
        done = place.run()
        if done.returncode:
            return f"the command failed: {done.stderr[-2000:]}"
        if damaged and f"{DAMAGED}{damaged}" not in done.stderr:
            return f"{damaged}: damage was not noticed: {done.stderr}"
        if place.cube.read_bytes() != wanted:
            return "another cube"
        if not brief and "Nothing to be done" not in (more := place.run()).stdout:
            return f"a further run does something: {more.stdout}{more.stderr}"
    return ""


def put(
    kinds: Sequence[tuple[Kind, int]], folder: Path, seed: int = SEED, brief: bool = False
) -> dict[str, tuple[int, int]]:
    """Put faults of each kind to a study; print a line of each; return how many of how many of a kind it outlived.

    A brief look uses the kernels that are there and does not ask whether a further run has nothing to do.
    """
    options = ("--cores", "1", "--set-scatter", "sweep=2")
    study, dice = Project(folder / "study", STUDY, *options, own_kernels=not brief), random.Random(seed)
    seconds = _undisturbed(study)
    wanted = study.cube.read_bytes()
    fresh = study.copied(folder / "fresh")
    for name in ("results", ".snakemake"):
        shutil.rmtree(fresh.folder / name)
    if not brief:  # the kernels have been compiled now
        again = fresh.copied(folder / "again")
        seconds = _undisturbed(again)
        assert again.cube.read_bytes() == wanted
    found = {}
    for kind, times in kinds:
        if kind.root and os.geteuid():
            print(f"{kind.says}: left out, since only root may mount a file system")
            continue
        good = 0
        for _ in range(times):
            place = (study if kind.finished else fresh).copied(folder / "place")
            wrong = objection(kind, place, dice, seconds, wanted, brief)
            good += not wrong
            print(f"{kind.says}: {wrong or 'the same cube'}", flush=True)
        found[kind.says] = good, times
    return found


def _undisturbed(place: Project) -> float:
    """Run the study and return how long that takes, s."""
    begin = time.monotonic()
    done = place.run()
    if done.returncode:
        raise SystemExit(f"the study does not run without a fault:\n{done.stderr}")
    return time.monotonic() - begin


def main(
    seed: Annotated[int, typer.Option(help="seed of moments, files and bytes")] = SEED,
    page: Annotated[bool, typer.Option(help="put the outcome into the docs")] = True,
) -> None:
    """Put all faults to the study."""
    with tempfile.TemporaryDirectory() as folder:
        found = put([(kind, kind.times) for kind in KINDS], Path(folder), seed)
        good, total = map(sum, zip(*found.values(), strict=True))
        print(f"{good} of {total}")
        if page:
            rows = [
                (says, f"{fine} of {times}") for says, (fine, times) in {**found, "all faults": (good, total)}.items()
            ]
            publish({"faults": markdown(("fault", "survived"), rows)})
    if good < total:
        raise SystemExit(1)


if __name__ == "__main__":
    typer.run(main)
