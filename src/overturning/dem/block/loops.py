"""Loops of each scheme over the lanes of the block kernel, compiled in variants without unused quantities.

The centred scheme has three loops for speed: the chain of dependent operations of a whole step is longer than a
processor can look ahead, that of a third of a step is not. All loops take `marker_whose_type_selects_variant`, to make
the compiled names of variants differ. Otherwise the loops of variants compiled by different processes would be confused
in a process that loads both.
"""

from functools import cache
from typing import Any, Final, NamedTuple

from numba import njit, types
from numba.extending import overload

from overturning.dem.block import centred, commit, cundall
from overturning.dem.block.access import (
    load_accelerations_from_base_motion,
    load_block_constants,
    load_step_lengths_and_doubling_counts,
)
from overturning.dem.block.centred import LONGEST_PREDICTED_FORCE_STEP_IN_SHORTEST_STEPS
from overturning.dem.block.landing import block_lands_flat, flat_landing_slides_mu_and_moment_factor
from overturning.dem.block.state import (
    STATE_ROW_LAYOUT,
    AssumedCornerContact,
    BlockAfterAttemptedStep,
    BlockEnergyAccount,
    BlockPeaksAndLastUprightTick,
    BlockPredictedAtStepEnd,
    BlockState,
    BlockVelocityCorrectionAndCornerFriction,
    SignedFrictionCoefficientOrZeroIfSticking,
    SolvedCornerContactPair,
)
from overturning.dem.kernel.clock import (
    BLOCK_STEP_CONTROL,
    NextStepToAttempt,
    decide_rejection_sliding_and_next_step,
)
from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS, assume_lane_count_is_multiple_of_8
from overturning.dem.time_step import IntegrationScheme


class BlockCundallSchemeConstants(NamedTuple):
    """Constants of Cundall's scheme for blocks: lag of velocities behind positions; steps after a sample's end."""

    velocity_lag_behind_position_in_steps: float = 0.5
    """Lag of velocities behind positions, steps."""
    max_steps_before_next_sample_is_loaded: int = 0
    """Number of steps that may follow the end of a sample before the motion of the next sample must be loaded."""


class VelocityLagAndMaxStepsBeyondSampleEnd(NamedTuple):
    """Constants of the centred scheme for blocks: lag of velocities behind positions; steps after a sample's end."""

    velocity_lag_behind_position_in_steps: float = 0.0
    """Lag of velocities behind positions, steps."""
    max_steps_before_next_sample_is_loaded: int = 1
    """Number of steps that may follow the end of a sample; the motion of the next sample is known in advance."""


def unused_block_state_fields(with_vertical_base_motion: bool, with_friction: bool) -> list[str]:
    """Return the names of block state variables that a loop without vertical base motion or friction does not need."""
    springs = [] if with_friction else [
        "tangential_stretch", "x_position", "velocity_x", "left_signed_mu_or_zero_if_sticking",
        "right_signed_mu_or_zero_if_sticking", "repetitions_with_corrected_sliding_so_far",
    ]  # fmt: skip
    return springs if with_vertical_base_motion else [*springs, "upward_base_acceleration"]


