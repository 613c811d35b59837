"""What a trajectory keeps of a column: poses, velocities and contact forces."""

from typing import Any

from numba import njit

from overturning.dem.kernel.lanes import OPTIONS
from overturning.dem.polygon import rows
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.memory import end_place


@njit(**OPTIONS)
def note(state: Any, j: int, elements: int, interval: float, ticks: float, path: Any) -> None:
    """Write a column's state at the begin of a sample into a row of its trajectory, velocities brought to the whole step."""
    case = rows.load_case(state, j)
    base, tick = case.shaking.base, case.shaking.tick
    path[t.T_TIME] = (case.sample + tick / ticks) * interval
    path[t.T_GROUND] = base.value + base.slope * tick
    half = case.lag
    for e in range(elements):
        item = rows.load_element(rows.of_element(state, e), j)
        pose, v, a = item.pose, item.velocity, item.acceleration
        to = 2 + 6 * e
        path[to + t.T_X], path[to + t.T_Z], path[to + t.T_ANGLE] = pose.x, pose.z, pose.angle
        path[to + t.T_VX], path[to + t.T_VZ] = v.x + half * a.x, v.z + half * a.z
        path[to + t.T_VW] = v.w + half * a.w


@njit(**OPTIONS)
def note_forces(state: Any, j: int, layout: Any, elements: int, share: float, path: Any, row: int) -> None:
    """Add a step's share of a column's contact forces to the row of its trajectory, with the places where they act."""
    for p in range(layout.shape[0]):
        pair = rows.load_pair(rows.of_pair(state, elements, p), j)
        a, b = (
            rows.load_pose(rows.of_element(state, layout[p, 0]), j),
            rows.load_pose(rows.of_element(state, layout[p, 1]), j),
        )
        for end in range(2):
            memory = pair.one if end == 0 else pair.two
            if memory.carrier == rows.OPEN:
                continue
            n, tangent = share * memory.normal, share * memory.tangent
            rx, rz, nx, nz = end_place(pair, a, b, end, memory.carrier == rows.MINE)
            to = 2 + 6 * elements + t.FORCE_COLUMNS * (2 * p + end)
            path[row, to + t.T_FX] += n * nx + tangent * nz
            path[row, to + t.T_FZ] += n * nz - tangent * nx
            path[row, to + t.T_LOAD] += n
            path[row, to + t.T_LOAD_X] += n * (a.x + rx)
            path[row, to + t.T_LOAD_Z] += n * (a.z + rz)
