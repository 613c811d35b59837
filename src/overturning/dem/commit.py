"""How a step of the centred scheme ends: forces within their limits, what they do, the books, and whether it is taken.

Signs as in `overturning.dem.centred`.
"""

import math
from typing import Any

from numba import njit

# isort: off
from overturning.dem.columns import (
    ALPHA, ANGLE, ARM_L, ARM_R, AW, AX, AZ, COMPLIANCE, COS, DASHPOT, DROP_L, DROP_R, EARLY_TICKS, END_VW, END_VX,
    END_VZ, END_XL, END_XR, END_ZL, END_ZR, FINE, FRICTION, HALF, HALF_HEIGHT, INERTIA, LAST_UPRIGHT, LATE_STEP,
    LIFT, LOSS, LOST, MID_VW, MID_VX, MID_VZ, MOST_TRIES, NEW_ANGLE, NEW_COS, NEW_SIN, NEW_SL, NEW_SR, NEW_UL,
    NEW_UR, NEW_X, NEW_Z, OLD_UL, OLD_UR, OLD_XL, OLD_XR, OPTIONS, PEAK_ANGLE, PEAK_DEPTH, PEAK_SLIP, POWER,
    PRESSED_L, PRESSED_R, PUSH, SIN, SLID_L, SLID_R, SPRING_L, SPRING_R, STIFFNESS, TAIL_STEP, TAIL_TICKS,
    TANGENTIAL, TICK, TICKS, TRIES, VW, VX, VZ, WINDOW, WORK, X, Z,
)  # fmt: skip
# isort: on


