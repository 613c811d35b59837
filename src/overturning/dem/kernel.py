"""Gravestones side by side: up to 64 blocks on one moving base, a column each.

All jitted code of the kernel is in this file, which is why it is longer than others (see `overturning.dem.cache`).
The mechanics, the schemes and the order
of the operations are derived in docs/method.md. What matters for speed and for equal bits:

- the state is one local float64 array; quantity ``Q`` of column ``j`` is ``state[Q + j]``, so that the loops over the
  columns address one base with constant offsets and turn into full-width vector code;
- those loops have no branches, only selections, and no libm; fast-math and contraction are off;
- left and right corner are summed as one pair, which makes the mirrored case exact;
- a column never sees another one: what it computes depends on its case alone.

Units per unit of mass: a stiffness is K/m (1/s²), a dashpot h/m (1/s), a force an acceleration.
"""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.cache import keep_compiled, prefer_full_width

prefer_full_width()

COLUMNS: Final = 64
"""Blocks side by side; at 64 the latency of one column's chain of operations is hidden."""

TICKS: Final = 32
"""A step in which a contact opens or closes is done again in this many ticks,"""

EARLY_TICKS: Final = 64.0
"""so many of them one by one,"""

LATE_TICKS: Final = 4
"""then so many at a time,"""

SETTLING: Final = 8.0
"""until this time has passed, in 1/ω of the highest mode: the contact's transient is over."""

# One row of COLUMNS numbers each: constants of the case,
(HALF_WIDTH, HALF_HEIGHT, INERTIA, STIFFNESS, TANGENTIAL, COMPLIANCE, DASHPOT, FRICTION, ALPHA, STEP) = (
    i * COLUMNS for i in range(10)
)
# the position (angle with its cosine and sine), velocity and acceleration, the tangential springs,
(X, Z, ANGLE, COS, SIN, VX, VZ, VW, AX, AZ, AW, SPRING_L, SPRING_R) = (i * COLUMNS for i in range(10, 23))
# the corners one step ago,
(OLD_XL, OLD_UL, OLD_XR, OLD_UR) = (i * COLUMNS for i in range(23, 27))
# ground acceleration: value, slope and change of slope over the ticks of this sample and the next,
(TICK, BASE, SLOPE, BEND, UP_BASE, UP_SLOPE, UP_BEND, FINE) = (i * COLUMNS for i in range(27, 35))
# what is booked on the way.
(PEAK_ANGLE, LAST_UPRIGHT, PEAK_SLIP, PEAK_DEPTH, WORK, LOST, POWER, LOSS) = (i * COLUMNS for i in range(35, 43))
# what is looked at once per sample only,
(AMPLITUDE, SAMPLE, UPRIGHT_UNTIL, ENERGY, BARRIER, CALM, AFTER) = (i * COLUMNS for i in range(43, 50))
# and 1/(1 + β), 1/(1 + 2β) with β = h Δt/2m of the three lengths of a step.
(ONE_WHOLE, TWO_WHOLE, ONE_LATE, TWO_LATE, ONE_EARLY, TWO_EARLY, WINDOW) = (i * COLUMNS for i in range(50, 57))
ROWS: Final = 57

# Columns of the case table that `run_queue` takes.
(P_WIDTH, P_HEIGHT, P_STIFFNESS, P_TANGENTIAL, P_DASHPOT, P_FRICTION, P_ALPHA, P_AMPLITUDE) = range(8)
(P_TILT_COS, P_TILT_SIN, P_TILT, P_FIRST, P_CALM, P_AFTER, P_WINDOW) = range(8, 15)
PARAMETERS: Final = 15

# Columns of its results.
(R_STATUS, R_SIDE, R_TIME, R_ANGLE, R_SLIP, R_RESIDUAL, R_DEPTH, R_ENERGY, R_STEPS) = range(9)
RESULTS: Final = 9

# Columns of a trajectory.
(
    T_TIME, T_X, T_Z, T_ANGLE, T_VX, T_VZ, T_VW, T_BASE_SLIP, T_DEPTH_L, T_DEPTH_R, T_GROUND
) = range(11)  # fmt: skip
TRAJECTORY: Final = 11

REST_ENERGY: Final = 1e-9
"""Kinetic energy, as a fraction of g B/2, below which a block on both corners is at rest."""

_options: dict[str, Any] = {"fastmath": False, "error_model": "numpy", "boundscheck": False}


