"""The energy account of a column: energy of its elements and springs, and the work of its contacts."""

from typing import Any

from numba import njit

from overturning.dem.kernel.lanes import OPTIONS
from overturning.dem.polygon import rows
from overturning.dem.polygon.faces import carried, seen_before
from overturning.dem.polygon.state import Element, Pair


@njit(**OPTIONS)
def energy(state: Any, j: int, layout: Any, elements: int, gravity: float) -> float:
    """Kinetic and gravitational energy of a column at the last half step and spring energy at the whole step before, J."""
    total = 0.0
    for p in range(layout.shape[0]):
        total += springs(rows.load_pair(rows.of_pair(state, elements, p), j))
    return total + moving_energy(state, j, elements, gravity)


@njit(**OPTIONS)
def moving_energy(state: Any, j: int, elements: int, gravity: float) -> float:
    """Kinetic and gravitational energy of a column at the last half step, J."""
    total = 0.0
    half = rows.load_case(state, j).lag
    for e in range(elements):
        item = rows.load_element(rows.of_element(state, e), j)
        if item.body.inverse_mass != 0.0:
            height = item.pose.z - half * item.velocity.z
            total += kinetic(item) + item.body.mass * gravity * height
    return total


@njit(**OPTIONS)
def springs(pair: Pair) -> float:
    """Energy of a pair's springs, J."""
    total = 0.0
    for end in range(2):
        memory = pair.one if end == 0 else pair.two
        if memory.carrier != rows.OPEN:
            depth = carried(memory, end, pair.before).depth
            total += 0.5 * (pair.law.normal * depth * depth + pair.law.tangential * (memory.spring * memory.spring))
    return total


@njit(**OPTIONS)
def kinetic(e: Element) -> float:
    """Kinetic energy of an element, J, from the velocities half a step back."""
    v, body = e.velocity, e.body
    return float(0.5 * (body.mass * (v.x * v.x + v.z * v.z) + v.w * v.w / body.inverse_inertia))


@njit(**OPTIONS)
def closing_work(state: Any, j: int, layout: Any, elements: int) -> float:
    """Work of the contacts in the half step that separates the last forces from the last velocities, J.

    The energy that the scheme gives a body is force times displacement, half of it before and half after the whole
    step at which the force acts; `overturning.dem.polygon.contact.act` enters the second half with the next step.
    """
    work = 0.0
    for p in range(layout.shape[0]):
        pair = rows.load_pair(rows.of_pair(state, elements, p), j)
        if pair.one.carrier == rows.OPEN and pair.two.carrier == rows.OPEN:
            continue
        a, b = rows.of_element(state, layout[p, 0]), rows.of_element(state, layout[p, 1])
        later = seen_before(pair, rows.load_element(a, j), rows.load_element(b, j), 0.0)
        for end in range(2):
            memory = pair.one if end == 0 else pair.two
            old, new = carried(memory, end, pair.before), carried(memory, end, later)
            slip = old.place - new.place
            slip = -slip if memory.carrier == rows.THEIRS else slip
            work += 0.5 * (memory.normal * (new.depth - old.depth) - memory.tangent * slip)
    return work
