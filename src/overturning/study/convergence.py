"""Convergence check: a random part of a study computed again with finer steps and with stiffer springs.

Where blocks cannot slide, the exact rigid block stands beside the study's answers.

What changes with finer steps is computed in steps half as long as those, and in those under a motion changed by less
than is known of it. An answer that stays both times is settled by a finer computation; one that changes with the motion
none decides.
"""

import json
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError

from overturning.dem.numerics import Progress
from overturning.dem.run import run
from overturning.errors import ArgumentError, ResultError
from overturning.files import write_text
from overturning.model.cases import Cases
from overturning.model.planes import Planes
from overturning.model.results import Results
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.study.netcdf import open_raw
from overturning.study.scenes import grid_of, model_for, motion_of, numerics_of
from overturning.study.schema import Study
from overturning.study.sections import Verification
from overturning.tables import what_is_wrong

FINER: Final = 8
"""Steps of the finer computation in each of the study's."""

STIFFER: Final = 4.0
"""Stiffness of the stiffer springs over the study's; finest steps are half as long for it, whole ones are not."""

NUDGE: Final = 1e-9
"""Share by which the motion is made stronger to see whether an answer hangs on less than is known of it."""

WARN_ABOVE: Final = 0.01
"""Share of changed flags above which the report warns; those are not counted where the ensemble is divided anyway."""

ASIDE: Final = 15.0
"""Degrees between two azimuths of a fall in space from which they are not the same."""

PILOT: Final = 16
"""Cases that tell what a case costs before more are computed."""

FINER_OVER_STIFFER: Final = 9.0
"""Block steps with finer steps over those with stiffer springs, at most: 8 over 1, and what is done once more."""

HOLDS: Final = 1.0
"""Friction from which a rectangular block with a smaller B/H is compared with one that cannot slide."""

MOST_RIGID: Final = 25_000
"""Cells that are, at most: two or three seconds of processor time."""

_CHANCES: Final = ("probability_towards", "probability_away", "probability_falls")
"""Variables whose sum is the share of members that fall."""

_ROUNDING: Final = 1e-6


class Counts(BaseModel):
    """How far the answers to the same cases differ."""

    cases: int  # with an answer in both
    flags: int  # of these, that fall in one answer and stand in the other
    fallen: int  # that fall in both
    sides: int  # of these, that fall to the other side, in space `ASIDE` or more away
    unanswered: int  # without an answer in one or both

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(**{name: getattr(self, name) + getattr(other, name) for name in Counts.model_fields})


class Outcome(Counts):
    """What changed of one element, whose name is empty for a block."""

    element: str
    undivided: int  # of the cases with an answer in both, those whose ensemble is not divided
    flags_undivided: int  # of these, that fall in one answer and stand in the other
    sides_undivided: int  # of these, that fall to the other side


class Rigid(Outcome):
    """How far a study's answers differ from those of the exact rigid block."""

    cells: int  # of the study, of blocks that cannot slide


class Repetition(BaseModel):
    """Cases computed again, or why they could not be."""

    block_steps: int
    outcomes: list[Outcome]
    refused: str = ""


class Settling(BaseModel):
    """Cases that changed with finer steps; of these, those looked at, that keep the answer, or lose it to a nudge."""

    changed: int
    looked_at: int
    settled: int
    chaotic: int
    block_steps: int


class Convergence(BaseModel):
    """What a convergence check found, as it is kept in ``convergence.json``."""

    seed: int
    wanted: int
    chosen: int
    at_rest: int
    cells: int
    study_block_steps: int
    cost: float
    finer_by: int
    stiffer_by: float
    finer: Repetition
    stiffer: Repetition
    settling: Settling
    rigid: Rigid | None  # none where no cell is of a block that cannot slide

    def write(self, path: Path) -> None:
        """Write it as JSON."""
        write_text(path, self.model_dump_json(indent=1) + "\n")

    @classmethod
    def read(cls, path: Path) -> "Convergence":
        """Read what `write` wrote; a `ResultError` if it is missing or torn, or says less than this version."""
        try:
            return cls.model_validate(json.loads(path.read_text(encoding="utf-8")))
        except ValidationError as error:
            first = error.errors()[0]
            key = "".join(f"{part}: " for part in [".".join(map(str, first["loc"]))] if part)
            said = f"{key}{what_is_wrong(first)}; written by another version"
        except (OSError, ValueError):
            said = "no outcome of a convergence check"
        raise ResultError(f"{path}: {said}; run the study again, which makes the convergence check anew")


Answers = NDArray[np.void]
"""Answers to cases, of which `unanswered` makes room for `overturned`, `azimuth` and `block_steps`."""