@cache
def create_centred_time_stepping_loop(with_vertical_base_motion: bool, with_friction: bool) -> Any:
    """Return the compiled time-stepping loop of the centred scheme for blocks.

    It is compiled with or without vertical base motion, and with or without friction.
    """
    unused = unused_block_state_fields(with_vertical_base_motion, with_friction)
    solution = (
        centred.solve_velocity_corrections if with_friction else centred.solve_frictionless_step_velocity_corrections
    )
    load_block_state = STATE_ROW_LAYOUT.tuple_reader_and_writer(BlockState, unused_fields=unused).load
    load_next_step_to_attempt = STATE_ROW_LAYOUT.tuple_reader_and_writer(NextStepToAttempt, unused_fields=unused).load
    load_signed_friction_or_zero = STATE_ROW_LAYOUT.tuple_reader_and_writer(
        SignedFrictionCoefficientOrZeroIfSticking, unused_fields=unused
    ).load
    load_predicted_block, store_predicted_block, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(
        BlockPredictedAtStepEnd, unused_fields=unused
    )
    store_velocity_correction = STATE_ROW_LAYOUT.tuple_reader_and_writer(
        BlockVelocityCorrectionAndCornerFriction, unused_fields=unused
    ).store
    complete_block_steps = create_centred_step_completion_loop(with_vertical_base_motion, with_friction)

    @njit(**INTERNAL_COMPILE_OPTIONS)
    def predict_block_states_at_step_end(
        marker_whose_type_selects_variant: Any,  # noqa: ARG001
        state: Any,
        computed_lane_count: int,
        ticks_per_sample: float,
    ) -> None:
        """Predict the states of all blocks in parallel at the end of their steps."""
        for j in range(assume_lane_count_is_multiple_of_8(computed_lane_count)):
            block, s, length = (
                load_block_constants(state, j),
                load_block_state(state, j),
                load_next_step_to_attempt(state, j).length_in_ticks,
            )
            store_predicted_block(
                state,
                j,
                centred.predict_block_at_step_end(
                    block, s, length, load_accelerations_from_base_motion(state, j), ticks_per_sample
                ),
            )

    @njit(**INTERNAL_COMPILE_OPTIONS)
    def solve_block_velocity_corrections(
        marker_whose_type_selects_variant: Any,  # noqa: ARG001
        state: Any,
        computed_lane_count: int,
    ) -> None:
        """Solve the equations of the step for the velocity corrections of all blocks in parallel."""
        for j in range(assume_lane_count_is_multiple_of_8(computed_lane_count)):
            fine = (
                load_next_step_to_attempt(state, j).length_in_ticks
                <= LONGEST_PREDICTED_FORCE_STEP_IN_SHORTEST_STEPS
                * load_step_lengths_and_doubling_counts(state, j).min_allowed_step_ticks
            )
            block, s, assumed = (
                load_block_constants(state, j),
                load_block_state(state, j),
                load_signed_friction_or_zero(state, j),
            )
            store_velocity_correction(state, j, solution(block, s, assumed, fine, load_predicted_block(state, j)))

    @njit(**INTERNAL_COMPILE_OPTIONS)
    def attempt_block_steps(
        marker_whose_type_selects_variant: Any,
        state: Any,
        computed_lane_count: int,
        step_count: int,
        ticks_per_sample: float,
    ) -> None:
        """Attempt `step_count` time steps of all blocks in parallel; this number includes rejected steps."""
        for _ in range(step_count):
            predict_block_states_at_step_end(
                marker_whose_type_selects_variant, state, computed_lane_count, ticks_per_sample
            )
            solve_block_velocity_corrections(marker_whose_type_selects_variant, state, computed_lane_count)
            complete_block_steps(marker_whose_type_selects_variant, state, computed_lane_count, ticks_per_sample)

    return attempt_block_steps


