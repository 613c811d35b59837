"""The cases of config/in-space.yaml without the ensemble: how long they take, whether their energy balances."""

import time
from collections.abc import Callable, Iterator
from typing import Any
from unittest import mock

import numpy as np

from overturning.dem.body.simulate import simulate_in_space_arrays
from overturning.dem.kernel.balance import FINER, until_balanced
from overturning.model.status import Status
from overturning.study.grid import space_grid
from overturning.study.load import load_study
from verification.inputs import near_fault
from verification.tables import ROOT, Figure


def outcome() -> tuple[dict[str, np.ndarray], float, int]:
    """Outcomes of all cases, their processor time, s, and how many were computed again since they did not balance."""
    grid, again = space_grid(load_study(ROOT / "config" / "in-space.yaml")), list[int]()
    axes = {"orientation_deg": grid.orientation} | {name: getattr(grid, name) for name in grid.names[1:]}
    motions = list(near_fault().values())
    simulate_in_space_arrays(motions[0], **{name: values[:1] for name, values in axes.items()})

    def counted(run: Callable[[Any, int], None], *more: Any) -> None:
        def told(rows: Any, finer: int) -> None:
            again.append(rows.size if finer == FINER else 0)
            run(rows, finer)

        until_balanced(told, *more)

    with mock.patch("overturning.dem.body.plan.until_balanced", counted):
        begin = time.process_time()
        found = [simulate_in_space_arrays(motion, threads=2, **axes) for motion in motions]
        seconds = time.process_time() - begin
    return {name: np.stack([one[name] for one in found]) for name in found[0]}, seconds, sum(again)


def study() -> Iterator[Figure]:
    """Time, energy, and the cases that are computed again or marked."""
    found, seconds, again = outcome()
    answered, about = found["status"] == Status.SIMULATED, "space, config/in-space.yaml"
    yield Figure(f"{about}: cases", found["status"].size)
    yield Figure(f"{about}: processor time of two cores", seconds, "s", "≤ 120")
    yield Figure(f"{about}: cases computed again since their energy did not balance", again)
    yield Figure(f"{about}: cases marked unstable", int((found["status"] == Status.UNSTABLE).sum()), "", "0")
    yield Figure(f"{about}: cases undecided", int((found["status"] == Status.UNDECIDED).sum()))
    for name, target in (("energy_error", "≤ 0.01"), ("angular_momentum_error", "")):
        worst = float(found[name][answered].max())
        yield Figure(f"{about}: largest {name.replace('_', ' ')} of an answer", worst, "", target)