@njit(**_options)
def advance_cundall(state: Any, columns: int, steps: int, gravity: float) -> None:
    """Cundall's scheme: central differences, spring at the whole step, dashpot at the half step before it."""
    for _ in range(steps):
        for j in range(columns):
            b, h, dt = state[HALF_WIDTH + j], state[HALF_HEIGHT + j], state[STEP + j]
            k, ks, mu = state[STIFFNESS + j], state[TANGENTIAL + j], state[FRICTION + j]
            x, z, c, s = state[X + j], state[Z + j], state[COS + j], state[SIN + j]
            vx, vz, vw = state[VX + j], state[VZ + j], state[VW + j]
            tick = state[TICK + j]
            ground = state[BASE + j] + state[SLOPE + j] * tick
            up = state[UP_BASE + j] + state[UP_SLOPE + j] * tick
            # Corners from the centre; (x, z) of a point of the block turned clockwise.
            rxl, rzl = -(b * c) - h * s, b * s - h * c
            rxr, rzr = b * c - h * s, -(b * s) - h * c
            xl, ul, xr, ur = x + rxl, -(z + rzl), x + rxr, -(z + rzr)
            dxl, dul = xl - state[OLD_XL + j], ul - state[OLD_UL + j]
            dxr, dur = xr - state[OLD_XR + j], ur - state[OLD_UR + j]
            was_l, was_r = state[OLD_UL + j] > 0.0, state[OLD_UR + j] > 0.0
            hdt = state[DASHPOT + j] / dt
            # Normal force: spring and dashpot while the corner is in, never tension.
            nl, nr = k * ul + hdt * dul, k * ur + hdt * dur
            nl = nl if (ul > 0.0) & (nl > 0.0) else 0.0
            nr = nr if (ur > 0.0) & (nr > 0.0) else 0.0
            # Tangential force with slider; a new contact starts with an unstretched spring.
            tl = state[SPRING_L + j] + dxl if was_l else 0.0
            tr = state[SPRING_R + j] + dxr if was_r else 0.0
            ml, mr = mu * nl, mu * nr
            fl, fr = -(ks * tl) - hdt * dxl, -(ks * tr) - hdt * dxr
            fl = ml if fl > ml else fl
            fr = mr if fr > mr else fr
            fl = -ml if fl < -ml else fl
            fr = -mr if fr < -mr else fr
            el, er = ml * state[COMPLIANCE + j], mr * state[COMPLIANCE + j]
            sl = el if tl > el else tl
            sr = er if tr > er else tr
            sl = -el if sl < -el else sl
            sr = -er if sr < -er else sr
            # Accelerations in the frame of the base; left and right corner as one pair.
            ax = (fl + fr) - ground
            az = (nl + nr) - (gravity + up)
            aw = state[INERTIA + j] * ((rzl * fl - rxl * nl) + (rzr * fr - rxr * nr))
            # Velocities at the whole step, for the books only.
            half = 0.5 * dt
            cx, cz, cw = vx + half * ax, vz + half * az, vw + half * aw
            pl, pr = ul if ul > 0.0 else 0.0, ur if ur > 0.0 else 0.0
            ql, qr = (state[OLD_UL + j] if was_l else 0.0), (state[OLD_UR + j] if was_r else 0.0)
            ql, qr = (0.0 if ul > 0.0 else ql), (0.0 if ur > 0.0 else qr)
            # A spring that slips gives up what the falling limit takes, then slides against its own force.
            gl, gr = state[SPRING_L + j], state[SPRING_R + j]
            kept_l, kept_r = (el if gl > el else gl), (er if gr > er else gr)
            kept_l, kept_r = (-el if kept_l < -el else kept_l), (-er if kept_r < -er else kept_r)
            slid_l, slid_r = sl * ((kept_l - sl) + dxl), sr * ((kept_r - sr) + dxr)
            slid_l, slid_r = (slid_l if tl != sl else 0.0), (slid_r if tr != sr else 0.0)
            lost_l = (nl - k * pl) * (cz - rxl * cw) + (fl + ks * sl) * (cx + rzl * cw)
            lost_r = (nr - k * pr) * (cz - rxr * cw) + (fr + ks * sr) * (cx + rzr * cw)
            let_go = k * (ql * ql + qr * qr) + ks * ((gl * gl - kept_l * kept_l) + (gr * gr - kept_r * kept_r))
            let_go = 0.5 * let_go + ks * (slid_l + slid_r)
            work = state[WORK + j] - dt * (ground * cx + up * cz)
            state[WORK + j] = work
            state[LOST + j] = state[LOST + j] + (let_go - dt * (lost_l + lost_r))
            vx, vz, vw = vx + dt * ax, vz + dt * az, vw + dt * aw
            # Turn (c, s) by the small angle of the step.
            turn = dt * vw
            square = turn * turn
            sine = turn * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
            versine = square * (0.5 - square * (1.0 / 24.0))
            angle = state[ANGLE + j] + turn
            state[COS + j] = c - (c * versine + s * sine)
            state[SIN + j] = s - (s * versine - c * sine)
            size = abs(angle)
            slip = abs((x + dt * vx) - h * state[SIN + j])
            depth = ul if ul > ur else ur
            state[PEAK_ANGLE + j] = size if size > state[PEAK_ANGLE + j] else state[PEAK_ANGLE + j]
            state[PEAK_SLIP + j] = slip if slip > state[PEAK_SLIP + j] else state[PEAK_SLIP + j]
            state[PEAK_DEPTH + j] = depth if depth > state[PEAK_DEPTH + j] else state[PEAK_DEPTH + j]
            state[LAST_UPRIGHT + j] = tick + 1.0 * TICKS if size < state[ALPHA + j] else state[LAST_UPRIGHT + j]
            state[X + j], state[Z + j], state[ANGLE + j] = x + dt * vx, z + dt * vz, angle
            state[VX + j], state[VZ + j], state[VW + j] = vx, vz, vw
            state[AX + j], state[AZ + j], state[AW + j] = ax, az, aw
            state[SPRING_L + j], state[SPRING_R + j] = sl, sr
            state[OLD_XL + j], state[OLD_UL + j] = xl, ul
            state[OLD_XR + j], state[OLD_UR + j] = xr, ur
            state[TICK + j] = tick + 1.0 * TICKS