def create_centred_step_completion_loop(with_vertical_base_motion: bool, with_friction: bool) -> Any:
    """Return the centred scheme's compiled loop that computes contact forces and accepts or rejects block steps."""
    unused = unused_block_state_fields(with_vertical_base_motion, with_friction)
    load_block_state, _, store_block_state_unless_rejected = STATE_ROW_LAYOUT.tuple_reader_and_writer(
        BlockState, unused_fields=unused
    )
    load_next_step_to_attempt, store_next_step_to_attempt, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(
        NextStepToAttempt, unused_fields=unused
    )
    store_signed_friction_or_zero = STATE_ROW_LAYOUT.tuple_reader_and_writer(
        SignedFrictionCoefficientOrZeroIfSticking, unused_fields=unused
    ).store
    load_peaks_and_last_upright_tick, _, store_peaks_and_upright_tick_unless_rejected = (
        STATE_ROW_LAYOUT.tuple_reader_and_writer(BlockPeaksAndLastUprightTick)
    )
    load_energy_account, _, store_energy_and_penetration_unless_rejected = STATE_ROW_LAYOUT.tuple_reader_and_writer(
        BlockEnergyAccount
    )
    load_predicted_block = STATE_ROW_LAYOUT.tuple_reader_and_writer(BlockPredictedAtStepEnd, unused_fields=unused).load
    load_velocity_correction = STATE_ROW_LAYOUT.tuple_reader_and_writer(
        BlockVelocityCorrectionAndCornerFriction, unused_fields=unused
    ).load

    @njit(**INTERNAL_COMPILE_OPTIONS)
    def compute_forces_and_accept_or_reject_block_steps(
        marker_whose_type_selects_variant: Any,  # noqa: ARG001
        state: Any,
        computed_lane_count: int,
        ticks_per_sample: float,
    ) -> None:
        """Compute contact forces of all blocks in parallel, and accept or reject the step of each block."""
        for j in range(assume_lane_count_is_multiple_of_8(computed_lane_count)):
            block, s, attempt, case_step_control = (
                load_block_constants(state, j),
                load_block_state(state, j),
                load_next_step_to_attempt(state, j),
                load_step_lengths_and_doubling_counts(state, j),
            )
            w, d, length = load_predicted_block(state, j), load_velocity_correction(state, j), attempt.length_in_ticks
            fine = length <= LONGEST_PREDICTED_FORCE_STEP_IN_SHORTEST_STEPS * case_step_control.min_allowed_step_ticks
            held = block_lands_flat(
                block, s, (w.left.penetration, w.left.velocity_z), (w.right.penetration, w.right.velocity_z)
            )
            drifts, drift, tilting = flat_landing_slides_mu_and_moment_factor(
                block, held, w.step_end_centre_vx + d.centre_vx, w.step_end_centre_vz + d.centre_vz
            )
            mu_left, mu_right = d.left_signed_mu_or_zero_if_sticking, d.right_signed_mu_or_zero_if_sticking
            left = AssumedCornerContact(mu_left, fine, held, drifts, drift, tilting)
            right = AssumedCornerContact(mu_right, fine, held, drifts, drift, tilting)
            both = SolvedCornerContactPair(
                commit.corner_forces_new_state_and_contact_changes(block, w, w.left, s.left, left, d, with_friction),
                commit.corner_forces_new_state_and_contact_changes(block, w, w.right, s.right, right, d, with_friction),
            )
            findings = commit.contact_changes_in_block_step(block, case_step_control, length, fine, both, with_friction)
            end_tick = s.ticks_since_sample_start + length
            again, sooner, attempt = decide_rejection_sliding_and_next_step(
                BLOCK_STEP_CONTROL, case_step_control, attempt, findings, end_tick, ticks_per_sample
            )
            mu_if_sliding = SignedFrictionCoefficientOrZeroIfSticking(mu_left, mu_right)
            assumed = commit.assumed_signed_friction_for_next_attempt(
                mu_if_sliding, fine, both, attempt.repetitions_with_corrected_sliding_so_far > 0.0, sooner
            )
            peaks, energy = load_peaks_and_last_upright_tick(state, j), load_energy_account(state, j)
            accepted = BlockAfterAttemptedStep(s, peaks, energy)
            accepted = commit.compute_block_state_after_step_if_accepted(
                block, accepted, w, d, both, length, with_vertical_base_motion, with_friction
            )
            store_next_step_to_attempt(state, j, attempt)
            store_signed_friction_or_zero(state, j, assumed)
            store_block_state_unless_rejected(state, j, again, accepted.state)
            store_peaks_and_upright_tick_unless_rejected(state, j, again, accepted.peaks)
            store_energy_and_penetration_unless_rejected(state, j, again, accepted.energy_account)

    return compute_forces_and_accept_or_reject_block_steps


