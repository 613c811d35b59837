"""The books: energy of a column, and the work of its contacts."""

from typing import Any

import numpy as np
from numba import njit

# isort: off
from overturning.dem.polygon.columns import (
    COLUMNS, CONTACT, DA1, INVERSE_INERTIA, INVERSE_MASS, KN, KS, MASS, NORMAL, OPEN, OPTIONS, SECOND, SPRING, STEP,
    TANGENT, THEIRS, VW, VX, VZ, Z, element_rows, pair_rows,
)  # fmt: skip

# isort: on
from overturning.dem.polygon.faces import depth_row, depths_before


@njit(**OPTIONS)
def energy(state: Any, j: int, layout: Any, elements: int, gravity: float) -> float:
    """Kinetic and gravitational energy of a column at the last half step and spring energy at the whole step before, J."""
    total = 0.0
    for p in range(layout.shape[0]):
        total += springs(pair_rows(state, elements, p), j)
    return total + moving_energy(state, j, elements, gravity)


@njit(**OPTIONS)
def moving_energy(state: Any, j: int, elements: int, gravity: float) -> float:
    """Kinetic and gravitational energy of a column at the last half step, J."""
    total = 0.0
    for e in range(elements):
        body = element_rows(state, e)
        if body[INVERSE_MASS + j] == 0.0:
            continue
        height = body[Z + j] - 0.5 * state[STEP + j] * body[VZ + j]
        total += kinetic(body, j) + body[MASS + j] * gravity * height
    return total


@njit(**OPTIONS)
def springs(q: Any, j: int) -> float:
    """Energy of a pair's springs, J."""
    total = 0.0
    for end in range(2):
        memory = q[CONTACT + end * SECOND + j]
        if memory != OPEN:
            depth = q[depth_row(memory != THEIRS, end) + j]
            total += 0.5 * (q[KN + j] * depth * depth + q[KS + j] * q[SPRING + end * SECOND + j] ** 2)
    return total


@njit(**OPTIONS)
def kinetic(e: Any, j: int) -> float:
    """Kinetic energy of an element, J, from the velocities half a step back."""
    vx, vz, vw = e[VX + j], e[VZ + j], e[VW + j]
    return float(0.5 * (e[MASS + j] * (vx * vx + vz * vz) + vw * vw / e[INVERSE_INERTIA + j]))


@njit(**OPTIONS)
def closing_work(state: Any, j: int, layout: Any, elements: int) -> float:
    """Work of the contacts in the half step that separates the last forces from the last velocities, J.

    The energy that the scheme gives a body is force times displacement, half of it before and half after the whole
    step at which the force acts; `overturning.dem.polygon.contact.push` books the second half with the next step.
    """
    work = 0.0
    before = np.empty(8)
    for p in range(layout.shape[0]):
        q = pair_rows(state, elements, p)
        if q[CONTACT + j] == OPEN and q[CONTACT + SECOND + j] == OPEN:
            continue
        for k in range(8):
            before[k] = q[DA1 + k * COLUMNS + j]
        depths_before(q, element_rows(state, layout[p, 0]), element_rows(state, layout[p, 1]), j, 0.0)
        for end in range(2):
            at = end * SECOND + j
            mine = q[CONTACT + at] != THEIRS
            row = depth_row(mine, end)
            k = (row - DA1) // COLUMNS
            depth = q[row + j] - before[k]
            slip = before[k + 1] - q[row + COLUMNS + j]
            slip = slip if mine else -slip
            work += 0.5 * (q[NORMAL + at] * depth - q[TANGENT + at] * slip)
        for k in range(8):
            q[DA1 + k * COLUMNS + j] = before[k]
    return work