@njit(**_options)
def advance_centred(state: Any, columns: int, steps: int, gravity: float) -> None:
    """Velocity Verlet with the dashpots taken at the same instant as the springs; fine steps where contacts change."""
    ticks = float(steps * TICKS)
    for _ in range(steps):
        for j in range(columns):
            b, h, inertia = state[HALF_WIDTH + j], state[HALF_HEIGHT + j], state[INERTIA + j]
            k, ks, mu, dash = state[STIFFNESS + j], state[TANGENTIAL + j], state[FRICTION + j], state[DASHPOT + j]
            x, z, c, s = state[X + j], state[Z + j], state[COS + j], state[SIN + j]
            fine, old_tick, old_angle = state[FINE + j], state[TICK + j], state[ANGLE + j]
            ovx, ovz, ovw = state[VX + j], state[VZ + j], state[VW + j]
            oax, oaz, oaw = state[AX + j], state[AZ + j], state[AW + j]
            oxl, oul, oxr, our = state[OLD_XL + j], state[OLD_UL + j], state[OLD_XR + j], state[OLD_UR + j]
            gl, gr = state[SPRING_L + j], state[SPRING_R + j]
            peak, peak_slip, peak_depth = state[PEAK_ANGLE + j], state[PEAK_SLIP + j], state[PEAK_DEPTH + j]
            alpha, last, compliance = state[ALPHA + j], state[LAST_UPRIGHT + j], state[COMPLIANCE + j]
            old_work, old_lost = state[WORK + j], state[LOST + j]
            old_power, old_loss = state[POWER + j], state[LOSS + j]
            one_w, one_l, one_e = state[ONE_WHOLE + j], state[ONE_LATE + j], state[ONE_EARLY + j]
            two_w, two_l, two_e = state[TWO_WHOLE + j], state[TWO_LATE + j], state[TWO_EARLY + j]
            window = state[WINDOW + j]
            late, early = fine > 0.0, fine > window - EARLY_TICKS
            length = 1.0 * LATE_TICKS if late else 1.0 * TICKS
            length = 1.0 if early else length
            dt = state[STEP + j] * (length * (1.0 / TICKS))
            tick = old_tick + length
            half = 0.5 * dt
            # Half a kick, then drift.
            vx, vz, vw = ovx + half * oax, ovz + half * oaz, ovw + half * oaw
            turn = dt * vw
            square = turn * turn
            sine = turn * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
            versine = square * (0.5 - square * (1.0 / 24.0))
            nc, ns = c - (c * versine + s * sine), s - (s * versine - c * sine)
            nx, nz, angle = x + dt * vx, z + dt * vz, old_angle + turn
            past = tick - ticks
            past = past if past > 0.0 else 0.0
            ground = (state[BASE + j] + state[SLOPE + j] * tick) + state[BEND + j] * past
            up = (state[UP_BASE + j] + state[UP_SLOPE + j] * tick) + state[UP_BEND + j] * past
            weight = gravity + up
            # Corners from the centre, their penetrations and tangential springs.
            rxl, rzl = -(b * nc) - h * ns, b * ns - h * nc
            rxr, rzr = b * nc - h * ns, -(b * ns) - h * nc
            xl, ul, xr, ur = nx + rxl, -(nz + rzl), nx + rxr, -(nz + rzr)
            in_l, in_r = ul > 0.0, ur > 0.0
            was_l, was_r = oul > 0.0, our > 0.0
            changed = (in_l != was_l) | (in_r != was_r)
            again = changed & (not early)
            tl, tr = gl + (xl - oxl), gr + (xr - oxr)
            tl, tr = (tl if was_l else 0.0), (tr if was_r else 0.0)
            # Which corners press and which stick, from velocities extrapolated with the last acceleration.
            px, pz, pw = vx + half * oax, vz + half * oaz, vw + half * oaw
            kl, kr = k * ul, k * ur
            nl, nr = kl - dash * (pz - rxl * pw), kr - dash * (pz - rxr * pw)
            on_l, on_r = in_l & (nl > 0.0), in_r & (nr > 0.0)
            hl, hr = -(ks * tl), -(ks * tr)
            fl, fr = hl - dash * (px + rzl * pw), hr - dash * (px + rzr * pw)
            stick_l, stick_r = abs(fl) <= mu * nl, abs(fr) <= mu * nr
            # Solve for the velocities with the dashpots of those corners at the new instant; a slipping corner
            # carries its direction times μ times its normal force.
            beta = half * dash
            against = -mu
            sl, sr = (mu if fl > 0.0 else against), (mu if fr > 0.0 else against)
            bl, br = (beta if on_l else 0.0), (beta if on_r else 0.0)
            tbl, tbr = (bl if stick_l else 0.0), (br if stick_r else 0.0)
            ql, qr = sl * bl, sr * br
            ql, qr = (0.0 if stick_l else ql), (0.0 if stick_r else qr)
            kl, kr = (kl if on_l else 0.0), (kr if on_r else 0.0)
            ml, mr = sl * kl, sr * kr
            hl, hr = (hl if stick_l else ml), (hr if stick_r else mr)
            hl, hr = (hl if on_l else 0.0), (hr if on_r else 0.0)
            one, two = (one_l if late else one_w), (two_l if late else two_w)
            one, two = (one_e if early else one), (two_e if early else two)
            iz = one if on_l | on_r else 1.0
            iz = two if on_l & on_r else iz
            rough_l, rough_r = on_l & stick_l, on_r & stick_r
            ix = one if rough_l | rough_r else 1.0
            ix = two if rough_l & rough_r else ix
            hx = vx + half * ((hl + hr) - ground)
            hz = vz + half * ((kl + kr) - weight)
            hw = vw + half * (inertia * ((rzl * hl - rxl * kl) + (rzr * hr - rxr * kr)))
            a12 = ql + qr
            lever = tbl * rzl + tbr * rzr
            a13 = lever - (ql * rxl + qr * rxr)
            a23 = -(bl * rxl + br * rxr)
            a32 = inertia * (a23 + (ql * rzl + qr * rzr))
            left = (tbl * rzl) * rzl + (bl * rxl - ql * rzl) * rxl
            right = (tbr * rzr) * rzr + (br * rxr - qr * rzr) * rxr
            a33 = 1.0 + inertia * (left + right)
            p = (inertia * lever) * ix
            q = (a32 - p * a12) * iz
            # One division for this and for the share of the step that a new contact lasted.
            new_l, new_r = in_l & (not was_l), in_r & (not was_r)
            gone_l, gone_r = ul - oul, ur - our
            gone_l, gone_r = (gone_l if new_l else 1.0), (gone_r if new_r else 1.0)
            pair = gone_l * gone_r
            determinant = (a33 - p * a13) - q * a23
            inverse = 1.0 / (determinant * pair)
            pw = ((hw - p * hx) - q * hz) * (inverse * pair)
            inverse = inverse * determinant
            share_l, share_r = (ul * (inverse * gone_r) - 0.5) * dt, (ur * (inverse * gone_l) - 0.5) * dt
            share_l, share_r = (share_l if new_l else 0.0), (share_r if new_r else 0.0)
            pz = (hz - a23 * pw) * iz
            px = ((hx - a12 * pz) - a13 * pw) * ix
            # The forces at those velocities, within their limits.
            uxl, uzl = px + rzl * pw, pz - rxl * pw
            uxr, uzr = px + rzr * pw, pz - rxr * pw
            nl, nr = k * ul - dash * uzl, k * ur - dash * uzr
            nl = nl if in_l & (nl > 0.0) else 0.0
            nr = nr if in_r & (nr > 0.0) else 0.0
            ml, mr = mu * nl, mu * nr
            fl, fr = -(ks * tl) - dash * uxl, -(ks * tr) - dash * uxr
            fl, fr = (ml if fl > ml else fl), (mr if fr > mr else fr)
            ml, mr = -ml, -mr
            fl, fr = (ml if fl < ml else fl), (mr if fr < mr else fr)
            dl, dr = ml * compliance, mr * compliance
            el, er = -dl, -dr
            sl, sr = (el if tl > el else tl), (er if tr > er else tr)
            sl, sr = (dl if sl < dl else sl), (dr if sr < dr else sr)
            ax = (fl + fr) - ground
            az = (nl + nr) - weight
            spin_l, spin_r = inertia * (rzl * fl - rxl * nl), inertia * (rzr * fr - rxr * nr)
            aw = spin_l + spin_r
            vx = (vx + half * ax) + (share_l * fl + share_r * fr)
            vz = (vz + half * az) + (share_l * nl + share_r * nr)
            vw = (vw + half * aw) + (share_l * spin_l + share_r * spin_r)
            # Books: work of the shaking, loss in dashpots and sliders, springs let go.
            pl, pr = (ul if in_l else 0.0), (ur if in_r else 0.0)
            power = -(ground * vx + up * vz)
            loss_l = (k * pl - nl) * uzl - (fl + ks * sl) * uxl
            loss_r = (k * pr - nr) * uzr - (fr + ks * sr) * uxr
            loss = loss_l + loss_r
            kept_l, kept_r = (el if gl > el else gl), (er if gr > er else gr)
            kept_l, kept_r = (dl if kept_l < dl else kept_l), (dr if kept_r < dr else kept_r)
            slid_l, slid_r = (kept_l - sl) + (tl - gl), (kept_r - sr) + (tr - gr)
            slid_l, slid_r = slid_l * (0.5 * (kept_l + sl)), slid_r * (0.5 * (kept_r + sr))
            slid_l, slid_r = (slid_l if tl != sl else 0.0), (slid_r if tr != sr else 0.0)
            ol, or_ = (oul if was_l else 0.0), (our if was_r else 0.0)
            ol, or_ = (0.0 if in_l else ol), (0.0 if in_r else or_)
            let_go = k * (ol * ol + or_ * or_) + ks * ((gl * gl - kept_l * kept_l) + (gr * gr - kept_r * kept_r))
            let_go = 0.5 * let_go + ks * (slid_l + slid_r)
            work = old_work + half * (old_power + power)
            lost = old_lost + (half * (old_loss + loss) + ((share_l * loss_l + share_r * loss_r) + let_go))
            # A whole step in which a contact changes is not taken; fine ones follow.
            fine = fine - length
            fine = window if changed else fine
            state[FINE + j] = fine
            if not again:
                size = abs(angle)
                slip = abs(nx - h * ns)
                depth = ul if ul > ur else ur
                state[PEAK_ANGLE + j] = size if size > peak else peak
                state[PEAK_SLIP + j] = slip if slip > peak_slip else peak_slip
                state[PEAK_DEPTH + j] = depth if depth > peak_depth else peak_depth
                state[LAST_UPRIGHT + j] = tick if size < alpha else last
                state[TICK + j] = tick
                state[X + j], state[Z + j], state[ANGLE + j] = nx, nz, angle
                state[COS + j], state[SIN + j] = nc, ns
                state[VX + j], state[VZ + j], state[VW + j] = vx, vz, vw
                state[AX + j], state[AZ + j], state[AW + j] = ax, az, aw
                state[SPRING_L + j], state[SPRING_R + j] = sl, sr
                state[OLD_XL + j], state[OLD_UL + j] = xl, ul
                state[OLD_XR + j], state[OLD_UR + j] = xr, ur
                state[WORK + j], state[LOST + j] = work, lost
                state[POWER + j], state[LOSS + j] = power, loss


