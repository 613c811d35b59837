"""The scene axis of the stability map: how each case ends, checked without the general kernel's own rules."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from overturning.dem.numerics import ELEMENT_STEP, Numerics
from overturning.dem.plan import DEEPEST
from overturning.dem.polygon.prepare import Prepared, prepare
from overturning.dem.run import run
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.geometry import Placed, native_size
from overturning.model.results import Results
from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from verification.stability.blocks import GROUPS, Ending, demand_of, numbered, step_ratio, unsound
from verification.stability.blocks import MEANINGS as BLOCK_MEANINGS
from verification.stability.cases import ADVERSARIAL, motion_of_case
from verification.stability.fallen import flags_fit
from verification.stability.scene_cases import (
    TOGETHER,
    SceneSetting,
    scene_of_setting,
)

BUDGET: Final = 300_000
"""Steps of a case of the space-filling part, fewer than a block's: each costs as much as some tens of a block's."""

ADVERSARIAL_BUDGET: Final = 600_000
"""Steps of a case under a adversarial motion."""

Rows = dict[str, NDArray[Any]]


def run_setting(setting: SceneSetting, number: int, root: Path = Path()) -> Rows:
    """Run the cases of a setting and check their answers.

    Parameters
    ----------
    setting : SceneSetting
        Scene, contact, motion, frictions and amplitudes.
    number : int
        Its place on the map; seeds the noise.
    root : Path
        Folder in which config/scenes lies.

    Returns
    -------
    dict of ndarray, shape (TOGETHER,)
        Columns of the map.
    """
    case = setting.common
    scene, motion = scene_of_setting(setting, root), motion_of_case(setting.common, number)
    ratio = native_size(scene)[1] * case.b_over_h
    budget = ADVERSARIAL_BUDGET if case.motion in ADVERSARIAL else BUDGET
    rows: Rows = {
        "scene": np.full(TOGETHER, setting.scene),
        "motion": np.full(TOGETHER, case.motion),
        "scheme": np.full(TOGETHER, case.scheme),
        "height": np.full(TOGETHER, case.height),
        "b_over_h": np.full(TOGETHER, ratio),
        "friction": setting.friction,
        "peak": setting.amplitude * np.abs(motion.north).max(),
        "ending": np.full(TOGETHER, int(Ending.REFUSED), np.int8),
        "reason": np.full(TOGETHER, "", object),
        "fallen": np.full(TOGETHER, -1, np.int8),
        "as_block": np.full(TOGETHER, -1, np.int8),
        "energy_error": np.full(TOGETHER, np.nan),
        "block_steps": np.zeros(TOGETHER, np.int64),
    }
    prepared = None
    try:
        prepared = prepare(scene, case.height, ratio)
        cases = Cases(setting.azimuth_deg, case.height, ratio, setting.friction, setting.amplitude)
        numerics = Numerics(
            scheme=case.scheme, time_step=case.time_step, budget=ELEMENT_STEP * budget * len(scene.free), general=True
        )
        found = run(scene, motion, cases, numerics)
    except ArgumentError as error:
        rows["reason"][:] = str(error).partition(":")[0].partition(" ")[0]
        return rows | _groups(setting, prepared, motion)
    for row in range(TOGETHER):
        reason = contradiction(
            prepared, float(setting.friction[row]), _amplified(motion, float(setting.amplitude[row])), found, row
        )
        rows["ending"][row] = Ending.SILENT if reason else int(found.status[row])
        rows["reason"][row] = reason
        if not reason and found.status[row] in (Status.SIMULATED, Status.AT_REST):
            rows["fallen"][row] = np.count_nonzero(found.overturned[row])
    rows["energy_error"][:], rows["block_steps"][:] = found.energy_error, found.block_steps
    if scene.single_block:
        block = run(scene, motion, cases, replace(numerics, general=False)).element(0)
        # The scene's ground ends somewhere, the block's does not.
        there = found.peak_slip[:, 0] < 0.5 * prepared.placed[0].shape.width
        both = (found.overturned[:, 0] != INT8_MISSING) & (block.overturned != INT8_MISSING) & there
        rows["as_block"][both] = (found.overturned[:, 0] == block.overturned)[both]
    return rows | _groups(setting, prepared, motion)


def contradiction(prepared: Prepared, friction: float, motion: Motion, found: Results, row: int = 0) -> str:
    """The first check that the answer of a case does not hold; empty where all hold.

    The checks are those of the block's map, for each free element; what can move at all is worked out here from the
    shapes.

    Parameters
    ----------
    prepared : Prepared
        The scene at its size.
    friction : float
        μ of all contacts.
    motion : Motion
        The case's, amplitude included.
    found : Results
        Answers.
    row : int
        Which of them.
    """
    status, flags = int(found.status[row]), found.overturned[row]
    free = [item for item in prepared.placed if not item.fixed]
    sunk = deepest_at_rest(prepared)
    reason = unsound(found, row, sunk, DEEPEST * 0.5 * min(item.size for item in free))
    if reason or status not in (Status.SIMULATED, Status.AT_REST):
        return reason
    fallen = flags != 0
    if not flags_fit(prepared, fallen, found.peak_rotation[row] * prepared.unit[prepared.free]):
        return "flag and rotation"
    if (np.isfinite(found.overturning_time[row]) != fallen).any():
        return "flag and time"
    demand, bound = demand_of(motion), min(rocking_bound(prepared.placed), friction)
    if status == Status.AT_REST and demand > bound * (1 + 1e-9):
        return "left out above a threshold"
    if fallen.any() and demand < 0.2 * bound and sunk < 1e-4 * min(item.size for item in free):
        return "fell below the threshold"
    return ""


def _amplified(motion: Motion, factor: float) -> Motion:
    up = None if motion.up is None else factor * motion.up
    return Motion(
        factor * motion.north, factor * motion.east, up, sampling_interval=motion.sampling_interval, trust_data=True
    )


def deepest_at_rest(prepared: Prepared) -> float:
    """Largest static penetration, m: the weight that a pair carries, on both of its ends."""
    return float(np.max(prepared.laws.carried / (2.0 * prepared.laws.normal), initial=0.0))


def rocking_bound(placed: Sequence[Placed]) -> float:
    """Least |a|/(g + a_up) at which the rigid scene can start to rock: arm over height of each with all above it.

    Worked out from the shapes alone, for scenes in which each element stands in the middle of one other.
    """
    free = sorted((item for item in placed if not item.fixed), key=lambda item: item.z)
    least = np.inf
    for k, item in enumerate(free):
        above = free[k:]
        mass = sum(part.mass for part in above)
        x = sum(part.mass * part.x for part in above) / mass
        z = sum(part.mass * part.z for part in above) / mass
        level = item.points[:, 1].min()
        foot = item.points[item.points[:, 1] < level + 1e-9 * item.size][:, 0]
        if k > 0:
            below = free[k - 1].points
            top = below[below[:, 1] > level - 1e-6 * item.size][:, 0]
            foot = np.clip(foot, top.min(), top.max())
        least = min(least, (foot.max() - x) / (z - level), (x - foot.min()) / (z - level))
    return float(max(least, 0.0))


def _groups(setting: SceneSetting, prepared: Prepared | None, motion: Motion) -> Rows:
    if prepared is None:
        return dict.fromkeys(GROUPS, np.full(TOGETHER, np.nan))
    size = min(item.size for item in prepared.placed if not item.fixed)
    bound = max(rocking_bound(prepared.placed), 1e-9)
    square, rate = np.array([prepared.square]), np.array([prepared.rate])
    ratio = step_ratio(setting.common, square, rate, motion.sampling_interval)
    loaded = prepared.laws.carried > 0
    heave = 2.0 * np.sqrt(0.5 * prepared.laws.normal * prepared.laws.carried / STANDARD_GRAVITY)
    damping = prepared.laws.dashpot[loaded] / heave[loaded]
    return {
        "penetration_ratio": np.full(TOGETHER, deepest_at_rest(prepared) / size),
        "damping": np.full(TOGETHER, float(damping.max()) if damping.size else np.nan),
        "step_ratio": np.full(TOGETHER, ratio),
        "acceleration_ratio": setting.amplitude * np.abs(motion.north).max() / (STANDARD_GRAVITY * bound),
        "friction_ratio": setting.friction / bound,
    }


def run_scene_map(
    settings: Sequence[SceneSetting],
    *,
    threads: int = 1,
    progress: Callable[[int, int], None] | None = None,
    root: Path = Path(),
) -> pd.DataFrame:
    """Run all settings; the outcome, a row per case, does not depend on the threads."""
    parts = numbered(lambda number, setting: run_setting(setting, number, root), settings, threads, progress, 50)
    return pd.concat([pd.DataFrame(part) for part in parts], ignore_index=True)


_AS_OF_BLOCKS: Final = ("motion", "scheme", "friction", "peak", "ending", "reason", "energy_error", "step_ratio")

MEANINGS: Final = {name: BLOCK_MEANINGS[name] for name in _AS_OF_BLOCKS} | {
    "scene": ("scene", ""),
    "height": ("height of the reference element", "m"),
    "b_over_h": ("slenderness of the reference element", "1"),
    "fallen": ("elements that fall; -1: no answer", "1"),
    "as_block": ("1 where the block's kernel has the same flag, 0 where another; -1: not both answer", "1"),
    "block_steps": ("steps computed, times free elements", "1"),
    "penetration_ratio": ("largest static penetration over the smallest side of a free element", "1"),
    "damping": ("largest damping ratio of heave of a loaded contact", "1"),
    "acceleration_ratio": ("largest acceleration over g times the least threshold of rocking", "1"),
    "friction_ratio": ("friction coefficient over the least threshold of rocking", "1"),
}
"""Long name and unit of the map's columns."""
