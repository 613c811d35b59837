"""The stability maps: every case ends with a checked answer, a mark or a refusal; none may be silently wrong."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.numerics import ELEMENT_STEP_COST_IN_BLOCK_STEPS, NumericalOptions
from overturning.dem.polygon.prepare import SceneEquilibriumStiffnessAndRockingLimits, prepare_scene
from overturning.dem.run import run_cases, simulate_cases
from overturning.dem.time_step import (
    block_highest_eigenvalue_bound,
    longest_stable_or_accurate_step,
    parse_scheme,
    rocking_time_constant,
    steps_per_sample,
)
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.contact import Contact
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.scene import gravestone
from overturning.model.status import CaseStatus
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from verification.stability.cases import (
    ADVERSARIAL_MOTION_KINDS,
    ORIGINAL_PAPER_DASHPOT_N_S_PER_M,
    PARALLEL_CASE_COUNT_PER_SCENE,
    BlockCaseOfNumericalStabilityMap,
    ParametersOfSceneCases,
    load_scene_with_case_density_and_contact_law,
    motion_of_case,
)
from verification.stability.checks import (
    StabilityCheckVerdict,
    largest_penetration_under_own_weight,
    min_acceleration_ratio_to_start_rocking,
    name_of_first_failed_block_check,
    name_of_first_failed_scene_check,
    static_penetration,
)

MAX_BLOCK_STEPS_PER_MAP_CASE: Final = 1_000_000
"""Budget of block steps of a case of the map; below that of a study, to limit the run time to minutes."""
MAX_STEPS_OF_SCENE_CASE: Final = 300_000
"""Budget of steps of a case of a scene; one step costs as much as some tens of block steps."""
MAX_STEPS_OF_ADVERSARIAL_SCENE_CASE: Final = 600_000
"""Budget of steps of a case of a scene under an adversarial motion."""

DIMENSIONLESS_GROUP_NAMES: Final = (
    "penetration_ratio",
    "damping",
    "step_ratio",
    "acceleration_ratio",
    "friction_ratio",
)

_COMMON_COLUMN_LONG_NAMES_AND_UNITS: Final = {
    "friction": ("friction coefficient", "1"),
    "peak": ("largest horizontal acceleration", "m s-2"),
    "scheme": ("integration scheme", ""),
    "motion": ("kind of motion", ""),
    "ending": ("how the case ended: " + ", ".join(f"{e.value} {e.label}" for e in StabilityCheckVerdict), "1"),
    "reason": ("argument that a refusal names, or check that does not hold", ""),
    "energy_error": ("residual of work and energy", "1"),
    "step_ratio": ("time step over the stable one", "1"),
}
BLOCK_COLUMN_LONG_NAMES_AND_UNITS: Final = _COMMON_COLUMN_LONG_NAMES_AND_UNITS | {
    "stiffness": ("normal stiffness of a corner, per metre of depth", "N m-1"),
    "damping_ratio": ("damping ratio of heave asked for; NaN: the paper's dashpot", "1"),
    "b_over_h": ("slenderness", "1"),
    "height": ("height of the block", "m"),
    "density": ("density", "kg m-3"),
    "sampling_interval": ("sampling interval of the motion", "s"),
    "step_fraction": ("time step over the stable one, asked for; NaN: automatic", "1"),
    "period": ("period of pulse and square wave, in samples", "1"),
    "vertical": ("largest upward over largest horizontal acceleration", "1"),
    "overturned": ("side to which the block falls; -128: no answer", "1"),
    "penetration": ("largest penetration over the width", "1"),
    "rotation": ("largest rotation over the critical angle", "1"),
    "slip": ("largest slip of the base's midpoint", "m"),
    "block_steps": ("block steps computed", "1"),
    "penetration_ratio": ("static penetration over width", "1"),
    "damping": ("damping ratio of heave", "1"),
    "acceleration_ratio": ("largest acceleration over g B/H", "1"),
    "friction_ratio": ("friction coefficient over B/H", "1"),
}
"""Long name and unit of the columns of the map of blocks."""
SCENE_COLUMN_LONG_NAMES_AND_UNITS: Final = _COMMON_COLUMN_LONG_NAMES_AND_UNITS | {
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
"""Long name and unit of the columns of the map of scenes."""


def contact_law_of_block_case(case: BlockCaseOfNumericalStabilityMap) -> Contact:
    """Return the contact of a single-block case: its stiffness, and its damping ratio or dashpot."""
    if np.isnan(case.heave_damping_ratio):
        return Contact(stiffness=case.normal_stiffness_per_corner, damping=ORIGINAL_PAPER_DASHPOT_N_S_PER_M)
    return Contact(stiffness=case.normal_stiffness_per_corner, damping_ratio=case.heave_damping_ratio)


def simulate_block_case_and_check_outcome(
    case: BlockCaseOfNumericalStabilityMap,
    case_index_and_noise_seed: int,
    max_block_steps: int = MAX_BLOCK_STEPS_PER_MAP_CASE,
) -> dict[str, Any]:
    """Run one case within a budget of block steps and check its answer; return a row of the map.

    `case_index_and_noise_seed` is the index of the case on the map; it is the seed of the noise.
    """
    motion, contact = motion_of_case(case, case_index_and_noise_seed), contact_law_of_block_case(case)
    row: dict[str, Any] = case.parameters_as_map_columns() | {
        "ending": StabilityCheckVerdict.ARGUMENT_REFUSED,
        "reason": "",
        "overturned": INT8_MISSING,
        "block_steps": 0,
    }
    row |= dict.fromkeys(("energy_error", "penetration", "rotation", "slip"), float("nan"))
    row |= _dimensionless_groups_of_block(case, contact, motion)
    cases = Cases(0.0, case.height, case.b_over_h, case.friction)
    given: dict[str, Any] = {
        "scheme": case.scheme,
        "time_step": case.time_step_argument_of_run_cases,
        "budget": max_block_steps,
    }
    try:
        found = run_cases(motion, cases, gravestone(contact, case.density), **given)
    except ArgumentError as error:
        return row | {"reason": str(error).partition(":")[0]}
    reason = name_of_first_failed_block_check(case, motion, found)
    return row | {
        "ending": StabilityCheckVerdict.WRONG_WITHOUT_WARNING
        if reason
        else StabilityCheckVerdict(int(found.status[0])),
        "reason": reason,
        "overturned": int(found.overturned[0]),
        "energy_error": float(found.energy_error[0]),
        "penetration": float(found.peak_penetration[0]) / (case.b_over_h * case.height),
        "rotation": float(found.peak_rotation[0]),
        "slip": float(found.peak_slip[0]),
        "block_steps": int(found.block_steps[0]),
    }


def _dimensionless_groups_of_block(
    case: BlockCaseOfNumericalStabilityMap, contact: Contact, motion: Motion
) -> dict[str, float]:
    """Return the dimensionless groups of a case of a block by name, such as damping ratio and Δt/Δt_stable."""
    width, height = np.array([case.b_over_h * case.height]), np.array([case.height])
    normal, tangential, dashpot = contact.corner_stiffness_and_damping_per_mass(width, height, case.density)
    square = block_highest_eigenvalue_bound(normal, tangential, 0.5 * width, 0.5 * height)
    rate = block_highest_eigenvalue_bound(dashpot, dashpot, 0.5 * width, 0.5 * height)
    groups = (
        static_penetration(case) / float(width[0]),
        float(dashpot[0]) / (2.0 * np.sqrt(0.5 * float(normal[0]))),
        _ratio_of_time_step_to_stable_step(
            case, square, rate, motion.sampling_interval, rocking_time_constant(width, height)
        ),
        case.peak_horizontal_acceleration / (STANDARD_GRAVITY * case.b_over_h),
        case.friction / case.b_over_h,
    )
    return dict(zip(DIMENSIONLESS_GROUP_NAMES, groups, strict=True))


def _ratio_of_time_step_to_stable_step(
    case: BlockCaseOfNumericalStabilityMap,
    largest_spring_eigenvalue_of_case: FloatArray,
    largest_dashpot_eigenvalue: FloatArray,
    sampling_interval: float,
    rocking_time_constant: FloatArray | None = None,
) -> float:
    """Return time step over longest stable step, from the largest eigenvalues of springs and of dashpots.

    It is the requested ratio if the program refuses the time step.
    """
    scheme = parse_scheme(case.scheme)
    try:
        per_sample = float(
            steps_per_sample(
                scheme,
                case.time_step_argument_of_run_cases,
                largest_spring_eigenvalue_of_case,
                largest_dashpot_eigenvalue,
                sampling_interval,
                rocking_time_constant,
            )[0]
        )
    except ArgumentError:
        return case.requested_step_to_stable_step_ratio
    return (
        sampling_interval
        / per_sample
        / float(
            longest_stable_or_accurate_step(
                scheme, largest_spring_eigenvalue_of_case, largest_dashpot_eigenvalue, rocking_time_constant
            )[0]
        )
    )


def simulate_scene_cases_and_check_outcomes(
    setting: ParametersOfSceneCases, setting_index_as_noise_seed: int, project_folder: Path = Path()
) -> dict[str, NDArray[Any]]:
    """Run the cases of a scene setting and check their outcomes.

    Return the columns of the map of scenes, with a value for each case.

    `setting_index_as_noise_seed` is the index of the setting on the map; it is the seed of the noise.
    `project_folder` contains config/scenes.
    """
    case = setting.common_parameters
    scene, motion = (
        load_scene_with_case_density_and_contact_law(setting, project_folder),
        motion_of_case(setting.common_parameters, setting_index_as_noise_seed),
    )
    ratio = reference_element_height_and_b_over_h(scene)[1] * case.b_over_h
    alike = {
        "scene": setting.scene_name, "motion": case.motion_kind, "scheme": case.scheme, "height": case.height,
        "b_over_h": ratio,
        "ending": np.int8(StabilityCheckVerdict.ARGUMENT_REFUSED), "fallen": np.int8(-1), "as_block": np.int8(-1),
        "energy_error": np.nan, "block_steps": np.int64(0),
    }  # fmt: skip
    rows: dict[str, NDArray[Any]] = {
        name: np.full(PARALLEL_CASE_COUNT_PER_SCENE, value) for name, value in alike.items()
    }
    rows["friction"], rows["reason"] = setting.friction_by_case, np.full(PARALLEL_CASE_COUNT_PER_SCENE, "", object)
    rows["peak"] = setting.amplitude_factor_by_case * np.abs(motion.north).max()
    budget = (
        MAX_STEPS_OF_ADVERSARIAL_SCENE_CASE if case.motion_kind in ADVERSARIAL_MOTION_KINDS else MAX_STEPS_OF_SCENE_CASE
    )
    prepared = None
    try:
        prepared = prepare_scene(scene, case.height, ratio)
        cases = Cases(
            setting.azimuth_deg_by_case, case.height, ratio, setting.friction_by_case, setting.amplitude_factor_by_case
        )
        numerics = NumericalOptions(
            scheme=case.scheme,
            time_step=case.time_step_argument_of_run_cases,
            budget=ELEMENT_STEP_COST_IN_BLOCK_STEPS * budget * len(scene.free_element_names),
            general=True,
        )
        found = simulate_cases(scene, motion, cases, numerics)
    except ArgumentError as error:
        rows["reason"][:] = str(error).partition(":")[0].partition(" ")[0]
        return rows | _dimensionless_groups_of_scene(setting, prepared, motion)
    for row, (friction, factor) in enumerate(
        zip(setting.friction_by_case, setting.amplitude_factor_by_case, strict=True)
    ):
        reason = name_of_first_failed_scene_check(
            prepared, float(friction), motion.scaled_by(float(factor)), found, row
        )
        rows["ending"][row] = StabilityCheckVerdict.WRONG_WITHOUT_WARNING if reason else int(found.status[row])
        rows["reason"][row] = reason
        if not reason and CaseStatus(found.status[row]).trajectory_has_known_outcome:
            rows["fallen"][row] = np.count_nonzero(found.overturned[row])
    rows["energy_error"][:], rows["block_steps"][:] = found.energy_error, found.block_steps
    if scene.can_use_single_block_kernel:
        block = simulate_cases(scene, motion, cases, replace(numerics, general=False))
        # The ground of the scene is finite, that of the single block is not.
        there = found.peak_slip < 0.5 * prepared.elements[0].shape.width
        both = (found.overturned != INT8_MISSING) & (block.overturned != INT8_MISSING) & there
        rows["as_block"][both] = (found.overturned == block.overturned)[both]
    return rows | _dimensionless_groups_of_scene(setting, prepared, motion)


def _dimensionless_groups_of_scene(
    setting: ParametersOfSceneCases, prepared_scene: SceneEquilibriumStiffnessAndRockingLimits | None, motion: Motion
) -> dict[str, NDArray[Any]]:
    """Return the dimensionless groups of the cases of a scene by name; NaN if the scene was refused."""
    if prepared_scene is None:
        return dict.fromkeys(DIMENSIONLESS_GROUP_NAMES, np.full(PARALLEL_CASE_COUNT_PER_SCENE, np.nan))
    laws, bound = (
        prepared_scene.pair_contact_laws,
        max(min_acceleration_ratio_to_start_rocking(prepared_scene.elements), 1e-9),
    )
    loaded = laws.carried_weight_at_rest > 0
    heave = 2.0 * np.sqrt(0.5 * laws.normal_stiffness * laws.carried_weight_at_rest / STANDARD_GRAVITY)
    damping = laws.dashpot_coefficient[loaded] / heave[loaded]
    groups = (
        largest_penetration_under_own_weight(prepared_scene)
        / min(item.smaller_of_width_and_height for item in prepared_scene.elements if not item.has_prescribed_motion),
        float(damping.max()) if damping.size else np.nan,
        _ratio_of_time_step_to_stable_step(
            setting.common_parameters,
            np.array([prepared_scene.max_omega_squared_on_springs]),
            np.array([prepared_scene.max_dashpot_eigenvalue]),
            motion.sampling_interval,
        ),
        setting.amplitude_factor_by_case * np.abs(motion.north).max() / (STANDARD_GRAVITY * bound),
        setting.friction_by_case / bound,
    )
    return {
        name: np.broadcast_to(value, PARALLEL_CASE_COUNT_PER_SCENE)
        for name, value in zip(DIMENSIONLESS_GROUP_NAMES, groups, strict=True)
    }


def collect_stability_map_rows(
    simulate_and_check_item_at_index: Callable[..., dict[str, Any]],
    cases_or_settings: Sequence[Any],
    *,
    threads: int = 1,
    report_finished_and_total_count: Callable[[int, int], None] | None = None,
) -> pd.DataFrame:
    """Apply a function to each case or setting and its index; return the rows of the map in order.

    The function, such as `simulate_block_case_and_check_outcome`, returns one row for a case, or columns of several
    rows for a setting of several cases.
    """
    found: list[dict[str, Any]] = []
    with ThreadPoolExecutor(max_workers=threads) as pool:
        for one in pool.map(simulate_and_check_item_at_index, cases_or_settings, range(len(cases_or_settings))):
            found.append(one)
            if report_finished_and_total_count and len(found) % max(len(cases_or_settings) // 20, 1) == 0:
                report_finished_and_total_count(len(found), len(cases_or_settings))
    several = np.ndim(found[0]["ending"]) > 0
    rows = pd.concat(map(pd.DataFrame, found), ignore_index=True) if several else pd.DataFrame(found)
    return rows.astype({name: np.int8 for name in ("ending", "overturned") if name in rows})