@njit(**_options)
def start(state: Any, j: int, case: Any, interval: float, steps: int, gravity: float) -> None:
    """Put a case into column j: at static equilibrium on both corners, or tilted on one."""
    for row in range(ROWS):
        state[row * COLUMNS + j] = 0.0
    b, h = 0.5 * case[P_WIDTH], 0.5 * case[P_HEIGHT]
    k, ks = case[P_STIFFNESS], case[P_TANGENTIAL]
    c, s = case[P_TILT_COS], case[P_TILT_SIN]
    state[HALF_WIDTH + j], state[HALF_HEIGHT + j] = b, h
    state[INERTIA + j] = 3.0 / (b * b + h * h)
    state[STIFFNESS + j], state[TANGENTIAL + j] = k, ks
    state[COMPLIANCE + j] = 1.0 / ks if ks > 0.0 else 0.0
    state[DASHPOT + j], state[FRICTION + j] = case[P_DASHPOT], case[P_FRICTION]
    state[ALPHA + j], state[STEP + j] = case[P_ALPHA], interval / steps
    beta = 0.5 * case[P_DASHPOT] * (interval / steps)
    state[ONE_WHOLE + j], state[TWO_WHOLE + j] = 1.0 / (1.0 + beta), 1.0 / (1.0 + 2.0 * beta)
    late, early = beta * LATE_TICKS / TICKS, beta / TICKS
    state[ONE_LATE + j], state[TWO_LATE + j] = 1.0 / (1.0 + late), 1.0 / (1.0 + 2.0 * late)
    state[ONE_EARLY + j], state[TWO_EARLY + j] = 1.0 / (1.0 + early), 1.0 / (1.0 + 2.0 * early)
    state[WINDOW + j] = case[P_WINDOW]
    state[FINE + j] = case[P_WINDOW]
    tilted = s != 0.0
    depth = gravity / k if tilted else 0.5 * gravity / k
    state[Z + j] = (b * abs(s) + h * c) - depth
    state[X + j] = b * ((1.0 - c) if s > 0.0 else (c - 1.0)) + h * s if tilted else 0.0
    state[COS + j], state[SIN + j], state[ANGLE + j] = c, s, case[P_TILT]
    x, z = state[X + j], state[Z + j]
    state[OLD_XL + j], state[OLD_UL + j] = x + (-(b * c) - h * s), -(z + (b * s - h * c))
    state[OLD_XR + j], state[OLD_UR + j] = x + (b * c - h * s), -(z + (-(b * s) - h * c))
    ul, ur = max(state[OLD_UL + j], 0.0), max(state[OLD_UR + j], 0.0)
    state[AZ + j] = k * (ul + ur) - gravity
    lever_l, lever_r = b * c + h * s, h * s - b * c
    state[AW + j] = state[INERTIA + j] * k * (lever_l * ul + lever_r * ur)
    state[PEAK_ANGLE + j] = abs(case[P_TILT])
    state[LAST_UPRIGHT + j] = -1.0
    state[AMPLITUDE + j], state[SAMPLE + j] = case[P_AMPLITUDE], case[P_FIRST]
    state[UPRIGHT_UNTIL + j] = case[P_FIRST] * interval
    state[BARRIER + j] = gravity * (np.sqrt(b * b + h * h) - h)
    state[CALM + j], state[AFTER + j] = case[P_CALM], case[P_AFTER]
    state[ENERGY + j] = energy(state, j, 0.0, gravity)