@njit(**OPTIONS)
def commit(state: Any, columns: int, gravity: float, vertical: Any, rough: Any) -> None:
    """Forces at the end of the step, within their limits, what they do, and the books; or the step is done again."""
    for j in range(columns):
        k, ks, mu, dash = state[STIFFNESS + j], state[TANGENTIAL + j], state[FRICTION + j], state[DASHPOT + j]
        inertia, half, fine, window = state[INERTIA + j], state[HALF + j], state[FINE + j], state[WINDOW + j]
        al, ar, dl, dr = state[ARM_L + j], state[ARM_R + j], state[DROP_L + j], state[DROP_R + j]
        ul, ur, tl, tr = state[NEW_UL + j], state[NEW_UR + j], state[NEW_SL + j], state[NEW_SR + j]
        oul, our, gl, gr = state[OLD_UL + j], state[OLD_UR + j], state[SPRING_L + j], state[SPRING_R + j]
        xl, xr, zl, zr = state[END_XL + j], state[END_XR + j], state[END_ZL + j], state[END_ZR + j]
        vx, vz, vw, push = state[MID_VX + j], state[MID_VZ + j], state[MID_VW + j], state[PUSH + j]
        cx, cz, cw = state[END_VX + j], state[END_VZ + j], state[END_VW + j]
        nx, nz, angle = state[NEW_X + j], state[NEW_Z + j], state[NEW_ANGLE + j]
        c, s, h, compliance = state[NEW_COS + j], state[NEW_SIN + j], state[HALF_HEIGHT + j], state[COMPLIANCE + j]
        peak, peak_slip, peak_depth = state[PEAK_ANGLE + j], state[PEAK_SLIP + j], state[PEAK_DEPTH + j]
        alpha, last, old_tick = state[ALPHA + j], state[LAST_UPRIGHT + j], state[TICK + j]
        tries, tail_ticks = state[TRIES + j], state[TAIL_TICKS + j]
        old_work, old_lost, old_power, old_loss = state[WORK + j], state[LOST + j], state[POWER + j], state[LOSS + j]
        tail, late, early = fine > 0.0, fine > tail_ticks, fine > window - EARLY_TICKS
        length = 1.0 * TAIL_STEP if tail else 1.0 * TICKS
        length = 1.0 * LATE_STEP if late else length
        length = 1.0 if early else length
        # What the solution adds to the foreseen velocities moves the block by half a step of it.
        slid_l, slid_r = state[SLID_L + j], state[SLID_R + j]
        czl, czr, met_l, met_r = cz + al * cw, cz - ar * cw, ul, ur
        zl, zr = zl + czl, zr + czr
        ul, ur = ul - half * czl, ur - half * czr
        if rough is not None:
            cxl, cxr = cx - dl * cw, cx - dr * cw
            xl, xr, tl, tr = xl + cxl, xr + cxr, tl + half * cxl, tr + half * cxr
            pxl, pxr = (nx - al) + half * cxl, (nx + ar) + half * cxr
        turn = half * cw
        nx, nz, angle = nx + half * cx, nz + half * cz, angle + turn
        c, s = c - s * turn, s + c * turn
        in_l, in_r, was_l, was_r = ul > 0.0, ur > 0.0, oul > 0.0, our > 0.0
        # A corner that the solution has just pushed out again has met the base all the same.
        met_l, met_r = (met_l if met_l > ul else ul), (met_r if met_r > ur else ur)
        met_l, met_r = (-ul if was_l else met_l), (-ur if was_r else met_r)
        changed = (met_l if met_l > met_r else met_r) > 0.0
        again = changed & (not early)
        # Normal force: never tension. Tangential force and spring within friction.
        kl, kr = (k * ul if in_l else 0.0), (k * ur if in_r else 0.0)
        nl, nr = kl - dash * zl, kr - dash * zr
        nl, nr = (nl if nl > 0.0 else 0.0), (nr if nr > 0.0 else 0.0)
        nl, nr = (nl if in_l else 0.0), (nr if in_r else 0.0)
        loss_l, loss_r = (kl - nl) * zl, (kr - nr) * zr
        spin_l, spin_r, ax, let_go = al * nl, ar * nr, push, 0.0
        if rough is not None:
            ml, mr = mu * nl, mu * nr
            fl, fr = ks * tl + dash * xl, ks * tr + dash * xr
            sign_l, sign_r, size_l, size_r = math.copysign(mu, fl), math.copysign(mu, fr), abs(fl), abs(fr)
            slips_l, slips_r = size_l > ml, size_r > mr
            # A long step took each corner to slide or to stick. Where that proves wrong it is done again as was found, at
            # most `MOST_TRIES` times, then in shorter steps; so is one in which a sliding corner has turned round, since
            # friction changes its sign on the way. (A corner in the air "slips"; nothing asks which way.)
            slid_l, slid_r = (0.0 if late else slid_l), (0.0 if late else slid_r)
            found_l, found_r = (sign_l if slips_l else 0.0), (sign_r if slips_r else 0.0)
            wrong_l, wrong_r = (found_l != slid_l) & (ml > 0.0), (found_r != slid_r) & (mr > 0.0)
            turned = (slid_l * xl < 0.0) & (ml > 0.0) | (slid_r * xr < 0.0) & (mr > 0.0)
            wrong = (wrong_l | wrong_r) & (not (late | again))
            shorter = (turned & (not again)) | (wrong & (tries >= MOST_TRIES))
            retry = wrong & (not shorter)
            fl, fr = (sign_l * nl if slips_l else fl), (sign_r * nr if slips_r else fr)
            slid_l = slid_l if retry & (not wrong_l) else found_l
            slid_r = slid_r if retry & (not wrong_r) else found_r
            state[SLID_L + j], state[SLID_R + j] = slid_l, slid_r
            state[TRIES + j] = tries + 1.0 if retry else 0.0
            # A corner that slips has its spring shortened to what friction holds.
            el, er = ml * compliance, mr * compliance
            sl, sr = math.copysign(el, tl), math.copysign(er, tr)
            sl, sr = (sl if slips_l & (abs(tl) > el) else tl), (sr if slips_r & (abs(tr) > er) else tr)
            spin_l, spin_r, ax = spin_l + dl * fl, spin_r - dr * fr, push - (fl + fr)
            loss_l, loss_r = loss_l + (fl - ks * sl) * xl, loss_r + (fr - ks * sr) * xr
            let_go = (gl + sl) * (tl - sl) + (gr + sr) * (tr - sr)
        az = (nl + nr) - gravity
        if vertical is not None:
            lift = state[LIFT + j]
            az = (nl + nr) - (gravity + lift)
        aw = inertia * (spin_l - spin_r)
        vx, vz, vw = vx + half * ax, vz + half * az, vw + half * aw
        # A contact that closed within the step acts from the touch on, not for half the step.
        new_l, new_r = in_l & (not was_l), in_r & (not was_r)
        gone_l, gone_r = ul - oul, ur - our
        gone_l, gone_r = (gone_l if new_l else 1.0), (gone_r if new_r else 1.0)
        inverse = 2.0 * half / (gone_l * gone_r)
        share_l, share_r = ul * (inverse * gone_r) - half, ur * (inverse * gone_l) - half
        share_l, share_r = (share_l if new_l else 0.0), (share_r if new_r else 0.0)
        if rough is not None:
            vx = vx - (share_l * fl + share_r * fr)
        vz = vz + (share_l * nl + share_r * nr)
        vw = vw + inertia * (share_l * spin_l - share_r * spin_r)
        # Books: work of the shaking, loss in dashpots, sliders and contacts that open or close within the step.
        power = push * vx
        if vertical is not None:
            power = push * vx - lift * vz
        loss = loss_l + loss_r
        cut_l, cut_r = ul * oul, ur * our
        cut_l, cut_r = (cut_l if cut_l < 0.0 else 0.0), (cut_r if cut_r < 0.0 else 0.0)
        cut_l, cut_r = math.copysign(cut_l, ul - oul), math.copysign(cut_r, ur - our)
        work = old_work + half * (old_power + power)
        lost = old_lost + (
            (half * (old_loss + loss) + (share_l * loss_l + share_r * loss_r))
            + 0.5 * (ks * let_go + k * (cut_l + cut_r))
        )
        # Unless it is a single tick, a step in which a contact changes is not taken; a shorter one follows.
        tick = old_tick + length
        begin = window - EARLY_TICKS if tail else tail_ticks
        begin = window if late else begin
        later = fine - length
        if rough is not None:
            later = fine if retry else later
            sooner = tail_ticks + 1.0 * TAIL_STEP if tail else 1.0 * TICKS
            later = sooner if shorter else later
            again = again | retry | shorter
        fine = begin if changed else later
        size, slip = abs(angle), abs(nx - h * s)
        depth = ul if ul > ur else ur
        last = tick if size < alpha else last
        state[FINE + j] = fine
        # Selected, not skipped: a masked store is slow.
        state[PEAK_ANGLE + j] = state[PEAK_ANGLE + j] if again else (size if size > peak else peak)
        state[PEAK_SLIP + j] = state[PEAK_SLIP + j] if again else (slip if slip > peak_slip else peak_slip)
        state[PEAK_DEPTH + j] = state[PEAK_DEPTH + j] if again else (depth if depth > peak_depth else peak_depth)
        state[LAST_UPRIGHT + j] = state[LAST_UPRIGHT + j] if again else last
        state[TICK + j] = state[TICK + j] if again else tick
        state[X + j] = state[X + j] if again else nx
        state[Z + j] = state[Z + j] if again else nz
        state[ANGLE + j] = state[ANGLE + j] if again else angle
        state[COS + j] = state[COS + j] if again else c
        state[SIN + j] = state[SIN + j] if again else s
        state[VX + j] = state[VX + j] if again else vx
        state[VZ + j] = state[VZ + j] if again else vz
        state[VW + j] = state[VW + j] if again else vw
        state[AX + j] = state[AX + j] if again else ax
        state[AZ + j] = state[AZ + j] if again else az
        state[AW + j] = state[AW + j] if again else aw
        if rough is not None:
            state[SPRING_L + j] = state[SPRING_L + j] if again else sl
            state[SPRING_R + j] = state[SPRING_R + j] if again else sr
            state[OLD_XL + j] = state[OLD_XL + j] if again else pxl
            state[OLD_XR + j] = state[OLD_XR + j] if again else pxr
        state[PRESSED_L + j] = state[PRESSED_L + j] if again else nl
        state[PRESSED_R + j] = state[PRESSED_R + j] if again else nr
        state[OLD_UL + j] = state[OLD_UL + j] if again else ul
        state[OLD_UR + j] = state[OLD_UR + j] if again else ur
        state[WORK + j] = state[WORK + j] if again else work
        state[LOST + j] = state[LOST + j] if again else lost
        state[POWER + j] = state[POWER + j] if again else power
        state[LOSS + j] = state[LOSS + j] if again else loss
