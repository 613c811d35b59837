"""Part of a study run again, with finer steps and with stiffer springs: how far its answers hang on the computation."""

import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.cases import Cases, run_cases
from overturning.dem.contact import Contact
from overturning.errors import ArgumentError, ResultError
from overturning.files import whole
from overturning.records.record import Record
from overturning.study.config import Study, Verification
from overturning.study.grid import Grid
from overturning.study.sweep import motion_of, simulation_arguments
from overturning.verification.comparison import Counts, compare

FINER: Final = 8
"""Steps of the first repetition in each of the study's."""

STIFFER: Final = 4.0
"""Stiffness of the second repetition over the study's; the step follows, as 1/√4."""

WARN_ABOVE: Final = 0.01
"""Share of changed flags above which the report warns."""

KINDS: Final = ("finer", "stiffer")


def is_verified(study: Study) -> bool:
    """Whether a part of the study is to be run again. Scenes are not: their kernel has no finer step yet."""
    return study.verification != "none" and study.scene is None


@dataclass(frozen=True)
class Cells:
    """Chosen cells of one record, with the study's answers.

    Attributes
    ----------
    index : ndarray of int64, shape (n, 4)
        Positions along azimuth, height, B/H and friction.
    overturned : ndarray of int8, shape (n,)
        The study's flags.
    status : ndarray of int8, shape (n,)
        How they were found.
    """

    index: NDArray[np.int64]
    overturned: NDArray[np.int8]
    status: NDArray[np.int8]


def choose(settings: Verification, records: int, computed: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """Choose cells of a study at random, each at most once.

    Mirrored cells are not chosen: they would be the same computation again.

    Parameters
    ----------
    settings : Verification
        Share, least number and seed.
    records : int
        Number of records.
    computed : ndarray of bool, shape (a, h, b, f)
        Cells that are computed, the same for every record.

    Returns
    -------
    list of ndarray of int64, shape (n, 4)
        Cells of each record.
    """
    cells = np.argwhere(computed)
    total = records * len(cells)
    wanted = min(total, max(settings.at_least, round(settings.share * records * computed.size)))
    generator = np.random.Generator(np.random.PCG64(settings.seed))
    chosen = np.sort(generator.choice(total, size=wanted, replace=False, shuffle=False))
    return [cells[chosen[chosen // len(cells) == record] % len(cells)] for record in range(records)]


def read_cells(cube: Path, settings: Verification) -> list[Cells]:
    """Choose cells of a cube and read the study's answers to them.

    Raises
    ------
    ResultError
        If the cube cannot be read.
    """
    from netCDF4 import Dataset

    try:
        file = Dataset(cube)
    except OSError as error:
        raise ResultError(f"{cube}: cannot be opened ({error}); run the study again") from None
    with file:
        file.set_auto_maskandscale(False)
        records = file.dimensions["record"].size
        chosen = choose(settings, records, file["mirrored"][0] == 0)
        rows = []
        for record, index in enumerate(chosen):
            where = tuple(index.T)
            rows.append(Cells(index, file["overturned"][record][where], file["status"][record][where]))
    return rows


def _stiffer(contact: Contact) -> Contact:
    if contact.stiffness == "auto":
        return replace(contact, static_penetration=contact.static_penetration / STIFFER)
    assert not isinstance(contact.stiffness, str)  # checked by Contact
    return replace(contact, stiffness=contact.stiffness * STIFFER)


def repetitions(study: Study) -> dict[str, dict[str, Any]]:
    """Arguments of `run_cases` for each repetition."""
    given = simulation_arguments(study)
    step = given["time_step"]
    # A step in seconds must shrink with the period of the stiffer contact; "auto" does so by itself.
    shorter = step if isinstance(step, str) else step / np.sqrt(STIFFER)
    return {
        "finer": given | {"refinement": FINER},
        "stiffer": given | {"contact": _stiffer(given["contact"]), "time_step": shorter},
    }


def repeat_cells(
    study: Study,
    records: Sequence[Record],
    cells: Sequence[Cells],
    study_block_steps: int,
    threads: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Run chosen cells again, with finer steps and with stiffer springs.

    Parameters
    ----------
    study : Study
        The study, whose `verification` is not "none".
    records : sequence of Record
        The processed records in the order of the study.
    cells : sequence of Cells
        Chosen cells of each record.
    study_block_steps : int
        Work of the study itself, for comparison.
    threads : int
        Records run at the same time; the result does not depend on it.
    progress : callable, optional
        Called with the records done and all records.

    Returns
    -------
    dict
        Counts and block steps by repetition, the same for every run: no clock.
    """
    assert not isinstance(study.verification, str)  # the workflow does not ask for it
    grid, how = Grid.of(study), repetitions(study)
    work = [(record, chosen) for record, chosen in zip(records, cells, strict=True) if len(chosen.index)]

    def one(item: tuple[Record, Cells]) -> dict[str, tuple[Counts, int] | str]:
        return _repeat(study, grid, *item, how)

    found: list[dict[str, tuple[Counts, int] | str]] = []
    with ThreadPoolExecutor(max_workers=threads) as pool:
        for outcome in pool.map(one, work):
            found.append(outcome)
            if progress:
                progress(len(found), len(work))
    return {
        "seed": study.verification.seed,
        "chosen": sum(len(chosen.index) for chosen in cells),
        "at_rest": sum(int((chosen.status == 1).sum()) for chosen in cells),
        "cells": len(records) * grid.size,
        "study_block_steps": study_block_steps,
        "finer_by": FINER,
        "stiffer_by": STIFFER,
        **{kind: _total([outcome[kind] for outcome in found]) for kind in KINDS},
    }


def _repeat(
    study: Study, grid: Grid, record: Record, chosen: Cells, how: Mapping[str, dict[str, Any]]
) -> dict[str, tuple[Counts, int] | str]:
    axes = (grid.azimuth.astype(np.float64), grid.height, grid.b_over_h, grid.friction)
    cases = Cases(*(axis[chosen.index[:, column]] for column, axis in enumerate(axes)))
    motion = motion_of(study, record)
    outcome: dict[str, tuple[Counts, int] | str] = {}
    for kind, arguments in how.items():
        try:
            again = run_cases(motion, cases, **arguments)
        except ArgumentError as error:
            outcome[kind] = str(error)  # springs four times stiffer may be beyond what numbers hold
            continue
        outcome[kind] = compare(chosen.overturned, again.overturned), int(again.block_steps.sum())
    return outcome


def _total(parts: Sequence[tuple[Counts, int] | str]) -> dict[str, Any]:
    refused = [part for part in parts if isinstance(part, str)]
    if refused:
        return {"refused": refused[0]}
    pairs = [part for part in parts if not isinstance(part, str)]
    return {**asdict(sum((counts for counts, _ in pairs), Counts())), "block_steps": sum(steps for _, steps in pairs)}


def write_verification(found: Mapping[str, Any], path: Path) -> None:
    """Write the outcome of `repeat_cells` as JSON."""
    with whole(path) as part:
        part.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def read_verification(path: Path) -> dict[str, Any]:
    """Read what `write_verification` wrote.

    Raises
    ------
    ResultError
        If the file is missing or torn.
    """
    try:
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        raise ResultError(f"{path}: no outcome of a verification; remove it and run the study again") from None
    return found