@njit(**_options)
def energy(state: Any, j: int, lag: float, gravity: float) -> float:
    """Kinetic, gravitational and spring energy per mass; `lag` brings half-step velocities to the whole step."""
    step = lag * state[STEP + j]
    vx, vz = state[VX + j] + step * state[AX + j], state[VZ + j] + step * state[AZ + j]
    vw = state[VW + j] + step * state[AW + j]
    motion = (vx * vx + vz * vz) + vw * vw / state[INERTIA + j]
    ul = state[OLD_UL + j] if state[OLD_UL + j] > 0.0 else 0.0
    ur = state[OLD_UR + j] if state[OLD_UR + j] > 0.0 else 0.0
    tl, tr = state[SPRING_L + j], state[SPRING_R + j]
    springs = state[STIFFNESS + j] * (ul * ul + ur * ur) + state[TANGENTIAL + j] * (tl * tl + tr * tr)
    return float(0.5 * (motion + springs) + gravity * (state[Z + j] - state[HALF_HEIGHT + j]))


@njit(**_options)
def next_sample(state: Any, columns: int, row: Any, ground: Any, upward: Any, ticks: float, interval: float) -> None:
    """Bring the turning pair back to length 1 and load the ground motion of the sample that each column is in."""
    scale = 1.0 / ticks
    last = ground.shape[1] - 3
    vertical = upward.shape[0] > 0
    for j in range(columns):
        c, s = state[COS + j], state[SIN + j]
        unit = 1.5 - 0.5 * (c * c + s * s)
        state[COS + j], state[SIN + j] = c * unit, s * unit
        passed = state[LAST_UPRIGHT + j]
        if passed >= 0.0:
            state[UPRIGHT_UNTIL + j] = (state[SAMPLE + j] + passed * scale) * interval
        state[LAST_UPRIGHT + j] = -1.0
        if state[TICK + j] >= ticks:
            state[TICK + j] -= ticks
            state[SAMPLE + j] += 1.0
        i = min(int(state[SAMPLE + j]), last)
        factor = state[AMPLITUDE + j]
        a0, a1, a2 = ground[row[j], i] * factor, ground[row[j], i + 1] * factor, ground[row[j], i + 2] * factor
        state[BASE + j], state[SLOPE + j] = a0, (a1 - a0) * scale
        state[BEND + j] = ((a2 - a1) - (a1 - a0)) * scale
        if vertical:
            a0, a1, a2 = upward[i] * factor, upward[i + 1] * factor, upward[i + 2] * factor
            state[UP_BASE + j], state[UP_SLOPE + j] = a0, (a1 - a0) * scale
            state[UP_BEND + j] = ((a2 - a1) - (a1 - a0)) * scale


