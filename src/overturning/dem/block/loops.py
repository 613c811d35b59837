"""Loops of each scheme over the lanes of the block kernel, compiled in variants without unused quantities.

The centred scheme has three loops for speed: the chain of dependent operations of a whole step is longer than a
processor can look ahead, that of a third of a step is not. All loops take `variant_marker`, whose type differs between
variants, to make their compiled names differ. Otherwise the loops of variants compiled by different processes would be
confused in a process that loads both.
"""

from functools import cache
from typing import Any, Final, NamedTuple

from numba import njit, types
from numba.extending import overload

from overturning.dem.block import centred, commit, cundall
from overturning.dem.block.landing import block_lands_flat, flat_landing_slip
from overturning.dem.block.state import (
    ROWS,
    AcceptedBlockStep,
    AssumedCornerContact,
    AssumedSlip,
    BlockConstants,
    BlockEnergyAccount,
    BlockPeaks,
    BlockShaking,
    BlockState,
    BlockVelocityChange,
    CornerSolutions,
    PredictedBlock,
)
from overturning.dem.kernel.clock import BLOCK, Clock, StepAttempt, choose_next_attempt
from overturning.dem.kernel.lanes import INNER
from overturning.dem.time_step import Scheme


class CundallSchemeConstants(NamedTuple):
    """Constants of Cundall's scheme in the block kernel: lag of its velocities, and steps computed ahead."""

    lag: float = 0.5
    """Lag of velocities behind positions, steps."""
    ahead: int = 0
    """Number of steps that may follow the end of a sample before the motion of the next sample must be loaded."""


class CentredSchemeConstants(NamedTuple):
    """Constants of the centred scheme in the block kernel: lag of its velocities, and steps computed ahead."""

    lag: float = 0.0
    """Lag of velocities behind positions, steps."""
    ahead: int = 1
    """Number of steps that may follow the end of a sample; the motion of the next sample is known in advance."""


@cache
def centred_loops(with_vertical: bool, with_friction: bool) -> Any:
    """Return the loops of the centred scheme, with or without vertical motion and friction."""
    springs = [] if with_friction else ["spring", "place", "stretch", "ux", "slid_left", "slid_right"]
    unused = springs if with_vertical else [*springs, "lift"]
    solution = centred.solve_velocities if with_friction else centred.solve_velocities_without_friction
    load_block, load_shaking, load_clock = (
        ROWS.access(BlockConstants).load,
        ROWS.access(BlockShaking).load,
        ROWS.access(Clock).load,
    )
    load_state, _, store_state = ROWS.access(BlockState, unused_fields=unused)
    load_attempt, store_attempt, _ = ROWS.access(StepAttempt, unused_fields=[] if with_friction else ["tries"])
    load_assumed_slip, store_assumed_slip, _ = ROWS.access(
        AssumedSlip, unused_fields=[] if with_friction else ["left", "right"]
    )
    load_peaks, _, store_peaks = ROWS.access(BlockPeaks)
    load_account, _, store_account = ROWS.access(BlockEnergyAccount)
    load_predicted, store_predicted, _ = ROWS.access(PredictedBlock, unused_fields=unused)
    load_change, store_change, _ = ROWS.access(BlockVelocityChange, unused_fields=unused)

    @njit(**INNER)
    def predict_blocks(
        variant_marker: Any,  # noqa: ARG001
        state: Any,
        lane_count: int,
        ticks_per_sample: float,
    ) -> None:
        for j in range(lane_count):
            block, s, length = load_block(state, j), load_state(state, j), load_attempt(state, j).length
            store_predicted(state, j, centred.predict_block(block, s, length, load_shaking(state, j), ticks_per_sample))

    @njit(**INNER)
    def solve_block_velocities(variant_marker: Any, state: Any, lane_count: int) -> None:  # noqa: ARG001
        for j in range(lane_count):
            fine = load_attempt(state, j).length <= centred.FINE * load_clock(state, j).finest
            block, s, assumed = load_block(state, j), load_state(state, j), load_assumed_slip(state, j)
            store_change(state, j, solution(block, s, assumed, fine, load_predicted(state, j)))

    @njit(**INNER)
    def complete_block_steps(
        variant_marker: Any,  # noqa: ARG001
        state: Any,
        lane_count: int,
        ticks_per_sample: float,
    ) -> None:
        for j in range(lane_count):
            block, s, attempt, clock = (
                load_block(state, j),
                load_state(state, j),
                load_attempt(state, j),
                load_clock(state, j),
            )
            w, d, length = load_predicted(state, j), load_change(state, j), attempt.length
            fine = length <= centred.FINE * clock.finest
            held = block_lands_flat(block, s, (w.left.depth, w.left.uz), (w.right.depth, w.right.uz))
            drifts, drift, tilting = flat_landing_slip(block, held, w.ex + d.vx, w.ez + d.vz)
            assumed_left = AssumedCornerContact(d.slid_left, fine, held, drifts, drift, tilting)
            assumed_right = AssumedCornerContact(d.slid_right, fine, held, drifts, drift, tilting)
            both = CornerSolutions(
                commit.compute_corner_forces(block, w, w.left, s.left, assumed_left, d, with_friction),
                commit.compute_corner_forces(block, w, w.right, s.right, assumed_right, d, with_friction),
            )
            findings = commit.block_step_findings(block, clock, length, fine, both, with_friction)
            again, sooner, attempt = choose_next_attempt(
                BLOCK, clock, attempt, findings, s.tick + length, ticks_per_sample
            )
            assumed = commit.next_assumed_slip(
                AssumedSlip(d.slid_left, d.slid_right), fine, both, attempt.tries > 0.0, sooner
            )
            accepted = AcceptedBlockStep(s, load_peaks(state, j), load_account(state, j))
            accepted = commit.complete_block_step(block, accepted, w, d, both, length, with_vertical, with_friction)
            store_attempt(state, j, attempt)
            store_assumed_slip(state, j, assumed)
            store_state(state, j, again, accepted.state)
            store_peaks(state, j, again, accepted.peaks)
            store_account(state, j, again, accepted.account)

    @njit(**INNER)
    def advance_blocks(
        variant_marker: Any, state: Any, lane_count: int, step_count: int, ticks_per_sample: float
    ) -> None:
        for _ in range(step_count):
            predict_blocks(variant_marker, state, lane_count, ticks_per_sample)
            solve_block_velocities(variant_marker, state, lane_count)
            complete_block_steps(variant_marker, state, lane_count, ticks_per_sample)

    return advance_blocks


