"""Blocks side by side: the steps of each scheme over the lanes, without what takes no part in them.

The centred scheme has three loops, for speed alone: the chain of dependent operations of a whole step is longer than
what a processor looks ahead, that of a third of it is not. All loops take `kind`, of a type that says which variant
they are, as a part of their compiled names: without it the loops of variants that different processes have compiled
would be called in each other's place once one process has loaded both.
"""

from functools import cache
from typing import Any, Final, NamedTuple

from numba import njit, types
from numba.extending import overload

from overturning.dem.block import centred, commit, cundall
from overturning.dem.block.state import (
    ROWS,
    Account,
    Block,
    Change,
    Corners,
    Given,
    Kept,
    Peaks,
    Predicted,
    Shaking,
    State,
    Taken,
    drift_of,
    lands_flat,
)
from overturning.dem.kernel.clock import BLOCK, Attempt, Clock, next_attempt
from overturning.dem.kernel.lanes import INNER
from overturning.dem.time_step import Scheme


class Cundall(NamedTuple):
    """What the kernel has to know of the scheme."""

    lag: float = 0.5
    """Steps by which velocities lag behind positions;"""
    ahead: int = 0
    """steps that may follow those of a whole sample before the shaking of the next one is needed."""


class Centred(NamedTuple):
    """What the kernel has to know of the scheme."""

    lag: float = 0.0
    """Steps by which velocities lag behind positions;"""
    ahead: int = 1
    """steps that may follow those of a whole sample before the shaking of the next but one is needed."""


@cache
def centred_loops(vertical: bool, with_friction: bool) -> Any:
    """For bases that move up and down or do not, and blocks with friction or without."""
    springs = [] if with_friction else ["spring", "place", "stretch", "ux", "slid_left", "slid_right"]
    unused = springs if vertical else [*springs, "lift"]
    solution = centred.solve if with_friction else centred.solve_smooth
    load_block, load_shaking, load_clock = ROWS.access(Block).load, ROWS.access(Shaking).load, ROWS.access(Clock).load
    load_state, _, store_state = ROWS.access(State, without=unused)
    load_attempt, store_attempt, _ = ROWS.access(Attempt, without=[] if with_friction else ["tries"])
    load_taken, store_taken, _ = ROWS.access(Taken, without=[] if with_friction else ["left", "right"])
    load_peaks, _, store_peaks = ROWS.access(Peaks)
    load_account, _, store_account = ROWS.access(Account)
    load_predicted, store_predicted, _ = ROWS.access(Predicted, without=unused)
    load_change, store_change, _ = ROWS.access(Change, without=unused)

    @njit(**INNER)
    def predict_all(kind: Any, state: Any, columns: int, ticks: float) -> None:  # noqa: ARG001
        for j in range(columns):
            block, s, length = load_block(state, j), load_state(state, j), load_attempt(state, j).length
            store_predicted(state, j, centred.predict(block, s, length, load_shaking(state, j), ticks))

    @njit(**INNER)
    def solve_all(kind: Any, state: Any, columns: int) -> None:  # noqa: ARG001
        for j in range(columns):
            fine = load_attempt(state, j).length <= centred.FINE * load_clock(state, j).finest
            block, s, taken = load_block(state, j), load_state(state, j), load_taken(state, j)
            store_change(state, j, solution(block, s, taken, fine, load_predicted(state, j)))

    @njit(**INNER)
    def commit_all(kind: Any, state: Any, columns: int, ticks: float) -> None:  # noqa: ARG001
        for j in range(columns):
            block, s, attempt, clock = (
                load_block(state, j),
                load_state(state, j),
                load_attempt(state, j),
                load_clock(state, j),
            )
            w, d, length = load_predicted(state, j), load_change(state, j), attempt.length
            fine = length <= centred.FINE * clock.finest
            held = lands_flat(s, w.left.depth, w.right.depth)
            drifts, drift = drift_of(block, held, w.ex + d.vx, w.ez + d.vz)
            of_left = Given(d.slid_left, fine, held, drifts, drift)
            of_right = Given(d.slid_right, fine, held, drifts, drift)
            both = Corners(
                commit.correct(block, w, w.left, s.left, of_left, d, with_friction),
                commit.correct(block, w, w.right, s.right, of_right, d, with_friction),
            )
            found = commit.found_of(block, clock, length, fine, both, with_friction)
            again, sooner, attempt = next_attempt(BLOCK, clock, attempt, found, s.tick + length, ticks)
            taken = commit.taken_next(Taken(d.slid_left, d.slid_right), fine, both, attempt.tries > 0.0, sooner)
            kept = Kept(s, load_peaks(state, j), load_account(state, j))
            kept = commit.commit(block, kept, w, d, both, length, vertical, with_friction)
            store_attempt(state, j, attempt)
            store_taken(state, j, taken)
            store_state(state, j, again, kept.state)
            store_peaks(state, j, again, kept.peaks)
            store_account(state, j, again, kept.account)

    @njit(**INNER)
    def advance(kind: Any, state: Any, columns: int, steps: int, ticks: float) -> None:
        for _ in range(steps):
            predict_all(kind, state, columns, ticks)
            solve_all(kind, state, columns)
            commit_all(kind, state, columns, ticks)

    return advance


@cache
def cundall_loops(vertical: bool, with_friction: bool) -> Any:  # noqa: ARG001
    """As of `centred_loops`; springs without friction are let go at once."""
    load_block, load_shaking = ROWS.access(Block).load, ROWS.access(Shaking).load
    load_state, store_state, _ = ROWS.access(State, without=["normal"])
    load_peaks, store_peaks, _ = ROWS.access(Peaks)
    load_account, store_account, _ = ROWS.access(Account, without=["power", "loss"])

    @njit(**INNER)
    def advance(kind: Any, state: Any, columns: int, steps: int, ticks: float) -> None:  # noqa: ARG001
        for _ in range(steps):
            for j in range(columns):
                s, peaks, account = cundall.step(
                    load_block(state, j), load_state(state, j), load_peaks(state, j), load_account(state, j),
                    load_shaking(state, j), vertical,
                )  # fmt: skip
                store_state(state, j, s)
                store_peaks(state, j, peaks)
                store_account(state, j, account)

    return advance


SCHEMES: Final[dict[Scheme, tuple[Any, Any]]] = {
    Scheme.CUNDALL: (Cundall(), cundall_loops),
    Scheme.CENTRED: (Centred(), centred_loops),
}
"""Constants of each scheme, and the function that makes its loops; the type of the one picks the other."""


def loops_of(scheme: Any, upward: Any, with_friction: Any) -> Any:
    """The loops of a scheme, without what takes no part where an argument is None; for compiled code, by its types."""
    make = next(make for one, make in SCHEMES.values() if type(one) is scheme.instance_class)
    return make(not isinstance(upward, types.NoneType), not isinstance(with_friction, types.NoneType))


@overload(loops_of)
def _loops_of(scheme: Any, upward: Any, with_friction: Any) -> Any:
    loops = loops_of(scheme, upward, with_friction)

    def chosen(scheme: Any, upward: Any, with_friction: Any) -> Any:  # noqa: ARG001, Numba wants the same arguments
        return loops

    return chosen