@njit(**_options)
def rise(state: Any, j: int, gravity: float) -> float:
    """Energy that takes a block at rest to its largest rotation so far, or over, per mass; by series, without libm."""
    peak = min(state[PEAK_ANGLE + j], state[ALPHA + j])
    square = peak * peak
    sine = peak * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)))
    versine = square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)))
    return float(gravity * (state[HALF_WIDTH + j] * sine - state[HALF_HEIGHT + j] * versine))


@njit(**_options)
def verdict(state: Any, j: int, lag: float, ticks: float, end: float, gravity: float, deepest: float) -> int:
    """Status of a column at the end of a sample: -1 to go on, else a `Status`."""
    c, s, vx = state[COS + j], state[SIN + j], state[VX + j]
    if not np.isfinite(vx + state[VZ + j] + state[VW + j] + state[X + j] + state[Z + j] + c + s):
        return 3
    if state[PEAK_DEPTH + j] > deepest * min(state[HALF_WIDTH + j], state[HALF_HEIGHT + j]):
        return 3
    if c <= 0.0:
        return 0
    sample = state[SAMPLE + j] + state[TICK + j] / ticks
    if sample < end and sample < state[CALM + j]:
        return -1
    now = energy(state, j, lag, gravity)
    on_base = state[OLD_UL + j] > 0.0 and state[OLD_UR + j] > 0.0
    if sample >= state[CALM + j] and on_base:
        # A block that rests on both corners after the last instant at which it could start stays there.
        vz, vw = state[VZ + j], state[VW + j]
        kinetic = 0.5 * (vx * vx + vz * vz + vw * vw / state[INERTIA + j])
        if kinetic < REST_ENERGY * gravity * state[HALF_WIDTH + j]:
            return 0
    if sample >= end:
        if now < state[BARRIER + j] and abs(state[ANGLE + j]) < state[ALPHA + j]:
            # It can no longer fall, but while its energy reaches higher than it has been, its largest rotation is to come.
            # On one corner the weight has pressed the spring in, which lies g²/2k below the rigid block.
            if now + 0.5 * gravity * gravity / state[STIFFNESS + j] > rise(state, j, gravity):
                return 0 if sample >= state[AFTER + j] else -1
            # Let it slide to the end (v²/2μg ahead) unless nothing would stop it.
            slide = vx - state[HALF_HEIGHT + j] * c * state[VW + j]
            if slide * slide < 2e-6 * gravity * state[FRICTION + j] or state[FRICTION + j] == 0.0:
                return 0
            return 0 if sample >= state[AFTER + j] else -1
        return 2 if sample >= state[AFTER + j] else -1
    return -1


