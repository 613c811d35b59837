"""Rigid-body engines on cases of the verification that cannot slide: error against run time, into a table like the kernel's.

An engine that is not installed (dependency group `peers`) is left out.
"""

import argparse
import math
from pathlib import Path

import numpy as np

from benchmarks import peers
from overturning.verification.rigid_solutions import peer_rows
from overturning.verification.table import write_table
from overturning.verification.work_precision import MEANINGS, columns_of, row

STEPS = (1 / 120, 1 / 240, 1 / 480, 1 / 960)


def mujoco(acceleration: np.ndarray, interval: float, height: float, b_over_h: float, friction: float) -> int:
    """Side to which the block falls in MuJoCo: a box in a plane, a metre deep; the shaking as a turning gravity."""
    import mujoco as engine

    half = (0.5 * height * b_over_h, 0.5, 0.5 * height)
    model = engine.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{peers.STEP}" integrator="implicitfast" cone="elliptic"/>
        <default><geom friction="{friction} 0 0" condim="3" solref="{2.0 * peers.STEP} 1"/></default>
        <worldbody><geom type="plane" size="100 100 1"/><body pos="0 0 {half[2]}">
        <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>
        <geom type="box" size="{half[0]} {half[1]} {half[2]}" mass="1"/></body></worldbody></mujoco>"""
    )
    data = engine.MjData(model)
    model.opt.gravity[2] = -peers.GRAVITY
    for ground in peers.resample(acceleration, interval):
        model.opt.gravity[0] = -ground
        engine.mj_step(model, data)
        if abs(data.qpos[2]) > 0.5 * math.pi * 0.98:
            return 1 if data.qpos[2] > 0 else -1
    return 0


def set_step(step: float) -> None:
    """Make the engines use a time step, s."""
    peers.STEP = step


def main() -> None:
    """Run the engines that are installed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, required=True)
    engines = peers.available()
    try:
        import mujoco as _  # noqa: F401

        engines["MuJoCo"] = mujoco
    except ImportError:
        pass
    rows = peer_rows(engines, STEPS, set_step, print)
    # A table without engines has one row that says so.
    rows = rows or [row("sine pulses", "no engine installed", "rigid rocking", default=0)]
    write_table(columns_of(rows), parser.parse_args().output, meanings=MEANINGS)


if __name__ == "__main__":
    main()
