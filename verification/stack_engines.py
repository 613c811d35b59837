"""Simulation of stacks of boxes in 3-D with MuJoCo and LMGC90, two solvers that compute contacts independently.

MuJoCo solves soft contact constraints; its frame moves with the base. LMGC90 solves rigid contacts with friction as a
non-smooth problem, without stiffness; its base moves with the ground velocity. Directions: x towards the orientation of
the stack, y 90° anticlockwise of it, z up. `make peers` installs both.
"""

import math
from collections.abc import Callable, Iterator
from functools import cache
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any, Final, NamedTuple, TypeAlias

import numpy as np

from overturning.arrays import FloatArray
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from verification.engines import interpolate_acceleration_at_step_middles

STONE_DENSITY_KG_M3: Final = 2650.0
"""Density of all stones, kg/m³."""
MAX_SIMULATED_TIME_AFTER_RECORD_S: Final = 4.0
"""Simulated time after the record, s."""
MIN_TILT_COUNTED_AS_FALLEN_RAD: Final = math.pi / 3.0
"""Tilt from which a stone counts as fallen, rad."""
MIN_DROP_TO_HEIGHT_RATIO_OF_FALLEN_STONE: Final = 0.1
"""Drop of the centre from which a stone counts as fallen, as a share of its height."""
FALL_CHECK_INTERVAL_S: Final = 0.01
"""Time between two tests for a fall, s."""
MAX_UPRIGHT_TILT_RAD: Final = math.radians(0.2)
MIN_SIMULATED_TIME_AFTER_RECORD_S: Final = 0.5
"""Tilt below which a stone stands upright, rad, and time after the record after which upright stones end a run, s."""
CONTACT_SEARCH_DISTANCE_M: Final = 1e-3
"""Distance of two faces below which LMGC90 looks for contacts, m."""
FRICTION_TO_NORMAL_IMPEDANCE_RATIO: Final = 100
"""Ratio of the impedances of friction and normal contact in MuJoCo; a smaller one lets stones creep."""


class BoxStack(NamedTuple):
    """Stack of boxes: width along x, depth and height, m, of each from the lowest up, and the friction coefficient."""

    width_depth_height_by_stone: tuple[tuple[float, float, float], ...]
    friction: float

    @property
    def centre_heights_at_rest(self) -> list[float]:
        """Heights of the centres at rest, m, from the lowest stone up."""
        heights = np.array([size[2] for size in self.width_depth_height_by_stone])
        return (np.cumsum(heights) - 0.5 * heights).tolist()


class TopmostStoneOutcome(NamedTuple):
    """Outcome of the topmost stone of a stack; it counts as fallen as soon as any stone of the stack falls."""

    fall_azimuth_deg: float
    """Azimuth to which its axis points at the time of the first fall, degrees; NaN if all stones stand."""
    first_fall_time: float
    """Time at which the first stone counts as fallen, s; NaN if all stand."""
    lowest_stone_index_at_first_fall: int
    """Index of the lowest stone that counts as fallen at that time; -1 if all stand."""
    first_fallen_stone_tilt_or_topmost_peak_deg: float
    """Tilt of the fallen stone at that time, degrees; the largest tilt of the topmost stone if all stand."""
    largest_slip_of_any_upright_stone: float
    """Largest horizontal distance of a base from the centre of the face below while that stone stands upright, m."""
    max_corner_penetration: float
    """Largest depth of a corner of a base below the face that it stands on, m: an error of the solver's contacts."""

    def as_outcome_table_columns(self) -> dict[str, float]:
        """Return the outcome as columns of the table of a solver's outcomes."""
        names = ("fall_azimuth_deg", "fall_time", "fallen_stone", "tilt_deg", "slip", "sinking")
        return dict(zip(names, self, strict=True))


StonePoses: TypeAlias = list[tuple[FloatArray, FloatArray]]
"""Centre, m, and rotation matrix of each stone, from the lowest up."""
StackEngine = Callable[[BoxStack, Motion, float, float], Iterator[StonePoses]]


