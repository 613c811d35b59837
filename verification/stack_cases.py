"""Random cases of stacks of two and three stones under recorded motions, for the comparison with other solvers."""

import math
from functools import cache
from typing import Any, Final, NamedTuple

import numpy as np

from overturning.model.element import Element
from overturning.model.scene import Scene
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from verification.inputs import read_motions_of_default_study, strong_horizontal_part_of_motion
from verification.stack_engines import BoxStack

SEED: Final = 20261126
RANDOM_STACK_CASE_COUNT: Final = 280
"""Number of cases; even ones have two stones, odd ones three."""
USED_RECORD_DURATION_BEFORE_PEAK_S: Final = 5.0
USED_RECORD_DURATION_S: Final = 13.0
"""Part of a record that is used: time before its horizontal peak, and length, s."""


class StackUnderScaledRecord(NamedTuple):
    """Stack under a record: id of the record, orientation (degrees), factor on the record, and the stones."""

    record_id: str
    orientation_deg: float
    amplitude_factor: float
    stack: BoxStack

    @property
    def part_of_scaled_record_that_can_move_a_stone(self) -> Motion:
        """Record multiplied by the factor, cut to the time in which it can move a stone, with half a second before.

        This time is from the first to the last horizontal acceleration above half of the least one that opens a joint
        or lets it slide. A record without such an acceleration is not cut.
        """
        motion = _strong_parts_of_records()[self.record_id].scaled_by(self.amplitude_factor)
        limit = 0.5 * min_acceleration_to_open_or_slide_a_joint(self.stack)
        strong = np.flatnonzero(np.hypot(motion.north, motion.east) > limit)
        if strong.size == 0:
            return motion
        first = max(int(strong[0]) - round(0.5 / motion.sampling_interval), 0)
        span = slice(first, int(strong[-1]) + 2)
        return Motion(motion.north[span], motion.east[span], sampling_interval=motion.sampling_interval)


@cache
def _strong_parts_of_records() -> dict[str, Motion]:
    """Return the strong part of each record of the default study."""
    return {
        name: strong_horizontal_part_of_motion(motion, USED_RECORD_DURATION_BEFORE_PEAK_S, USED_RECORD_DURATION_S)
        for name, motion in read_motions_of_default_study().items()
    }


def draw_random_stack_cases(
    case_count: int = RANDOM_STACK_CASE_COUNT, seed: int = SEED
) -> list[StackUnderScaledRecord]:
    """Draw stacks of two and three stones at random, with records, orientations and amplitudes.

    A case in which the peak of the record can neither open nor slide any joint is replaced by another draw.
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    records, found = sorted(read_motions_of_default_study()), list[StackUnderScaledRecord]()
    while len(found) < case_count:
        case = _draw_stack_case(generator, records, 2 + len(found) % 2)
        if np.hypot(
            *case.part_of_scaled_record_that_can_move_a_stone.horizontal_components
        ).max() > min_acceleration_to_open_or_slide_a_joint(case.stack):
            found.append(case)
    return found


def _draw_stack_case(generator: np.random.Generator, record_ids: list[str], stone_count: int) -> StackUnderScaledRecord:
    """Draw a stack with record, orientation and factor on the record at random."""

    def draw_rounded_uniform(lower_bound: float, upper_bound: float) -> float:
        """Draw a uniform random number, rounded to three decimals."""
        return round(float(generator.uniform(lower_bound, upper_bound)), 3)

    width = draw_rounded_uniform(0.2, 0.3)
    sizes = [
        (width, round(width * draw_rounded_uniform(0.8, 1.25), 3), round(width / draw_rounded_uniform(0.22, 0.42), 3))
    ]
    for _ in range(stone_count - 1):
        step = draw_rounded_uniform(1.3, 1.7)
        sizes.insert(0, (round(sizes[0][0] * step, 3), round(sizes[0][1] * step, 3), draw_rounded_uniform(0.2, 0.4)))
    stack = BoxStack(tuple(sizes), round(draw_rounded_uniform(0.4, 1.0), 2))
    record = record_ids[int(generator.integers(len(record_ids)))]
    return StackUnderScaledRecord(
        record, float(generator.integers(360)), round(draw_rounded_uniform(0.6, 1.6), 2), stack
    )


def min_acceleration_to_open_or_slide_a_joint(stack: BoxStack) -> float:
    """Return the smallest constant acceleration that opens a joint (contact of two stones) or lets it slide, m/s²."""
    volumes = np.array([math.prod(size) for size in stack.width_depth_height_by_stone])
    feet = np.array(stack.centre_heights_at_rest) - 0.5 * np.array(
        [size[2] for size in stack.width_depth_height_by_stone]
    )
    opens = [
        0.5
        * min(size[:2])
        * volumes[k:].sum()
        / (volumes[k:] * (np.array(stack.centre_heights_at_rest)[k:] - feet[k])).sum()
        for k, size in enumerate(stack.width_depth_height_by_stone)
    ]
    return STANDARD_GRAVITY * min(stack.friction, *opens)


def scene_of_stack(stack: BoxStack) -> Scene:
    """Return the scene of a stack on the ground; friction is given by each case, not by the scene."""
    elements = [Element(name="ground", kind="driven", width=40.0, height=1.0, at=(0.0, -1.0))]
    for number, (width, depth, height) in enumerate(stack.width_depth_height_by_stone):
        below = elements[-1].name
        elements.append(Element(name=f"stone-{number}", width=width, depth=depth, height=height, stands_on=below))
    return Scene(name="stack", reference=elements[-1].name, elements=tuple(elements))


def case_parameters_as_table_row(case_number: int, case: StackUnderScaledRecord) -> dict[str, Any]:
    """Return the parameters of a case as columns of a table."""
    sizes = " ".join("x".join(f"{side:g}" for side in size) for size in case.stack.width_depth_height_by_stone)
    return {
        "case": case_number, "record": case.record_id, "orientation_deg": case.orientation_deg,
        "amplitude": case.amplitude_factor,
        "friction": case.stack.friction, "sizes": sizes,
    }  # fmt: skip
