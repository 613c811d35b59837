"""Plan of the cases of a 3-D stack: stones, joints, time steps, and samples that can be skipped."""

from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.plan import base_accelerations_by_orientation, steps_per_sample_and_clock_settings
from overturning.dem.kernel.mechanics import LANDING
from overturning.dem.limits import MAX_PENETRATION, MAX_TIME_AFTER_RECORD, exceeds_penetration_limit
from overturning.dem.linear import highest_eigenvalue
from overturning.dem.numerics import BODY_STEP, Numerics
from overturning.dem.plan import SimulationPlan, group_numbers_of_equal_cases
from overturning.dem.quiet import REST_THRESHOLD_FACTOR, find_quiet_windows
from overturning.dem.stack.results import stack_outcomes
from overturning.dem.stack.rules import StackKernelInput
from overturning.dem.stack.state import COLUMNS, TICKS
from overturning.dem.stack.tables import CASE, JOINT, RESULT, STONE, STONE_RESULT
from overturning.dem.time_step import IntegrationScheme, parse_scheme
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.contact import MAX_CONTACT_WIDTH, VertexContact
from overturning.model.geometry import FALLEN_DROP
from overturning.model.stack import Stack, StackStone
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

FALLEN_TILT: Final = np.pi / 3.0
"""Tilt at which a stone has fallen, rad, or half of the angle beyond its critical angle, whichever is more."""


@dataclass(frozen=True)
class JointTable:
    """Contact constants of the joints of a stack, from the lowest up."""

    rows: NDArray[np.void]
    """Constants, of type `JOINT`, without friction; shape (joints,)."""
    penetration: FloatArray
    """Penetration at rest, m."""
    reach: FloatArray
    """Distance of the nearest edge of each patch from its centre, m."""
    sides: FloatArray
    """Sides of each patch along x and y, m, shape (joints, 2)."""


def joint_table(stones: list[StackStone], contact: VertexContact) -> JointTable:
    """Return the contact constants of the joints of a stack: stiffness K = M g/δ for the mass M above the joint."""
    rows = np.zeros(len(stones), JOINT)
    mass = np.array([stone.mass for stone in stones])
    above = np.cumsum(mass[::-1])[::-1]
    sides = np.array([[stone.width, stone.depth] for stone in stones])
    sides[1:] = np.minimum(sides[1:], sides[:-1])
    reach = 0.5 * sides.min(axis=1)
    penetration = contact.static_penetration * np.minimum(2.0 * reach, MAX_CONTACT_WIDTH)
    stiffness = above * STANDARD_GRAVITY / penetration
    dashpot = 2.0 * contact.damping_ratio * np.sqrt(stiffness * above)
    rows["stiffness"], rows["dashpot"], rows["damping"] = stiffness, dashpot, dashpot
    rows["tangential"] = contact.stiffness_ratio * stiffness
    rows["compliance"] = 1.0 / rows["tangential"] if contact.stiffness_ratio > 0.0 else 0.0
    rows["landing"] = LANDING * dashpot / stiffness
    return JointTable(rows, penetration, reach, sides)


def stone_table(stones: list[StackStone], joints: JointTable) -> NDArray[np.void]:
    """Return constants and initial states of the stones of a stack at rest, of type `STONE`, shape (stones,)."""
    table, level = np.zeros(len(stones), STONE), 0.0
    for stone, row, depth, reach in zip(stones, table, joints.penetration, joints.reach, strict=True):
        square = stone.width**2 / 12.0, stone.depth**2 / 12.0, stone.height**2 / 12.0
        inertia = (square[1] + square[2], square[0] + square[2], square[0] + square[1])
        for axis, value in zip("xyz", inertia, strict=True):
            row[f"a{axis}{axis}"], row[f"i{axis}{axis}"] = value, 1.0 / value
        foot = 0.5 * stone.height
        row["mass"], row["foot"], row["top"], row["reach"] = stone.mass, foot, foot, reach
        row["critical"] = reach**2 / (reach**2 + foot**2)
        tilt = max(FALLEN_TILT, 0.5 * (np.arctan2(reach, foot) + 0.5 * np.pi))
        row["fallen"] = np.round(np.cos(tilt), 12)
        centre = level - depth + foot
        row["rest"], row["start"]["z"], row["start"]["qw"] = centre, centre, 1.0
        row["lowest"] = centre - max(FALLEN_DROP * stone.height, 2.0 * depth)
        level = level - depth + stone.height
    return table


def outline_rows(stone: StackStone) -> FloatArray:
    """Return the corners of a stone's faces, shape (4, 6): fields of `PointOutline`."""
    b, d = 0.5 * stone.width, 0.5 * stone.depth
    return np.array([
        [b, -d, 1.0, 0.0, b, 0.25], [b, d, 0.0, 1.0, d, 0.25], [-b, d, -1.0, 0.0, b, 0.25], [-b, -d, 0.0, -1.0, d, 0.25]
    ])  # fmt: skip


