"""What the centred scheme in space notes of a step before it is taken: named tuples; their rows are in `rows`."""

from typing import NamedTuple


class PredictedPoint(NamedTuple):
    """A point of contact at the predicted end of a step."""

    rx: float
    """From the centre, m;"""
    ry: float
    rz: float
    depth: float
    tx: float
    """stretch of the tangential springs, m;"""
    ty: float
    ux: float
    """velocity, m/s;"""
    uy: float
    uz: float
    on: float
    """1 where it is taken to be in contact,"""
    slides: float
    """and to slide,"""
    dx: float
    """friction pointing this way."""
    dy: float
    waits: float
    """1 where it does not carry before the ends of the base rest."""


class Rejected(NamedTuple):
    """Whether the last step was not accepted, and whether its points are taken to do the same in the next one: 1 or 0."""

    again: float
    sooner: float


class Predicted(NamedTuple):
    """A step of the centred scheme before its equations are solved."""

    x: float
    y: float
    z: float
    qw: float
    qx: float
    qy: float
    qz: float
    vx: float
    """Velocity and angular momentum after half the step;"""
    vy: float
    vz: float
    lx: float
    ly: float
    lz: float
    ex: float
    """velocity at its end,"""
    ey: float
    ez: float
    wx: float
    """angular velocity there;"""
    wy: float
    wz: float
    push_x: float
    push_y: float
    lift: float
    half: float
    """half its length, s."""


class Equations(NamedTuple):
    """Forces and moments at the predicted end, and what velocities there change of them, summed over the points of contact."""

    fx: float
    fy: float
    fz: float
    mx: float
    my: float
    mz: float
    a11: float
    """Force by velocity,"""
    a12: float
    a13: float
    a21: float
    a22: float
    a23: float
    a31: float
    a32: float
    a33: float
    b11: float
    """force by angular velocity,"""
    b12: float
    b13: float
    b21: float
    b22: float
    b23: float
    b31: float
    b32: float
    b33: float
    c11: float
    """moment by velocity,"""
    c12: float
    c13: float
    c21: float
    c22: float
    c23: float
    c31: float
    c32: float
    c33: float
    d11: float
    """moment by angular velocity."""
    d12: float
    d13: float
    d21: float
    d22: float
    d23: float
    d31: float
    d32: float
    d33: float


class Change(NamedTuple):
    """What the solution adds to the predicted velocities."""

    vx: float
    vy: float
    vz: float
    wx: float
    wy: float
    wz: float


class Sum(NamedTuple):
    """What all points of contact do at the solution."""

    fx: float
    fy: float
    fz: float
    mx: float
    my: float
    mz: float
    px: float
    """what those closed within the step act for longer, as momentum"""
    py: float
    pz: float
    qx: float
    """and angular momentum;"""
    qy: float
    qz: float
    loss: float
    """power of dashpots and sliders,"""
    let_go: float
    """energy that springs let go."""


class Largest(NamedTuple):
    """The largest of what is found at any point of contact, 0 or less where it is found at none."""

    changed: float
    """Above 0 where a contact opened or closed,"""
    wrong: float
    """1 where a point was taken to do otherwise,"""
    reversed: float
    """or to slide against its velocity,"""
    holds: float
    """or holds,"""
    back: float
    """or slides where friction held it the other way before,"""
    off: float
    """or is in the air;"""
    depth: float