@njit(**_options)
def finish(state: Any, j: int, status: int, lag: float, steps: int, gravity: float, out: Any) -> None:
    """Write the results of a column."""
    c, s, angle = state[COS + j], state[SIN + j], state[ANGLE + j]
    fallen = status == 0 and c <= 0.0
    out[R_STATUS] = status
    out[R_SIDE] = (1.0 if angle > 0.0 else -1.0) if fallen else 0.0
    out[R_TIME] = state[UPRIGHT_UNTIL + j] if fallen else np.nan
    out[R_ANGLE] = min(state[PEAK_ANGLE + j], 0.5 * np.pi) / state[ALPHA + j]
    out[R_SLIP] = state[PEAK_SLIP + j]
    out[R_RESIDUAL] = state[X + j] - state[HALF_HEIGHT + j] * s
    out[R_DEPTH] = state[PEAK_DEPTH + j]
    balance = (energy(state, j, lag, gravity) - state[ENERGY + j]) - state[WORK + j] + state[LOST + j]
    out[R_ENERGY] = abs(balance) / max(state[WORK + j], state[BARRIER + j])
    out[R_STEPS] = steps


@njit(**_options)
def note(state: Any, j: int, lag: float, interval: float, ticks: float, path: Any) -> None:
    """Write a column's state into a row of its trajectory."""
    step = lag * state[STEP + j]
    path[T_TIME] = (state[SAMPLE + j] + state[TICK + j] / ticks) * interval
    path[T_X], path[T_Z], path[T_ANGLE] = state[X + j], state[Z + j], state[ANGLE + j]
    path[T_VX], path[T_VZ] = state[VX + j] + step * state[AX + j], state[VZ + j] + step * state[AZ + j]
    path[T_VW] = state[VW + j] + step * state[AW + j]
    path[T_BASE_SLIP] = state[X + j] - state[HALF_HEIGHT + j] * state[SIN + j]
    b, h, c, s = state[HALF_WIDTH + j], state[HALF_HEIGHT + j], state[COS + j], state[SIN + j]
    path[T_DEPTH_L], path[T_DEPTH_R] = (h * c - b * s) - state[Z + j], (h * c + b * s) - state[Z + j]
    path[T_GROUND] = state[BASE + j] + state[SLOPE + j] * state[TICK + j]


