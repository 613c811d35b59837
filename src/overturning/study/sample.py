"""A random part of a study: which cells of its cube a convergence check computes again, with the study's answers."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.model.body import MIN_AGREEMENT, direction_weight
from overturning.model.planes import Planes
from overturning.study.answers import Answers, unanswered
from overturning.study.netcdf import open_raw
from overturning.study.scenes import grid_of, model_for
from overturning.study.schema import Study
from overturning.study.sections import Verification

HOLDS: Final = 1.0
"""Friction from which a rectangular block with a smaller B/H is compared with one that cannot slide."""

MOST_RIGID: Final = 25_000
"""Cells that are, at most: two or three seconds of processor time."""

_CHANCES: Final = ("probability_towards", "probability_away", "probability_falls")
"""Variables whose sum is the share of members that fall."""

_ROUNDING: Final = 1e-6


@dataclass(frozen=True)
class Sample:
    """Cases in the random order in which they are computed again, with the study's answers."""

    record: NDArray[np.int64]  # position of the record, shape (n,)
    index: NDArray[np.int64]  # positions along the dimensions of the study, shape (n, 4), or (n, 5) in space
    answers: Answers
    at_rest: NDArray[np.bool_]  # those below the thresholds of rocking and sliding, shape (n,)
    divided: NDArray[np.bool_]  # some members of the ensemble fall and others stand, shape (n, elements)
    apart: NDArray[np.bool_]  # divided, or members fall to both sides (3-D: spread beyond `MIN_AGREEMENT`), same shape
    weight: NDArray[np.float64]  # of a fall of each case in direction statistics (`direction_weight`), shape (n,)
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
        apart = divided.copy()
        if "probability_towards" in file.variables:
            towards = cells("probability_towards")
            apart |= (towards > _ROUNDING) & (towards < 1 - _ROUNDING)
        weight = np.ones(record.size)
        if "fall_north" in file.variables:
            parts = [cells(name) for name in ("fall_north", "fall_east")]
            apart |= (falls > 0) & (np.hypot(*parts) < MIN_AGREEMENT * falls)
            weight = direction_weight(falls, parts[0], parts[1], cells("members"))[:, 0]
        cases = records * int(computed.sum())
        return Sample(record, index, answers, at_rest, divided, apart, weight, cases, int(file.block_steps))


def read_rigid(cube: Path, study: Study) -> Sample | None:
    """Cells of a study's cube to compare with the exact rigid block, `MOST_RIGID` or all of fewer; none without any."""
    among = cannot_slide(study)
    settings = study.verification
    if not among.any() or isinstance(settings, str):
        return None
    return read_sample(cube, settings.model_copy(update={"share": 0.0, "at_least": MOST_RIGID}), among)