@cache
def cundall_loops(with_vertical: bool, with_friction: bool) -> Any:  # noqa: ARG001
    """Return the loops of Cundall's scheme; parameters are those of `centred_loops`.

    There is no variant without friction: tangential springs then carry no force.
    """
    load_block, load_shaking = ROWS.access(BlockConstants).load, ROWS.access(BlockShaking).load
    load_state, store_state, _ = ROWS.access(BlockState, unused_fields=["normal"])
    load_peaks, store_peaks, _ = ROWS.access(BlockPeaks)
    load_account, store_account, _ = ROWS.access(BlockEnergyAccount, unused_fields=["power", "loss"])

    @njit(**INNER)
    def advance_blocks(
        variant_marker: Any,  # noqa: ARG001
        state: Any,
        lane_count: int,
        step_count: int,
        ticks_per_sample: float,  # noqa: ARG001
    ) -> None:
        for _ in range(step_count):
            for j in range(lane_count):
                s, peaks, account = cundall.step_block(
                    load_block(state, j), load_state(state, j), load_peaks(state, j), load_account(state, j),
                    load_shaking(state, j), with_vertical,
                )  # fmt: skip
                store_state(state, j, s)
                store_peaks(state, j, peaks)
                store_account(state, j, account)

    return advance_blocks


SCHEMES: Final[dict[Scheme, tuple[Any, Any]]] = {
    Scheme.CUNDALL: (CundallSchemeConstants(), cundall_loops),
    Scheme.CENTRED: (CentredSchemeConstants(), centred_loops),
}
"""Constants of each scheme and the function that makes its loops; the type of the constants selects the loops."""


def select_loops(scheme: Any, vertical_acceleration: Any, with_friction: Any) -> Any:
    """Return the loops of a scheme, selected by the types of the arguments; callable from compiled code.

    `vertical_acceleration` and `with_friction` are None for the variants without vertical motion and without friction.
    """
    make = next(make for one, make in SCHEMES.values() if type(one) is scheme.instance_class)
    return make(not isinstance(vertical_acceleration, types.NoneType), not isinstance(with_friction, types.NoneType))


@overload(select_loops)
def _overload_select_loops(scheme: Any, vertical_acceleration: Any, with_friction: Any) -> Any:
    loops = select_loops(scheme, vertical_acceleration, with_friction)

    def return_loops(scheme: Any, vertical_acceleration: Any, with_friction: Any) -> Any:  # noqa: ARG001, names count
        return loops

    return return_loops