@njit(nogil=True, **_options)
def run_queue(
    scheme: int,
    queue: Any,
    cases: Any,
    row_of_case: Any,
    ground: Any,
    upward: Any,
    samples: int,
    interval: float,
    steps: int,
    gravity: float,
    deepest: float,
    budget: int,
    counter: Any,
    path: Any,
    results: Any,
) -> int:
    """Run the cases of a queue, all with the same number of steps per sample; a finished column takes the next one.

    Parameters
    ----------
    scheme : int
        0 for Cundall's, 1 for the centred one.
    queue : ndarray of int64, shape (m,)
        Rows of `cases` to run, in this order.
    cases : ndarray, shape (n, PARAMETERS)
        The case table.
    row_of_case : ndarray of int64, shape (n,)
        Row of `ground` that shakes each case.
    ground : ndarray, shape (azimuths, samples + 3)
        Acceleration of the base towards +s, m/s², padded with zeros.
    upward : ndarray, shape (samples + 3,) or (0,)
        Upward acceleration, m/s², padded with zeros.
    samples, interval : int, float
        Length of the record and time between samples, s.
    steps : int
        Steps per sample.
    gravity : float
        m/s².
    deepest : float
        Penetration, as a fraction of the smaller half side, beyond which a case has failed.
    budget : int
        Largest number of block steps of one case.
    counter : ndarray of int64, shape (1,)
        Grows by the block steps done; for progress.
    path : ndarray, shape (rows, TRAJECTORY)
        Filled with the first column's state at each sample; no rows to leave out.
    results : ndarray, shape (n, RESULTS)
        Filled in the rows of the queue.

    Returns
    -------
    int
        Rows of `path` that were filled.
    """
    state = np.zeros(ROWS * COLUMNS)
    case = np.zeros(COLUMNS, np.int64)
    row = np.zeros(COLUMNS, np.int64)
    done = np.zeros(COLUMNS, np.int64)
    ticks = float(steps * TICKS)
    lag = 0.5 if scheme == 0 else 0.0
    end = float(samples)
    active, head, noted = 0, 0, 0
    for j in range(COLUMNS):
        start(state, j, cases[queue[0]], interval, steps, gravity)
        row[j] = row_of_case[queue[0]]
    while True:
        while active < COLUMNS and head < queue.size:
            case[active] = queue[head]
            row[active] = row_of_case[queue[head]]
            done[active] = 0
            start(state, active, cases[queue[head]], interval, steps, gravity)
            active, head = active + 1, head + 1
        if active == 0:
            return noted
        columns = (active + 7) // 8 * 8
        next_sample(state, columns, row, ground, upward, ticks, interval)
        if noted < path.shape[0]:
            note(state, 0, lag, interval, ticks, path[noted])
            noted += 1
        if scheme == 0:
            advance_cundall(state, columns, steps, gravity)
        else:
            advance_centred(state, columns, steps, gravity)
        counter[0] += active * steps
        j = 0
        while j < active:
            done[j] += steps
            ended = verdict(state, j, lag, ticks, end, gravity, deepest)
            if ended < 0 and done[j] >= budget:
                ended = 5
            if ended < 0:
                j += 1
                continue
            finish(state, j, ended, lag, done[j], gravity, results[case[j]])
            # The last column moves into the free place.
            active -= 1
            case[j], row[j], done[j] = case[active], row[active], done[active]
            for r in range(ROWS):
                state[r * COLUMNS + j] = state[r * COLUMNS + active]


keep_compiled(run_queue)
