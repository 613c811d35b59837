"""Trajectory of a scene: columns of its rows, the functions that fill them, and the conversion to a `PlanePath`.

A row holds time and ground acceleration, six columns for each element, and five for each of the two ends of each pair.
"""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.dem.kernel.ground import within_sample
from overturning.dem.kernel.lanes import INNER
from overturning.dem.path import PlanePath
from overturning.dem.polygon import rows
from overturning.dem.polygon.memory import end_normal, end_position
from overturning.dem.polygon.prepare import Prepared
from overturning.dem.polygon.state import MINE, OPEN

TIME, GROUND = range(2)
POSE_COLUMNS: Final = 6
"""Columns of an element: x, z, rotation and their rates."""
FX, FZ, LOAD, LOAD_X, LOAD_Z = range(5)
FORCE_COLUMNS: Final = 5
"""Columns of an end: mean force on the pair's first element until the next sample (x, z), mean normal force, and
mean of normal force × place (x, z)."""


@njit(**INNER)
def record_state(state: Any, elements: int, interval: float, ticks: float, path: Any) -> None:
    """Write the state of lane 0 at the start of a sample into a row of its path, with velocities at the whole step."""
    case = rows.load_case(state, 0)
    path[TIME] = (case.sample + case.shaking.tick / ticks) * interval
    path[GROUND] = within_sample(case.shaking.base, case.shaking.tick)
    half = case.lag
    for e in range(elements):
        item = rows.load_element(rows.of_element(state, e), 0)
        pose, v, a = item.pose, item.velocity, item.acceleration
        at = 2 + POSE_COLUMNS * e
        path[at], path[at + 1], path[at + 2] = pose.x, pose.z, pose.angle
        path[at + 3], path[at + 4], path[at + 5] = v.x + half * a.x, v.z + half * a.z, v.w + half * a.w


@njit(**INNER)
def add_forces(state: Any, scene: Any, share: float, path: Any, row: int) -> None:
    """Add the contact forces of lane 0, times the `share` of a sample in which they act, to a row of its path."""
    for p in range(scene.layout.shape[0]):
        q, first, second = rows.pair_and_element_rows(state, scene, p)
        pair, a, b = rows.load_pair(q, 0), rows.load_pose(first, 0), rows.load_pose(second, 0)
        for end in range(2):
            memory = pair.history.one if end == 0 else pair.history.two
            if memory.carrier == OPEN:
                continue
            n, tangent, mine = share * memory.normal, share * memory.tangent, memory.carrier == MINE
            (rx, rz), (nx, nz) = end_position(pair, a, b, end, mine), end_normal(a, b, pair.face_a, pair.face_b, mine)
            at = 2 + POSE_COLUMNS * scene.elements.shape[1] + FORCE_COLUMNS * (2 * p + end)
            path[row, at + FX] += n * nx + tangent * nz
            path[row, at + FZ] += n * nz - tangent * nx
            path[row, at + LOAD] += n
            path[row, at + LOAD_X] += n * (a.x + rx)
            path[row, at + LOAD_Z] += n * (a.z + rz)


def path_columns(prepared: Prepared) -> int:
    """Return the number of columns of a path."""
    return 2 + POSE_COLUMNS * len(prepared.placed) + 2 * FORCE_COLUMNS * len(prepared.pairs)


def scene_path(prepared: Prepared, table: FloatArray) -> PlanePath:
    """Convert the rows of a path to a `PlanePath`."""
    placed, ends = prepared.placed, 2 * len(prepared.pairs)
    poses_end = 2 + POSE_COLUMNS * len(placed)
    forces = table[:, poses_end:].reshape(len(table), ends, FORCE_COLUMNS)
    force, load = forces[:, :, [FX, FZ]], forces[:, :, [LOAD]]
    contacts: list[tuple[str, str]] = []
    for index, pair in enumerate(prepared.pairs):
        # Force on the later element, which stands on the earlier one; on the earlier one if the later is fixed.
        on, by = sorted((pair.a, pair.b), key=lambda k: (placed[k].fixed, -k))
        if on == pair.b:
            force[:, 2 * index : 2 * index + 2] *= -1.0
        contacts += 2 * [(placed[on].element.name, placed[by].element.name)]
    return PlanePath(
        scene=prepared.scene,
        placed=placed,
        critical=prepared.alpha,
        time=table[:, TIME],
        ground=table[:, GROUND],
        poses=table[:, 2:poses_end].reshape(len(table), len(placed), POSE_COLUMNS),
        force=force,
        place=forces[:, :, [LOAD_X, LOAD_Z]] / np.where(load > 0.0, load, np.nan),
        contacts=contacts,
    )
