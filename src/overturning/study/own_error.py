"""Part of a study run again, with finer steps and with stiffer springs: how far its answers hang on the computation.

What changes with finer steps is run again in steps half as long as those, and in those under a motion changed by less than is
known of it. An answer that stays both times is settled by a finer computation; one that changes with the motion none decides.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.numerics import Progress
from overturning.dem.variables import INT8_MISSING
from overturning.errors import ArgumentError
from overturning.records.record import Record
from overturning.study.choice import Sample
from overturning.study.comparison import compare, differ
from overturning.study.config import Study
from overturning.study.grid import grid_of
from overturning.study.repetition import FINER, NUDGE, STIFFER, Again, cases_of, repetitions
from overturning.study.scenes import motion_of

WARN_ABOVE: Final = 0.01
"""Share of changed flags above which the report warns; those are not counted where the ensemble is divided anyway."""

KINDS: Final = ("finer", "stiffer")

PILOT: Final = 16
"""Cases that tell what a case costs before more are run."""

FINER_OVER_STIFFER: Final = 9.0
"""Block steps of the first repetition over those of the second, at most: 8 over 1, and what is done once more."""


def is_verified(study: Study) -> bool:
    """Whether a part of the study is to be run again."""
    return study.verification != "none"


def repeat_sample(
    study: Study,
    records: Sequence[Record],
    sample: Sample,
    study_block_steps: int,
    threads: int = 1,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Run chosen cases again, with finer steps and with stiffer springs, as many as cost no more than is allowed.

    The stiffer repetition goes first, in growing parts: its block steps tell what the finer one will cost. The finer one
    takes the first cases of the same random order, as many as the rest of the allowance pays for, and both are counted on
    these. The records are the processed ones in the study's order; `progress` is called with the cases done and all cases
    of both repetitions. The counts and block steps do not depend on the number of threads.
    """
    settings = study.verification
    assert not isinstance(settings, str)  # the workflow does not ask for it
    allowed = round(settings.cost * study_block_steps)
    runs = _Runs(study, records, sample, threads, progress)
    first, factor = "stiffer", 1.0 + FINER_OVER_STIFFER
    if not _run_affordable(runs, first, factor, allowed):
        # Springs four times stiffer may be beyond what numbers hold: the finer steps alone then.
        first, factor = "finer", 1.0
        _run_affordable(runs, first, factor, allowed)
    spent = runs.block_steps[first]
    rest = allowed - int(spent.sum())
    count = len(spent)
    if first == "stiffer":
        count = int(np.searchsorted(np.cumsum(FINER_OVER_STIFFER * spent), rest, side="right"))
        runs.run("finer", count)
    elements = grid_of(study).element or ("",)
    found: dict[str, Any] = {
        "seed": settings.seed,
        "wanted": sample.size,
        "chosen": count,
        "at_rest": int((sample.status[:count] == 1).sum()),
        "cells": len(records) * grid_of(study).size,
        "study_block_steps": study_block_steps,
        "cost": settings.cost,
        "finer_by": FINER,
        "stiffer_by": STIFFER,
    }
    for kind in KINDS:
        if kind in runs.refused:
            found[kind] = {"refused": runs.refused[kind]}
            continue
        answers = runs.overturned[kind][:count]
        azimuths = None if sample.azimuth is None else (sample.azimuth[:count], runs.azimuth[kind][:count])
        outcomes = []
        for column, name in enumerate(elements):
            own, other, sure = sample.overturned[:count, column], answers[:, column], ~sample.divided[:count, column]
            counts = asdict(compare(own, other, azimuths))
            outcomes.append({"element": name, **counts, "flags_undivided": compare(own[sure], other[sure]).flags})
        found[kind] = {"block_steps": int(runs.block_steps[kind].sum()), "outcomes": outcomes}
    done = sum(int(steps.sum()) for steps in runs.block_steps.values())
    found["settling"] = runs.settle(count, allowed - done)
    return found


