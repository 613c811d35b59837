"""The energy account of a column: energy of its elements and springs, and the work of its contacts."""

from typing import Any

from numba import njit

from overturning.dem.kernel.lanes import INNER
from overturning.dem.polygon import rows
from overturning.dem.polygon.faces import carried, seen_before
from overturning.dem.polygon.state import OPEN, THEIRS, Element, Pair


@njit(**INNER)
def energy(state: Any, j: int, scene: Any) -> float:
    """Kinetic and gravitational energy of a column at the last half step, spring energy at the whole step before, J."""
    total = 0.0
    for p in range(scene.layout.shape[0]):
        q, _, _ = rows.of_pair(state, scene, p)
        total += springs(rows.load_pair(q, j))
    return total + moving_energy(state, j, scene)


@njit(**INNER)
def moving_energy(state: Any, j: int, scene: Any) -> float:
    """Kinetic and gravitational energy of a column at the last half step, J."""
    total, half = 0.0, rows.load_case(state, j).lag
    for e in range(scene.elements.shape[1]):
        item = rows.load_element(rows.of_element(state, e), j)
        if item.inertia.inverse_mass != 0.0:
            height = item.pose.z - half * item.velocity.z
            total += kinetic(item) + item.inertia.mass * scene.gravity * height
    return total


@njit(**INNER)
def springs(pair: Pair) -> float:
    """Energy of a pair's springs, J."""
    total, history = 0.0, pair.history
    for end in range(2):
        memory = history.one if end == 0 else history.two
        if memory.carrier != OPEN:
            depth = carried(memory, end, history.before).depth
            total += 0.5 * (pair.law.normal * depth * depth + pair.law.tangential * (memory.spring * memory.spring))
    return total


@njit(**INNER)
def kinetic(e: Element) -> float:
    """Kinetic energy of an element, J, from the velocities half a step back."""
    v, own = e.velocity, e.inertia
    return float(0.5 * (own.mass * (v.x * v.x + v.z * v.z) + v.w * v.w / own.inverse_inertia))


@njit(**INNER)
def closing_work(state: Any, j: int, scene: Any) -> float:
    """Work of the contacts in the half step that separates the last forces from the last velocities, J.

    The energy that the scheme gives an element is force times displacement, half of it before and half after the whole
    step at which the force acts; `history_of` enters the second half with the next step.
    """
    work = 0.0
    for p in range(scene.layout.shape[0]):
        q, a, b = rows.of_pair(state, scene, p)
        pair = rows.load_pair(q, j)
        history = pair.history
        if history.one.carrier == OPEN and history.two.carrier == OPEN:
            continue
        later = seen_before(pair, rows.load_element(a, j), rows.load_element(b, j), 0.0)
        for end in range(2):
            memory = history.one if end == 0 else history.two
            old, new = carried(memory, end, history.before), carried(memory, end, later)
            slip = old.place - new.place
            slip = -slip if memory.carrier == THEIRS else slip
            work += 0.5 * (memory.normal * (new.depth - old.depth) - memory.tangent * slip)
    return work