def stiffness_matrix(stones: list[StackStone], joints: JointTable) -> FloatArray:
    """Return the stiffness matrix of a stack at rest, scaled to unit masses and inertias, shape (6 n, 6 n)."""
    count = len(stones)
    matrix, scale = np.zeros((6 * count, 6 * count)), np.zeros(6 * count)
    for i, stone in enumerate(stones):
        inertia = stone.mass / 12.0 * np.array([
            stone.depth**2 + stone.height**2, stone.width**2 + stone.height**2, stone.width**2 + stone.depth**2
        ])  # fmt: skip
        scale[6 * i : 6 * i + 6] = 1.0 / np.sqrt([*3 * [stone.mass], *inertia])
    for i in range(count):
        k, kt = joints.rows["stiffness"][i] / 4.0, joints.rows["tangential"][i] / 4.0
        for x in (-0.5 * joints.sides[i, 0], 0.5 * joints.sides[i, 0]):
            for y in (-0.5 * joints.sides[i, 1], 0.5 * joints.sides[i, 1]):
                each = np.zeros((3, 6 * count))
                for s, z, sign in ((i, -0.5 * stones[i].height, 1.0), (i - 1, 0.5 * stones[i - 1].height, -1.0)):
                    if s >= 0:
                        turn = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
                        each[:, 6 * s : 6 * s + 6] += sign * np.concatenate([np.eye(3), turn], axis=1)
                each = each * scale
                matrix += np.einsum("ij,i,ik->jk", each, np.array([kt, kt, k]), each)
    return matrix


def motion_threshold(stones: list[StackStone], joints: JointTable, friction: FloatArray) -> FloatArray:
    """Return |a|/g below which no joint opens or slides, shape (n,); `friction` has shape (n, joints).

    Joint k opens at the least ratio of the distance of an edge of its patch to the height of the centre of all stones
    above, and slides at µ.
    """
    mass = np.array([stone.mass for stone in stones])
    base = np.concatenate([[0.0], np.cumsum([stone.height for stone in stones])[:-1]])
    centre = base + 0.5 * np.array([stone.height for stone in stones])
    opens = [joints.reach[k] / (np.sum(mass[k:] * centre[k:]) / np.sum(mass[k:]) - base[k]) for k in range(len(stones))]
    return np.minimum(min(opens), friction.min(axis=1))


@dataclass(frozen=True, kw_only=True)
class StackSimulationPlan(SimulationPlan):
    """Plan for n cases of a 3-D stack."""

    split_long_queues: ClassVar[bool] = True
    result_dtype: ClassVar[Any] = RESULT
    step_cost: ClassVar[int] = BODY_STEP

    model: Stack
    stones: NDArray[np.void]  # shape (stacks, stones)
    joints: NDArray[np.void]  # shape (stacks, stones)
    outlines: FloatArray  # shape (stacks, stones, corners, 6)
    friction: FloatArray  # shape (n, stones)
    cosines: FloatArray  # shape (n, 2): direction cosines of the orientation, north and east

    @property
    def queue_numbers(self) -> NDArray[np.int64]:
        """Index of the queue of each case; cases with equal step lengths, also at rest, share one."""
        return group_numbers_of_equal_cases(self.steps, self.table["standing"])

    @property
    def vertical_base_acceleration(self) -> FloatArray:
        """Vertical acceleration of the base, m/s², with three zeros after the record; zeros if it moves level."""
        up = super().vertical_base_acceleration
        return np.zeros(self.motion.samples + 3) if up is None else up

    def create_result_tables(self, case_count: int) -> dict[str, NDArray[np.void]]:
        """Add ``each``, shape (case_count, stones), to the tables of `SimulationPlan.create_result_tables`."""
        each = np.zeros((case_count, self.stones.shape[1]), STONE_RESULT)
        return {"results": np.zeros(case_count, RESULT), "each": each}

    def kernel_input(
        self, case_numbers: NDArray[np.int64], create_result_tables: dict[str, NDArray[np.void]], step_divisor: int
    ) -> StackKernelInput:
        """Return the kernel's input for cases with the same numbers of steps per sample, moving and at rest."""
        queued = self.common_kernel_input_fields(case_numbers, create_result_tables, step_divisor, TICKS, COLUMNS)
        settings, standing = queued["settings"], float(queued["cases"]["standing"][0])
        queued["settings"] = settings._replace(steps_per_check=int(settings.ticks / standing))
        queued["cases"]["settled"] *= step_divisor
        return StackKernelInput(
            **queued, each=create_result_tables["each"], friction=self.friction[case_numbers], stones=self.stones,
            joints=self.joints, corners=np.full(self.stones.shape[1], 4), outlines=self.outlines,
        )  # fmt: skip

    def case_outcome_variables(
        self, case_numbers: NDArray[np.int64], filled_tables: dict[str, NDArray[np.void]]
    ) -> dict[str, Any]:
        """Convert the kernel's results to outcome variables."""
        orientation = np.asarray(self.cases.azimuth_deg)[case_numbers]
        return stack_outcomes(filled_tables["results"], filled_tables["each"], orientation, self.cosines[case_numbers])

    def create_trajectory_buffer(self, is_recorded: bool) -> NDArray[Any]:
        """Return an empty buffer: trajectories of stacks are not recorded yet."""
        if is_recorded:
            raise ArgumentError("trajectory: a 3-D stack has none yet; compute the scene in 2-D with azimuth_deg")
        return np.zeros((0, 4 + 13 * self.stones.shape[1]))

    def convert_trajectory_rows(self, trajectory_rows: NDArray[Any]) -> Any:
        """Trajectories of stacks are not recorded yet."""
        raise NotImplementedError