def _run_affordable(runs: "_Runs", kind: str, factor: float, allowed: int) -> bool:
    """Run the first cases, until what all repetitions of them cost, `factor` times this one, reaches the allowance."""
    size = min(PILOT, runs.sample.size, max(runs.sample.computed // 12, 1))
    while size > 0:
        done = len(runs.block_steps[kind]) + size
        if not runs.run(kind, done):
            return False
        mean = factor * float(runs.block_steps[kind].mean())
        affordable = runs.sample.size if mean == 0 else min(runs.sample.size, int(0.95 * allowed / mean))
        size = min(affordable - done, 3 * done)
    return True


class _Runs:
    """Repetitions of the first cases of a sample, kept as they grow."""

    def __init__(
        self, study: Study, records: Sequence[Record], sample: Sample, threads: int, progress: Progress | None
    ) -> None:
        self.sample, self.threads, self.progress = sample, threads, progress
        self.motions = [motion_of(study, record) for record in records]
        self.repetitions: Mapping[str, Again] = repetitions(study)
        self.axes = [axis.astype(np.float64) for axis in grid_of(study).coordinates().values()]
        self.cases = cases_of(study)
        nothing = np.zeros((0, sample.overturned.shape[1]), np.int8)
        self.overturned: dict[str, NDArray[np.int8]] = dict.fromkeys(KINDS, nothing)
        self.azimuth: dict[str, NDArray[np.float32]] = dict.fromkeys(KINDS, np.zeros(0, np.float32))
        self.block_steps: dict[str, NDArray[np.int64]] = dict.fromkeys(KINDS, np.zeros(0, np.int64))
        self.refused: dict[str, str] = {}

    def run(self, kind: str, until: int) -> bool:
        """Go on until so many cases have been run again; False where they are refused."""
        try:
            overturned, block_steps, azimuth = self._again(kind, np.arange(len(self.block_steps[kind]), until))
        except ArgumentError as error:
            self.refused[kind] = str(error)
            return False
        self.overturned[kind] = np.concatenate([self.overturned[kind], overturned])
        self.azimuth[kind] = np.concatenate([self.azimuth[kind], azimuth])
        self.block_steps[kind] = np.concatenate([self.block_steps[kind], block_steps])
        if self.progress:
            self.progress(sum(map(len, self.block_steps.values())), 2 * self.sample.size)
        return True

    def _again(
        self, kind: str, rows: NDArray[np.int64], amplitude: float = 1.0
    ) -> tuple[NDArray[np.int8], NDArray[np.int64], NDArray[np.float32]]:
        """Flags, block steps and, in space, fall azimuths of some cases run again, under motions of an amplitude."""
        overturned = np.zeros((rows.size, self.sample.overturned.shape[1]), np.int8)
        block_steps, towards = np.zeros(rows.size, np.int64), np.full(rows.size, np.nan, np.float32)

        def one(number: int) -> None:
            mine = self.sample.record[rows] == number
            chosen = self.sample.index[rows[mine]]
            columns = (axis[chosen[:, column]] for column, axis in enumerate(self.axes))
            results = self.repetitions[kind](self.motions[number], self.cases(*columns, amplitude=amplitude))
            overturned[mine] = results.overturned.reshape(overturned[mine].shape)
            block_steps[mine], towards[mine] = results.block_steps, getattr(results, "fall_azimuth", np.nan)

        with ThreadPoolExecutor(max_workers=self.threads) as pool:
            list(pool.map(one, np.unique(self.sample.record[rows]).tolist()))
        return overturned, block_steps, towards

    def settle(self, count: int, allowed: int) -> dict[str, int]:
        """How many of the first cases change with finer steps; of these, as far as allowed, how many keep that answer or lose it."""
        finer, own = self.overturned["finer"][:count], self.sample.overturned[:count]
        known = ((finer != INT8_MISSING) & (own != INT8_MISSING)).all(axis=1)
        towards, before = self.azimuth["finer"][:count], self.sample.azimuth
        changed = np.flatnonzero(known & differ(finer, own, None if before is None else (towards, before[:count])))
        # Steps half as long, and those of the finer repetition once more.
        cost = 3 * np.cumsum(self.block_steps["finer"][changed])
        rows = changed[cost <= allowed]
        runs = [self._again(kind, rows, amplitude) for kind, amplitude in (("finest", 1.0), ("finer", 1.0 + NUDGE))]
        finest_kept, kept = (
            ~differ(overturned, finer[rows], None if before is None else (azimuth, towards[rows]))
            for overturned, _, azimuth in runs
        )
        return {
            "changed": changed.size, "looked_at": rows.size, "settled": int((finest_kept & kept).sum()),
            "chaotic": int((~kept).sum()), "block_steps": sum(int(block_steps.sum()) for _, block_steps, _ in runs),
        }  # fmt: skip