@cache
def create_cundall_time_stepping_loop(with_vertical_base_motion: bool, with_friction: bool) -> Any:  # noqa: ARG001
    """Return the compiled time-stepping loop of Cundall's scheme for blocks.

    It is compiled with or without vertical base motion, and with or without friction.
    """
    load_block_state, store_block_state, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(
        BlockState, unused_fields=["normal_force_per_mass"]
    )
    load_peaks_and_last_upright_tick, store_peaks_and_last_upright_tick, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(
        BlockPeaksAndLastUprightTick
    )
    load_energy_account, store_energy_account, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(
        BlockEnergyAccount, unused_fields=["base_motion_power_per_mass", "dissipated_power_per_mass"]
    )

    @njit(**INTERNAL_COMPILE_OPTIONS)
    def advance_blocks(
        marker_whose_type_selects_variant: Any,  # noqa: ARG001
        state: Any,
        computed_lane_count: int,
        step_count: int,
        ticks_per_sample: float,  # noqa: ARG001
    ) -> None:
        """Advance all blocks in parallel by `step_count` time steps."""
        for _ in range(step_count):
            for j in range(assume_lane_count_is_multiple_of_8(computed_lane_count)):
                s, peaks, account = cundall.advance_block_one_step(
                    load_block_constants(state, j), load_block_state(state, j), load_peaks_and_last_upright_tick(state,
                    j),
                    load_energy_account(state, j), load_accelerations_from_base_motion(state, j),
                    with_vertical_base_motion,
                )  # fmt: skip
                store_block_state(state, j, s)
                store_peaks_and_last_upright_tick(state, j, peaks)
                store_energy_account(state, j, account)

    return advance_blocks


CONSTANTS_AND_LOOP_CREATOR_BY_SCHEME: Final[dict[IntegrationScheme, tuple[Any, Any]]] = {
    IntegrationScheme.CUNDALL: (BlockCundallSchemeConstants(), create_cundall_time_stepping_loop),
    IntegrationScheme.CENTRED: (VelocityLagAndMaxStepsBeyondSampleEnd(), create_centred_time_stepping_loop),
}
"""Constants of each scheme and the function that makes its step function; the type of the constants selects it."""


def select_time_stepping_loop(
    scheme_constants: Any, numba_type_of_upward_acceleration: Any, none_if_all_cases_frictionless: Any
) -> Any:
    """Return a scheme's compiled time-stepping loop for blocks, with or without vertical base motion and friction.

    Arguments are Numba types. The type of `scheme_constants` selects the scheme. NoneType selects the loop without
    vertical motion (`numba_type_of_upward_acceleration`) or without friction (`none_if_all_cases_frictionless`).
    """
    make = next(
        make
        for one, make in CONSTANTS_AND_LOOP_CREATOR_BY_SCHEME.values()
        if type(one) is scheme_constants.instance_class
    )
    return make(
        not isinstance(numba_type_of_upward_acceleration, types.NoneType),
        not isinstance(none_if_all_cases_frictionless, types.NoneType),
    )


@overload(select_time_stepping_loop)
def _overload_select_time_stepping_loop(
    scheme_constants: Any, numba_type_of_upward_acceleration: Any, none_if_all_cases_frictionless: Any
) -> Any:
    """Tell Numba which time-stepping loop `select_time_stepping_loop` returns for given argument types."""
    step_function = select_time_stepping_loop(
        scheme_constants, numba_type_of_upward_acceleration, none_if_all_cases_frictionless
    )

    def return_loop_selected_by_argument_types(
        scheme_constants: Any,  # noqa: ARG001
        numba_type_of_upward_acceleration: Any,  # noqa: ARG001
        none_if_all_cases_frictionless: Any,  # noqa: ARG001
    ) -> Any:
        """Return the compiled time-stepping loop selected by the Numba types of the arguments."""
        return step_function

    return return_loop_selected_by_argument_types