def plan_stack_simulation(model: Stack, motion: Motion, cases: Cases, numerics: Numerics) -> StackSimulationPlan:
    """Check the arguments and plan the cases of a 3-D stack; see `overturning.dem.run.run`."""
    if parse_scheme(numerics.scheme) != IntegrationScheme.CENTRED:
        raise ArgumentError(f"scheme: {numerics.scheme!r}; a 3-D stack supports only 'centred'")
    if np.asarray(cases.initial_tilt).any():
        raise ArgumentError("initial_tilt: a 3-D stack starts at rest; leave it at 0")
    sizes, which = np.unique(np.stack([cases.height, cases.b_over_h], axis=1), axis=0, return_inverse=True)
    stacks = [model.stones(float(height), float(ratio)) for height, ratio in sizes]
    joints = [joint_table(stones, model.contact) for stones in stacks]
    tables = np.stack([stone_table(stones, table) for stones, table in zip(stacks, joints, strict=True)])
    given = np.array([np.nan if stone.friction is None else stone.friction for stone in stacks[0]])
    friction = np.where(np.isnan(given), np.asarray(cases.friction)[:, None], given)
    square = np.array([
        highest_eigenvalue(stiffness_matrix(stones, table)) for stones, table in zip(stacks, joints, strict=True)
    ])  # fmt: skip
    delay = np.array([float(np.max(table.rows["dashpot"] / table.rows["stiffness"])) for table in joints])
    foot, reach = tables["foot"], tables["reach"]
    period = np.sqrt(np.hypot(foot, reach) / (0.75 * STANDARD_GRAVITY)).min(axis=1)
    interval, samples = motion.sampling_interval, motion.samples
    rate = (square * delay)[which] * np.asarray(cases.damping_factor)
    steps, pace = steps_per_sample_and_clock_settings(numerics, square[which], rate, interval, period[which])
    amplitude = np.asarray(cases.amplitude)
    row, cosines, along = base_accelerations_by_orientation(motion, cases)
    threshold = np.zeros(cases.size)
    for index, (stones, table) in enumerate(zip(stacks, joints, strict=True)):
        of_stack = which == index
        threshold[of_stack] = motion_threshold(stones, table, friction[of_stack])
    first, calm, at_rest = np.zeros(cases.size, np.int64), np.full(cases.size, np.inf), np.zeros(cases.size, np.bool_)
    if numerics.leave_out:
        strongest = np.sqrt(motion.north**2 + motion.east**2)[None, :]
        first, quiet, at_rest = find_quiet_windows(
            motion, np.zeros(cases.size, np.int64), amplitude, strongest, threshold
        )
        calm = quiet.astype(np.float64)
    weight = tables["mass"].sum(axis=1) * STANDARD_GRAVITY
    barrier = np.array([
        min(
            float(np.sum(table["mass"][k:])) * STANDARD_GRAVITY * (float(np.hypot(r, z)) - z)
            for k, (r, z) in enumerate(zip(table["reach"], table["foot"], strict=True))
        )
        for table in tables
    ])  # fmt: skip
    case_table = np.zeros(cases.size, CASE)
    columns = {
        "stack": which, "amplitude": amplitude, "damping_factor": cases.damping_factor,
        "deepest": (MAX_PENETRATION * np.minimum(reach, foot).min(axis=1))[which],
        "steady": REST_THRESHOLD_FACTOR * threshold, "still": (1e-9 * weight * reach.min(axis=1))[which],
        "first": first, "calm": calm, "barrier": barrier[which],
        "after": samples + np.ceil(MAX_TIME_AFTER_RECORD * period[which] / interval), **pace,
    }  # fmt: skip
    for name, values in columns.items():
        case_table[name] = values
    penetration = np.array([float(table.penetration.max()) for table in joints])
    return StackSimulationPlan(
        model=model, motion=motion, cases=cases, numerics=numerics, stones=tables,
        joints=np.stack([table.rows for table in joints]),
        outlines=np.array([[outline_rows(stone) for stone in stones] for stones in stacks]), friction=friction,
        cosines=cosines, row=row, ground=along, steps=steps, first=first, table=case_table, stays_at_rest=at_rest,
        too_soft=exceeds_penetration_limit(penetration, 2.0 * np.minimum(foot, reach).min(axis=1))[which],
    )  # fmt: skip