def ground_accelerations_along_stack_axes(motion: Motion, stack_orientation_deg: float) -> list[FloatArray]:
    """Return ground accelerations, m/s²: along the stack's orientation, 90° anticlockwise of it, and up."""
    up = np.zeros(motion.sample_count) if motion.up is None else motion.up
    return [
        motion.acceleration_along(stack_orientation_deg),
        motion.acceleration_along(stack_orientation_deg - 90.0),
        up,
    ]


def mujoco_poses(
    stack: BoxStack, motion: Motion, stack_orientation_deg: float, time_step: float
) -> Iterator[StonePoses]:
    """Yield the poses (positions and rotations) of the stones in MuJoCo, one per `FALL_CHECK_INTERVAL_S`."""
    import mujoco as engine

    bodies = "".join(
        f'<body pos="0 0 {z}"><freejoint/>'
        f'<geom type="box" size="{b / 2} {d / 2} {h / 2}" mass="{STONE_DENSITY_KG_M3 * b * d * h}"/></body>'
        for (b, d, h), z in zip(stack.width_depth_height_by_stone, stack.centre_heights_at_rest, strict=True)
    )
    model = engine.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{time_step}" integrator="implicitfast" cone="elliptic"
        impratio="{FRICTION_TO_NORMAL_IMPEDANCE_RATIO}"/>
        <default><geom friction="{stack.friction} 0 0" condim="3" solref="{2.0 * time_step} 1"/></default>
        <worldbody><geom type="plane" size="100 100 1"/>{bodies}</worldbody></mujoco>"""
    )
    data = engine.MjData(model)
    waves = ground_accelerations_along_stack_axes(motion, stack_orientation_deg)
    x, y, z = (
        interpolate_acceleration_at_step_middles(
            wave, motion.sampling_interval, time_step, MAX_SIMULATED_TIME_AFTER_RECORD_S
        )
        for wave in waves
    )
    gravity = np.stack([-x, -y, -STANDARD_GRAVITY - z], axis=1)
    each = round(FALL_CHECK_INTERVAL_S / time_step)
    for step, pull in enumerate(gravity, start=1):
        model.opt.gravity[:] = pull
        engine.mj_step(model, data)
        if step % each == 0:
            yield list(zip(data.xpos[1:].copy(), data.xmat[1:].reshape(-1, 3, 3).copy(), strict=True))


@cache
def _load_lmgc90() -> Any:
    """Load the shared object of LMGC90 by its path: its package would import a viewer."""
    found = find_spec("compas_lmgc90")
    (place,) = found.submodule_search_locations if found and found.submodule_search_locations else [""]
    path = next(Path(place).glob("_lmgc90*.so"))
    spec = spec_from_file_location("_lmgc90", path)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_UNIT_CUBE_VERTICES: Final = [
    (x, y, z) for z in (-0.5, 0.5) for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
]
_UNIT_CUBE_TRIANGLE_VERTICES: Final = [
    1, 3, 2, 1, 4, 3, 5, 6, 7, 5, 7, 8, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 4, 8, 3, 8, 7, 4, 1, 5, 4, 5, 8
]  # fmt: skip
_BASE_SIZE_M: Final = (20.0, 20.0, 1.0)
_UNIT_CUBE_BOTTOM_CORNERS: Final = np.array(_UNIT_CUBE_VERTICES[:4])


def lmgc90_poses(
    stack: BoxStack, motion: Motion, stack_orientation_deg: float, time_step: float
) -> Iterator[StonePoses]:
    """Yield the poses of the stones in LMGC90, one per `FALL_CHECK_INTERVAL_S`, relative to the moving base."""
    waves = ground_accelerations_along_stack_axes(motion, stack_orientation_deg)
    solver = _load_lmgc90().LMGC90Solver()
    solver.initialize(time_step, 0.5, False)
    solver.set_materials([STONE_DENSITY_KG_M3])
    solver.add_one_tact_behav("iqsc0", "IQS_CLB", [stack.friction])
    solver.set_see_tables(CONTACT_SEARCH_DISTANCE_M)
    solver.set_nb_bodies(1 + len(stack.width_depth_height_by_stone))
    for size, centre in zip(
        (_BASE_SIZE_M, *stack.width_depth_height_by_stone),
        (-0.5 * _BASE_SIZE_M[2], *stack.centre_heights_at_rest),
        strict=True,
    ):
        corners = [side * length for corner in _UNIT_CUBE_VERTICES for side, length in zip(corner, size, strict=True)]
        driven = 6 if size is _BASE_SIZE_M else 0
        solver.set_one_polyr("s0001", [0.0, 0.0, centre], _UNIT_CUBE_TRIANGLE_VERTICES, corners, driven, 0)
    interval = motion.sampling_interval
    for axis, wave in enumerate(waves, start=1):
        times, velocity = _times_and_ground_velocities(wave, interval)
        solver.set_drvdof(1, axis, [*times.tolist(), *velocity.tolist()], True, True)
    for axis in (4, 5, 6):
        solver.set_drvdof(1, axis, [0.0, 1e3, 0.0, 0.0], True, True)
    solver.close_before_computing()
    each = round(FALL_CHECK_INTERVAL_S / time_step)
    steps = int((motion.sample_count * interval + MAX_SIMULATED_TIME_AFTER_RECORD_S) / time_step)
    # The rows of a frame are the principal axes of inertia, whose order is the solver's choice.
    initial = [np.reshape(frame, (3, 3)) for frame in solver.get_initial_state().init_body_frames]
    origin = np.array([0.0, 0.0, 0.5 * _BASE_SIZE_M[2]])
    try:
        for step in range(1, steps + 1):
            state = solver.compute_one_step()
            if step % each == 0:
                places = np.array(state.bodies) - state.bodies[0] - origin
                frames = [np.reshape(frame, (3, 3)) for frame in state.body_frames]
                turns = [now.T @ first for now, first in zip(frames, initial, strict=True)]
                yield list(zip(places[1:], turns[1:], strict=True))
    finally:
        solver.finalize()


def _times_and_ground_velocities(
    acceleration_of_one_component: FloatArray, sampling_interval: float, parts_per_sampling_interval: int = 4
) -> tuple[FloatArray, FloatArray]:
    """Return times, s, and exact velocities, m/s, for an acceleration that is linear between samples, then zero."""
    fine = np.interp(
        np.arange(parts_per_sampling_interval * acceleration_of_one_component.size) / parts_per_sampling_interval,
        np.arange(acceleration_of_one_component.size + 1),
        [*acceleration_of_one_component, 0],
    )
    velocity = np.concatenate(
        [[0.0], np.cumsum(0.5 * (fine[1:] + fine[:-1])) * sampling_interval / parts_per_sampling_interval]
    )
    times = np.arange(velocity.size) * sampling_interval / parts_per_sampling_interval
    return np.append(times, 1e3), np.append(velocity, velocity[-1])


def min_tilt_to_count_as_fallen(stack: BoxStack, stone_index: int) -> float:
    """Return the least tilt of a fallen stone, rad: 60° or, if larger, midway from critical angle to 90°."""
    return max(MIN_TILT_COUNTED_AS_FALLEN_RAD, 0.5 * (critical_angle(stack, stone_index) + 0.5 * math.pi))


def critical_angle(stack: BoxStack, stone_index: int) -> float:
    """Return the tilt about the nearest edge of its contact area at which a stone is in balance, rad."""
    width = min(
        side
        for size in stack.width_depth_height_by_stone[max(stone_index - 1, 0) : stone_index + 1]
        for side in size[:2]
    )
    return math.atan2(width, stack.width_depth_height_by_stone[stone_index][2])


def topmost_stone_outcome_in_engine(
    engine: StackEngine, stack: BoxStack, motion: Motion, stack_orientation_deg: float, time_step: float
) -> TopmostStoneOutcome:
    """Return the outcome of the topmost stone of a stack in an engine.

    A stone has fallen when its tilt exceeds `min_tilt_to_count_as_fallen`, or its centre is lower than at rest by a
    tenth of its height. The run ends with the first fall, or after the record, once all stones stand upright.
    """
    heights = [size[2] for size in stack.width_depth_height_by_stone]
    lowest = [
        z - MIN_DROP_TO_HEIGHT_RATIO_OF_FALLEN_STONE * height
        for z, height in zip(stack.centre_heights_at_rest, heights, strict=True)
    ]
    largest = [min_tilt_to_count_as_fallen(stack, stone) for stone in range(len(heights))]
    peak, slip, sinking = 0.0, 0.0, 0.0
    end = motion.sample_count * motion.sampling_interval
    for number, poses in enumerate(engine(stack, motion, stack_orientation_deg, time_step), start=1):
        tilts = [math.acos(max(-1.0, min(1.0, turn[2, 2]))) for _, turn in poses]
        for stone, (place, _) in enumerate(poses):
            if tilts[stone] > largest[stone] or place[2] < lowest[stone]:
                x, y, _ = poses[-1][1][:, 2]
                azimuth = float((stack_orientation_deg - math.degrees(math.atan2(y, x))) % 360.0)
                time = number * FALL_CHECK_INTERVAL_S
                return TopmostStoneOutcome(azimuth, time, stone, math.degrees(tilts[stone]), slip, sinking)
        peak, slip = max(peak, tilts[-1]), max(slip, _largest_slip_of_upright_stones_m(stack, poses, tilts))
        sinking = max(sinking, _largest_corner_penetration_m(stack, poses))
        if (
            number * FALL_CHECK_INTERVAL_S > end + MIN_SIMULATED_TIME_AFTER_RECORD_S
            and max(tilts) < MAX_UPRIGHT_TILT_RAD
        ):
            break
    return TopmostStoneOutcome(math.nan, math.nan, -1, math.degrees(peak), slip, sinking)


def _largest_slip_of_upright_stones_m(
    stack: BoxStack, pose_of_each_stone: StonePoses, tilt_rad_by_stone: list[float]
) -> float:
    """Return the largest distance of the base of an upright stone from the centre of the face below, m."""
    below, largest = np.zeros(2), 0.0
    for (place, turn), (_, _, height), tilt in zip(
        pose_of_each_stone, stack.width_depth_height_by_stone, tilt_rad_by_stone, strict=True
    ):
        half = 0.5 * height * turn[:2, 2]
        if tilt < MAX_UPRIGHT_TILT_RAD:
            largest = max(largest, float(np.hypot(*(place[:2] - half - below))))
        below = place[:2] + half
    return largest


def _largest_corner_penetration_m(stack: BoxStack, pose_of_each_stone: StonePoses) -> float:
    """Return the largest penetration of a corner of a stone's base into the face below, m."""
    largest = 0.0
    for (place, turn), size, (low_place, low_turn), low_size in zip(
        pose_of_each_stone[1:],
        stack.width_depth_height_by_stone[1:],
        pose_of_each_stone[:-1],
        stack.width_depth_height_by_stone[:-1],
        strict=True,
    ):
        corners = (place + (_UNIT_CUBE_BOTTOM_CORNERS * size) @ turn.T - low_place) @ low_turn
        above = (np.abs(corners[:, :2]) <= 0.5 * np.array(low_size[:2])).all(axis=1)
        if above.any():
            largest = max(largest, float((0.5 * low_size[2] - corners[above, 2]).max()))
    return largest


STACK_ENGINES: Final[dict[str, StackEngine]] = {"MuJoCo": mujoco_poses, "LMGC90": lmgc90_poses}
MODULE_NAME_BY_STACK_ENGINE: Final = {"MuJoCo": "mujoco", "LMGC90": "compas_lmgc90"}