def unanswered(count: int, elements: int) -> Answers:
    """Room for answers: a flag for each element, the azimuth of a fall in space in degrees, else NaN, and the work."""
    answers = np.zeros(count, [("overturned", np.int8, (elements,)), ("azimuth", "f4"), ("block_steps", np.int64)])
    answers["azimuth"] = np.nan
    return answers


def compare(first: NDArray[np.int8], second: NDArray[np.int8], elsewhere: NDArray[np.bool_] | None = None) -> Counts:
    """Count how far two arrays of `overturned` differ: +1, −1, 0, or −128 where there is no answer.

    `elsewhere` says of each case in space whether its two falls go another way, which flags say in planes.
    """
    known = (first != INT8_MISSING) & (second != INT8_MISSING)
    fell, fell_too = first != 0, second != 0
    both = known & fell & fell_too
    other = first != second if elsewhere is None else (first != second) | elsewhere
    counted = {"cases": known, "flags": known & (fell != fell_too), "fallen": both, "sides": both & other}
    return Counts(**{name: int(mask.sum()) for name, mask in (counted | {"unanswered": ~known}).items()})


def elsewhere(first: Answers, second: Answers) -> NDArray[np.bool_]:
    """Which of the bodies in space that fall in both answers go `ASIDE` or more apart; in planes none."""
    both = ((first["overturned"] == 1) & (second["overturned"] == 1)).all(axis=1)
    turn = np.where(both, first["azimuth"], 0.0) - np.where(both, second["azimuth"], 0.0)
    return np.asarray(np.abs((turn + 180.0) % 360.0 - 180.0) >= ASIDE)


def differ(first: Answers, second: Answers) -> NDArray[np.bool_]:
    """Which cases have another answer, of any element; shape (n,)."""
    return (first["overturned"] != second["overturned"]).any(axis=1) | elsewhere(first, second)


@dataclass(frozen=True)
class Sample:
    """Cases in the random order in which they are computed again, with the study's answers."""

    record: NDArray[np.int64]  # position of the record, shape (n,)
    index: NDArray[np.int64]  # positions along the dimensions of the study, shape (n, 4), or (n, 5) in space
    answers: Answers
    at_rest: NDArray[np.bool_]  # those below the thresholds of rocking and sliding, shape (n,)
    divided: NDArray[np.bool_]  # some members of the ensemble fall and others stand, shape (n, elements)
    computed: int  # cases of the study that were not mirrored, nor repeated in space
    block_steps: int  # of the whole study


