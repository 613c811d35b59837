"""Whether a scene is at rest, so that it need not be followed where the shaking cannot move it (docs/method.md)."""

from typing import Any, Final

from numba import njit

from overturning.dem.kernel.ending import UPRIGHT, is_still
from overturning.dem.kernel.lanes import INNER
from overturning.dem.polygon import rows
from overturning.dem.polygon.verdict import contacts

IN_PLACE: Final = 0.2
"""At rest an element has slid by no more than this share of the arm that its tipping has, so that its joints bear
nearly what they did."""

BOTH: Final = 2
"""Ends of a joint."""


@njit(**INNER)
def rests(state: Any, j: int, scene: Any) -> bool:
    """Whether all elements stand where they stood, on both ends of what carried them, and nothing moves or slides."""
    case, height = rows.load_case(state, j), 0.0
    elements, step = scene.elements[int(case.variant)], case.step * case.attempt.length
    if case.verdict.again > 0.0:
        return False
    for i in range(elements.size):
        item = rows.load_element(rows.of_element(state, i), j)
        if elements[i].is_free == 0.0:
            continue
        height = abs(item.home.base_z)
        tilt, slip = abs(item.pose.angle), abs(item.standing.slip)
        if item.standing.side != 0.0 or tilt > UPRIGHT * item.inertia.critical:
            return False
        if slip > IN_PLACE * item.inertia.critical * height:
            return False
        v, a = item.velocity, item.acceleration
        speed, change = abs(v.x) + abs(v.z) + height * abs(v.w), abs(a.x) + abs(a.z) + height * abs(a.w)
        if not is_still(speed, change, step, case.bears):
            return False
    for p in range(scene.layout.shape[0]):
        q, _, _ = rows.of_pair(state, scene, p)
        pair = rows.load_pair(q, j)
        slides = pair.slid_one != 0.0 or pair.slid_two != 0.0  # what is open may, too
        if contacts(pair) != (0 if pair.stands == 0.0 else BOTH) or (pair.stands != 0.0 and slides):
            return False
    return True
