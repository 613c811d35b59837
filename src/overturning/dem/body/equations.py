"""The equations of the centred scheme in space: what each point of contact adds to them, and their solution by blocks."""

import math

from numba import njit

from overturning.dem.body.centred_rows import Change, Equations, Predicted, PredictedPoint
from overturning.dem.body.state import Body, Frame, Memory, State, frame_of, in_space
from overturning.dem.kernel.lanes import INLINE
from overturning.units import STANDARD_GRAVITY as GRAVITY


@njit(**INLINE)
def held(most: float, square: float, slides: bool) -> float:
    """Which part of the force that would hold a sliding point, given by its square, friction is: from 0 to 1."""
    part = most / math.sqrt(square if slides else 1.0)
    part = part if part < 1.0 else 1.0
    return part if part > 0.0 else 0.0


@njit(**INLINE)
def contribution(body: Body, half: float, t: PredictedPoint, old: Memory, fine: bool) -> Equations:
    """A point's part in the equations, f' = f − G (e_v + e_w × r): a sliding one carries μ times its normal force.

    Across its direction a sliding point is held as if it stuck, in the proportion of friction to what would hold it.
    """
    on, slides = t.on > 0.0, t.slides > 0.0
    press, stick = body.dashpot + half * body.stiffness, body.dashpot + half * body.tangential
    n = body.stiffness * t.depth - body.dashpot * t.uz
    hx, hy = -(body.tangential * t.tx) - body.dashpot * t.ux, -(body.tangential * t.ty) - body.dashpot * t.uy
    part = held(body.friction * (n if fine else old.normal), hx * hx + hy * hy, slides)
    mx, my = body.friction * t.dx, body.friction * t.dy
    fx, fy = (mx * n if slides else hx), (my * n if slides else hy)
    across = half * (stick * part if slides else stick)
    gxx = across * (1.0 - t.dx * t.dx if slides else 1.0)
    gyy = across * (1.0 - t.dy * t.dy if slides else 1.0)
    gxy = -(across * (t.dx * t.dy)) if slides else 0.0
    gzz = half * press
    gxz, gyz = (mx * gzz if slides else 0.0), (my * gzz if slides else 0.0)
    n, fx, fy = (n if on else 0.0), (fx if on else 0.0), (fy if on else 0.0)
    gxx, gyy, gxy = (gxx if on else 0.0), (gyy if on else 0.0), (gxy if on else 0.0)
    gxz, gyz, gzz = (gxz if on else 0.0), (gyz if on else 0.0), (gzz if on else 0.0)
    rx, ry, rz = t.rx, t.ry, t.rz
    # Columns of G and of G(·× r), and their moments r × column.
    b11, b21, b31 = ry * gxz - rz * gxy, ry * gyz - rz * gyy, ry * gzz
    b12, b22, b32 = rz * gxx - rx * gxz, rz * gxy - rx * gyz, -(rx * gzz)
    b13, b23, b33 = rx * gxy - ry * gxx, rx * gyy - ry * gxy, 0.0
    return Equations(
        fx, fy, n, ry * n - rz * fy, rz * fx - rx * n, rx * fy - ry * fx,
        gxx, gxy, gxz, gxy, gyy, gyz, 0.0, 0.0, gzz,
        b11, b12, b13, b21, b22, b23, b31, b32, b33,
        -(rz * gxy), -(rz * gyy), ry * gzz - rz * gyz, rz * gxx, rz * gxy, rz * gxz - rx * gzz,
        rx * gxy - ry * gxx, rx * gyy - ry * gxy, rx * gyz - ry * gxz,
        ry * b31 - rz * b21, ry * b32 - rz * b22, ry * b33 - rz * b23,
        rz * b11 - rx * b31, rz * b12 - rx * b32, rz * b13 - rx * b33,
        rx * b21 - ry * b11, rx * b22 - ry * b12, rx * b23 - ry * b13,
    )  # fmt: skip


@njit(**INLINE)
def inverse(m: Frame) -> Frame:
    """Inverse of a matrix by cofactors, arranged so that x and y may change places."""
    zx, zy, zz = m.xy * m.yz - m.xz * m.yy, m.xz * m.yx - m.xx * m.yz, m.xx * m.yy - m.xy * m.yx
    one = 1.0 / ((m.zx * zx + m.zy * zy) + m.zz * zz)
    return Frame(
        one * (m.yy * m.zz - m.yz * m.zy), one * (m.xz * m.zy - m.xy * m.zz), one * zx,
        one * (m.yz * m.zx - m.yx * m.zz), one * (m.xx * m.zz - m.xz * m.zx), one * zy,
        one * (m.yx * m.zy - m.yy * m.zx), one * (m.xy * m.zx - m.xx * m.zy), one * zz,
    )  # fmt: skip


@njit(**INLINE)
def times(a: Frame, b: Frame) -> Frame:
    """Product of two matrices."""
    p, q, r = in_space(a, b.xx, b.yx, b.zx), in_space(a, b.xy, b.yy, b.zy), in_space(a, b.xz, b.yz, b.zz)
    return Frame(p.x, q.x, r.x, p.y, q.y, r.y, p.z, q.z, r.z)


@njit(**INLINE)
def solve(body: Body, s: State, w: Predicted, q: Equations) -> Change:
    """Velocities at the end of the step, with springs and dashpots taken there, by blocks."""
    half = w.half
    ux = half * ((q.fx + w.push_x) - s.ax)
    uy = half * ((q.fy + w.push_y) - s.ay)
    uz = half * ((q.fz - (GRAVITY + w.lift)) - s.az)
    tx, ty, tz = half * (q.mx - s.mx), half * (q.my - s.my), half * (q.mz - s.mz)
    f = frame_of(w.qw, w.qx, w.qy, w.qz)
    turned = times(f, Frame(body.axx, body.axy, body.axz, body.axy, body.ayy, body.ayz, body.axz, body.ayz, body.azz))
    i = times(turned, Frame(f.xx, f.yx, f.zx, f.xy, f.yy, f.zy, f.xz, f.yz, f.zz))
    a = inverse(Frame(1.0 + q.a11, q.a12, q.a13, q.a21, 1.0 + q.a22, q.a23, q.a31, q.a32, 1.0 + q.a33))
    c = times(Frame(q.c11, q.c12, q.c13, q.c21, q.c22, q.c23, q.c31, q.c32, q.c33), a)
    b = times(c, Frame(q.b11, q.b12, q.b13, q.b21, q.b22, q.b23, q.b31, q.b32, q.b33))
    d = inverse(Frame(
        (i.xx + q.d11) - b.xx, (i.xy + q.d12) - b.xy, (i.xz + q.d13) - b.xz,
        (i.yx + q.d21) - b.yx, (i.yy + q.d22) - b.yy, (i.yz + q.d23) - b.yz,
        (i.zx + q.d31) - b.zx, (i.zy + q.d32) - b.zy, (i.zz + q.d33) - b.zz,
    ))  # fmt: skip
    known = in_space(c, ux, uy, uz)
    e = in_space(d, tx - known.x, ty - known.y, tz - known.z)
    v = in_space(
        a,
        ux - ((q.b11 * e.x + q.b12 * e.y) + q.b13 * e.z),
        uy - ((q.b21 * e.x + q.b22 * e.y) + q.b23 * e.z),
        uz - ((q.b31 * e.x + q.b32 * e.y) + q.b33 * e.z),
    )
    return Change(v.x, v.y, v.z, e.x, e.y, e.z)