def choose(
    settings: Verification, records: int, computed: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Choose cells of a study at random, each at most once: of each its record, shape (n,), and its index.

    Any first part of the choice is a random choice too. Cells that are not `computed`, an array like the grid, the same
    for every record, are not chosen: they mirror others and would be the same computation again.
    """
    cells = np.argwhere(computed)
    wanted = max(settings.at_least, round(settings.share * records * computed.size))
    order = np.random.Generator(np.random.PCG64(settings.seed)).permutation(records * len(cells))[:wanted]
    return order // len(cells), cells[order % len(cells)]


def cannot_slide(study: Study) -> NDArray[np.bool_]:
    """Of which cells of the grid Housner's block is the rigid limit: rectangles of a friction from `HOLDS` on."""
    model, grid = model_for(study), grid_of(study)
    if not (isinstance(model, Planes) and model.scene.single_block):
        return np.zeros(grid.shape, np.bool_)
    own = model.scene.law(*model.scene.elements).friction
    friction = grid["friction"] if own is None else np.full(grid["friction"].size, own)
    holds = (friction >= HOLDS) & (friction > grid["b_over_h"][:, None])
    return np.broadcast_to(holds, grid.shape)


def read_sample(cube: Path, settings: Verification, among: NDArray[np.bool_] | None = None) -> Sample:
    """Choose cells of a cube and read the study's answers to them; a ResultError where the cube cannot be read.

    Of those that are computed, or of those of them that are also `among` some, an array like the grid.
    """
    with open_raw(cube, "opened", "run the study again") as file:
        records = file.dimensions["record"].size
        # The answers as recorded, where a study has its motions at several amplitudes.
        recorded = (int(np.flatnonzero(file["amplitude"][:] == 1.0)[0]),) if "amplitude" in file.dimensions else ()
        computed = file["mirrored" if "mirrored" in file.variables else "repeated"][(0, *recorded)] == 0
        computed = computed if among is None else computed & among
        record, index = choose(settings, records, computed)
        place = np.argsort(np.argsort(record, kind="stable"))

        def cells(name: str) -> NDArray[Any]:
            """Values of the chosen cells, shape (n, elements or 1); one record is in memory at a time."""
            of = [file[name][(at, *recorded)][tuple(index[record == at].T)] for at in range(records)]
            return np.concatenate(of)[place].reshape(record.size, -1)

        overturned = cells("overturned")
        answers = unanswered(*overturned.shape)
        answers["overturned"] = overturned
        if "fall_azimuth" in file.variables:
            answers["azimuth"] = cells("fall_azimuth")[:, 0]
        falls = np.zeros(overturned.shape, np.float32)
        falls += sum(cells(name) for name in _CHANCES if name in file.variables)
        divided, at_rest = (falls > 0) & (falls < 1 - _ROUNDING), cells("status")[:, 0] == 1
        return Sample(record, index, answers, at_rest, divided, records * int(computed.sum()), int(file.block_steps))


def read_rigid(cube: Path, study: Study) -> Sample | None:
    """Cells of a study's cube to compare with the exact rigid block, `MOST_RIGID` or all of fewer; none without any."""
    among = cannot_slide(study)
    settings = study.verification
    if not among.any() or isinstance(settings, str):
        return None
    return read_sample(cube, settings.model_copy(update={"share": 0.0, "at_least": MOST_RIGID}), among)


def check_convergence(
    study: Study,
    records: Sequence[Record],
    sample: Sample,
    threads: int = 1,
    progress: Progress | None = None,
    rigid: Sample | None = None,
) -> Convergence:
    """Compute chosen cases again, with finer steps and with stiffer springs, as many as cost no more than is allowed.

    The stiffer springs go first, in growing parts: their block steps tell what the finer steps will cost. These take
    the first cases of the same random order, as many as the rest of the allowance pays for, and both are counted on
    these. The processed records are in the order of the study, whose `verification` are settings; nothing that is found
    depends on the number of threads. Progress is called with the cases done and all cases of both. The cells `rigid`,
    of `read_rigid`, are compared with the exact rigid block.
    """
    settings = study.verification
    assert not isinstance(settings, str)  # the workflow does not ask for it
    allowed = round(settings.cost * sample.block_steps)
    runs = _Runs(study, records, sample, threads, progress)
    # Springs four times stiffer may be beyond what numbers hold: the finer steps alone then.
    if runs.run_affordable("stiffer", 1.0 + FINER_OVER_STIFFER, allowed):
        spent = runs.answers["stiffer"]["block_steps"]
        affordable = np.cumsum(FINER_OVER_STIFFER * spent)
        runs.run("finer", int(np.searchsorted(affordable, allowed - int(spent.sum()), side="right")))
    else:
        runs.run_affordable("finer", 1.0, allowed)
    count = len(runs.answers["finer"])
    done = sum(int(one["block_steps"].sum()) for one in runs.answers.values())
    return Convergence(
        seed=settings.seed,
        wanted=len(sample.record),
        chosen=count,
        at_rest=int(sample.at_rest[:count].sum()),
        cells=len(records) * runs.grid.size,
        study_block_steps=sample.block_steps,
        cost=settings.cost,
        finer_by=FINER,
        stiffer_by=STIFFER,
        finer=runs.outcome("finer", count),
        stiffer=runs.outcome("stiffer", count),
        settling=runs.settle(count, allowed - done),
        rigid=None if rigid is None else _Runs(study, records, rigid, threads, None).beside_rigid(),
    )


class _Runs:
    """The first cases of a sample computed again; the answers grow."""

    def __init__(
        self, study: Study, records: Sequence[Record], sample: Sample, threads: int, progress: Progress | None
    ) -> None:
        self.sample, self.threads, self.progress = sample, threads, progress
        self.motions, self.grid = [motion_of(study, record) for record in records], grid_of(study)
        from overturning.dem.block.rigid import rocking  # with it comes Numba

        self.computations: dict[str, Callable[[Motion, Cases], Any]] = {**computations(study), "rigid": rocking}
        self.answers = dict.fromkeys(("finer", "stiffer"), sample.answers[:0])
        self.refused: dict[str, str] = {}

    def run_affordable(self, kind: str, factor: float, allowed: int) -> bool:
        """Compute first cases, until `factor` times what they cost reaches what is allowed; False if refused."""
        most = len(self.sample.record)
        size = min(PILOT, most, max(self.sample.computed // 12, 1))
        while size > 0:
            done = len(self.answers[kind]) + size
            if not self.run(kind, done):
                return False
            mean = factor * float(self.answers[kind]["block_steps"].mean())
            affordable = most if mean == 0 else min(most, int(0.95 * allowed / mean))
            size = min(affordable - done, 3 * done)
        return True

    def run(self, kind: str, until: int) -> bool:
        """Continue until so many cases have been computed again; False where they are refused."""
        try:
            more = self._compute(kind, np.arange(len(self.answers[kind]), until))
        except ArgumentError as error:
            self.refused[kind] = str(error)
            return False
        self.answers[kind] = np.concatenate([self.answers[kind], more])
        if self.progress:
            self.progress(sum(map(len, self.answers.values())), 2 * len(self.sample.record))
        return True

    def _compute(self, kind: str, rows: NDArray[np.int64], amplitude: float = 1.0) -> Answers:
        """Answers to some cases under motions of an amplitude."""
        answers = np.zeros(rows.size, self.sample.answers.dtype)

        def one(number: int) -> None:
            mine = self.sample.record[rows] == number
            chosen = self.sample.index[rows[mine]]
            cases = self.grid.cases(list(chosen.T), amplitude=amplitude)
            results = self.computations[kind](self.motions[number], cases)
            answers["overturned"][mine] = results.overturned.reshape(len(chosen), -1)
            answers["azimuth"][mine] = getattr(results, "fall_azimuth", np.nan)
            answers["block_steps"][mine] = getattr(results, "block_steps", 0)

        with ThreadPoolExecutor(max_workers=self.threads) as pool:
            list(pool.map(one, np.unique(self.sample.record[rows]).tolist()))
        return answers

    def outcome(self, kind: str, count: int) -> Repetition:
        """What changed in the first cases."""
        if kind in self.refused:
            return Repetition(block_steps=0, outcomes=[], refused=self.refused[kind])
        outcomes = self._changed(self.answers[kind][:count])
        return Repetition(block_steps=int(self.answers[kind]["block_steps"].sum()), outcomes=outcomes)

    def _changed(self, again: Answers) -> list[Outcome]:
        """What is other in other answers to the first cases, of each element."""
        count, outcomes = len(again), []
        own = self.sample.answers[:count]
        away = elsewhere(own, again)
        for column, name in enumerate(self.grid.element or ("",)):
            before, after = own["overturned"][:, column], again["overturned"][:, column]
            sure = ~self.sample.divided[:count, column]
            counts, those = compare(before, after, away), compare(before[sure], after[sure], away[sure])
            undivided = {
                "undivided": those.cases, "flags_undivided": those.flags, "sides_undivided": those.sides,
            }  # fmt: skip
            outcomes.append(Outcome(element=name, **undivided, **counts.model_dump()))
        return outcomes

    def beside_rigid(self) -> Rigid:
        """How far the study's answers to all cases of the sample differ from those of the exact rigid block."""
        every = np.arange(len(self.sample.record))
        (found,) = self._changed(self._compute("rigid", every))
        return Rigid(cells=self.sample.computed, **found.model_dump())

    def settle(self, count: int, allowed: int) -> Settling:
        """What of the first cases changes with finer steps and, as far as allowed, keeps that answer or loses it."""
        own, finer = self.sample.answers[:count], self.answers["finer"][:count]
        known = ((finer["overturned"] != INT8_MISSING) & (own["overturned"] != INT8_MISSING)).all(axis=1)
        changed = np.flatnonzero(known & differ(finer, own))
        # Steps half as long, and those of the finer computation once more.
        rows = changed[3 * np.cumsum(finer["block_steps"][changed]) <= allowed]
        finest, nudged = self._compute("finest", rows), self._compute("finer", rows, 1.0 + NUDGE)
        kept = ~differ(nudged, finer[rows])
        return Settling(
            changed=changed.size,
            looked_at=rows.size,
            settled=int((~differ(finest, finer[rows]) & kept).sum()),
            chaotic=int((~kept).sum()),
            block_steps=int(finest["block_steps"].sum() + nudged["block_steps"].sum()),
        )


def computations(study: Study) -> dict[str, Callable[[Motion, Cases], Results]]:
    """What computes a study's nominal cases again: with finer and finest steps, and with stiffer springs.

    A step given in seconds shrinks with the period of the stiffer contact; an automatic one follows the stable one.
    """
    numerics, model = numerics_of(study), model_for(study)
    step = numerics.time_step
    finer, finest = (replace(numerics, refinement=times * FINER) for times in (1, 2))
    shorter = replace(numerics, time_step=step if isinstance(step, str) else step / np.sqrt(STIFFER))
    return {
        "finer": partial(run, model, numerics=finer),
        "finest": partial(run, model, numerics=finest),
        "stiffer": partial(run, model.stiffer(STIFFER), numerics=shorter),
    }
