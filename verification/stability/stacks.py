"""Cases of the stability map: stacks of stones in 3-D; checks of their outcomes share no code with the kernel.

A setting is a stack of two to five stones with a contact law and a motion; its cases differ in friction, amplitude and
orientation. Slabs, slender shafts, light stones below heavy ones and vertical accelerations beyond −1 g are included.
Two of three stacks consist of boxes; the stones of the others are prisms on regular polygons, cylinders and boxes, in
half of these stacks all equally wide, like the drums of a column.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.balance import MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO
from overturning.dem.limits import MAX_PENETRATION_TO_HALF_SIDE_RATIO
from overturning.dem.numerics import BODY_STEP_COST_IN_BLOCK_STEPS, NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.errors import ArgumentError
from overturning.model.cases import MIN_STONE_HEIGHT_M, Cases
from overturning.model.contact import VertexContact
from overturning.model.element import ContactLaw, Element, Material, PlanShape, plan_area_of_circle_or_regular_polygon
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.results import CaseResults
from overturning.model.scene import Scene
from overturning.model.stack import Stack
from overturning.model.status import CaseStatus
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from verification.stability.cases import (
    PARALLEL_CASE_COUNT_PER_SCENE,
    SPACE_FILLING_MOTION_KINDS,
    BlockCaseOfNumericalStabilityMap,
    motion_of_case,
)
from verification.stability.checks import StabilityCheckVerdict

MAX_STEPS_OF_STACK_CASE: Final = 500_000
"""Largest number of time steps of a case."""
MAX_SHARE_OF_ONSET_ACCELERATION_WITHOUT_FALL: Final = 0.2
"""Share of the least acceleration that opens or slides a joint, up to which no stone may fall."""
MAX_PENETRATION_TO_WIDTH_OF_STIFF_CONTACT: Final = 1e-4
"""Static penetration over the width of a contact, below which the stones are close to rigid."""
PLAN_SHAPES: Final[tuple[PlanShape, ...]] = ("rectangle", "circle", 3, 5, 6, 8, 12, 16)
"""Plans of the stones of a stack that does not consist of boxes."""
STACK_COLUMN_LONG_NAMES_AND_UNITS: Final = {
    "stones": ("number of stones", "1"),
    "kind": ("boxes, prisms of several widths, or drums: prisms of one width", ""),
    "motion": ("kind of motion", ""),
    "sampling_interval": ("sampling interval of the motion", "s"),
    "thinnest": ("least height of a stone over its smaller side", "1"),
    "slenderest": ("largest height of a stone over its smaller side", "1"),
    "mass_ratio": ("largest mass of the stones above a stone over its own mass", "1"),
    "penetration_ratio": ("static penetration over the width of each contact", "1"),
    "damping": ("damping ratio of each contact", "1"),
    "friction": ("friction coefficient", "1"),
    "orientation_deg": ("azimuth to which the stack is oriented", "degree"),
    "peak": ("largest horizontal acceleration", "m s-2"),
    "vertical": ("largest downward acceleration over g", "1"),
    "acceleration_ratio": ("largest horizontal acceleration over the least that opens or slides a joint", "1"),
    "ending": ("how the case ended: " + ", ".join(f"{e.value} {e.label}" for e in StabilityCheckVerdict), "1"),
    "reason": ("argument that a refusal names, or check that does not hold", ""),
    "fallen": ("number of stones that fall; -1: no answer", "1"),
    "energy_error": ("residual of work and energy", "1"),
    "block_steps": ("steps computed, times stones", "1"),
}
"""Long name and unit of the columns of the map of stacks."""


@dataclass(frozen=True)
class ParametersOfStackCases:
    """Stack, contact law and motion of `PARALLEL_CASE_COUNT_PER_SCENE` cases, and the parameters of each case."""

    stone_sizes: FloatArray
    """Width, depth and height of each stone, m, from the lowest up, shape (stones, 3)."""
    stone_densities: FloatArray
    """Density of each stone, kg/m³, shape (stones,)."""
    static_penetration_to_width_ratio: float
    """Static penetration over the width of each contact."""
    contact_damping_ratio: float
    motion_with_1_g_peak: BlockCaseOfNumericalStabilityMap
    """Kind, sampling interval and vertical component of a motion with a peak of 1 g."""
    friction_by_case: FloatArray
    amplitude_factor_by_case: FloatArray
    orientation_deg_by_case: FloatArray
    plan_shape_by_stone: tuple[PlanShape, ...] = ()
    """Plan of each stone; empty: all are boxes. A stone of another plan than a rectangle is as deep as it is wide."""

    @property
    def boxes_prisms_or_drums(self) -> str:
        """Kind of stack: boxes, prisms, or drums."""
        return (
            "boxes" if not self.plan_shape_by_stone else "drums" if np.ptp(self.stone_sizes[:, 0]) == 0.0 else "prisms"
        )

    @property
    def stone_masses(self) -> FloatArray:
        """Mass of each stone, kg."""
        box: PlanShape = "rectangle"
        shares = [
            _plan_area_to_bounding_box_ratio(plan)
            for plan in self.plan_shape_by_stone or (box,) * len(self.stone_sizes)
        ]
        return np.asarray(self.stone_densities * self.stone_sizes.prod(axis=1) * shares)

    @property
    def min_joint_opening_acceleration(self) -> float:
        """Least steady horizontal acceleration that opens a joint of the stack, m/s².

        It is g times half the contact width over the height of the centre of mass above the joint, for the joint that
        opens first.
        """
        tops = np.cumsum(self.stone_sizes[:, 2])
        centres, feet = tops - 0.5 * self.stone_sizes[:, 2], tops - self.stone_sizes[:, 2]
        side, least = self.stone_sizes[:, :2].min(axis=1), np.inf
        for joint, foot in enumerate(feet):
            mass = self.stone_masses[joint:]
            height = float((mass * (centres[joint:] - foot)).sum() / mass.sum())
            patch = min(side[joint], side[joint - 1]) if joint > 0 else side[joint]
            least = min(least, 0.5 * float(patch) / height)
        return STANDARD_GRAVITY * least


def _plan_area_to_bounding_box_ratio(plan: PlanShape) -> float:
    """Return the area of a stone's plan over that of the square or rectangle around it."""
    return 1.0 if plan == "rectangle" else plan_area_of_circle_or_regular_polygon(plan, 1.0)


def generate_random_parameters_of_stack_cases(stack_count: int, seed: int) -> list[ParametersOfStackCases]:
    """Draw 3-D stacks at random, each with a contact law, a motion and the parameters of several cases."""
    generator = np.random.Generator(np.random.PCG64([seed, 45]))
    return [_generate_parameters_of_one_random_stack(generator) for _ in range(stack_count)]


def _generate_parameters_of_one_random_stack(generator: np.random.Generator) -> ParametersOfStackCases:
    """Draw a stack, contact law, motion and parameters of its cases at random."""

    def draw_log_uniform(lower_bound: float, upper_bound: float, value_count: int | None = None) -> Any:
        """Draw values whose logarithm is uniformly distributed."""
        return np.exp(generator.uniform(np.log(lower_bound), np.log(upper_bound), value_count))

    stones = int(generator.integers(2, 6))
    # Each stone is 0.5 to 1.2 times as wide as the one below.
    width = draw_log_uniform(0.1, 2.0) * np.cumprod(np.concatenate([[1.0], generator.uniform(0.5, 1.2, stones - 1)]))
    depth = width * draw_log_uniform(0.5, 2.0, stones)
    height = np.maximum(np.minimum(width, depth) * draw_log_uniform(0.02, 6.0, stones), MIN_STONE_HEIGHT_M)
    kind = ("vertical above g", *SPACE_FILLING_MOTION_KINDS)[int(generator.integers(4))]
    shaking = BlockCaseOfNumericalStabilityMap(
        normal_stiffness_per_corner=1.0, heave_damping_ratio=1.0, b_over_h=1.0, height=1.0, density=1.0, friction=1.0,
        scheme="centred", requested_step_to_stable_step_ratio=float("nan"),
        peak_horizontal_acceleration=STANDARD_GRAVITY, sampling_interval=float(draw_log_uniform(0.005, 0.05)),
        motion_kind=kind, motion_period_in_samples=float(draw_log_uniform(2.0, 200.0)),
        peak_upward_to_horizontal_ratio=float(max(generator.uniform(-1.0, 1.5), 0.0)),
    )  # fmt: skip
    amplitude = 5.0 * generator.random(PARALLEL_CASE_COUNT_PER_SCENE) ** 2
    amplitude = 0.7 + 0.6 * generator.random(PARALLEL_CASE_COUNT_PER_SCENE) if kind == "vertical above g" else amplitude
    amplitude[0] *= float(generator.random() < 0.5)
    slick = generator.random(PARALLEL_CASE_COUNT_PER_SCENE) < 0.05
    plans: tuple[PlanShape, ...] = ()
    if generator.random() < 1.0 / 3.0:
        plans = tuple(PLAN_SHAPES[number] for number in generator.integers(0, len(PLAN_SHAPES), stones))
        width = np.full(stones, width[0]) if generator.random() < 0.5 else width
        depth = width
    return ParametersOfStackCases(
        plan_shape_by_stone=plans, stone_sizes=np.round(np.stack([width, depth, height], axis=1), 4) + 1e-4,
        stone_densities=np.round(draw_log_uniform(500.0, 20_000.0, stones)),
        static_penetration_to_width_ratio=float(draw_log_uniform(1e-8, 1e-2)),
        contact_damping_ratio=float(draw_log_uniform(0.01, 5.0)),
        motion_with_1_g_peak=shaking,
        friction_by_case=np.where(slick, 0.0, draw_log_uniform(0.02, 10.0, PARALLEL_CASE_COUNT_PER_SCENE)),
        amplitude_factor_by_case=amplitude,
        orientation_deg_by_case=np.round(generator.uniform(0.0, 360.0, PARALLEL_CASE_COUNT_PER_SCENE), 1),
    )  # fmt: skip


def stack_scene_from_parameters(setting: ParametersOfStackCases) -> Scene:
    """Return the scene of a stack, from its stone sizes, plan shapes, densities and damping ratio of contacts."""
    elements = [Element(name="ground", kind="driven", width=1000.0, height=1.0, at=(0.0, -1.0))]
    materials = {"ground": Material()}
    for number, ((width, depth, height), density) in enumerate(
        zip(setting.stone_sizes, setting.stone_densities, strict=True)
    ):
        name, plan = (
            f"stone-{number}",
            setting.plan_shape_by_stone[number] if setting.plan_shape_by_stone else "rectangle",
        )
        sized: dict[str, Any] = {"depth": float(depth)} if plan == "rectangle" else {}
        materials[name] = Material(density=float(density))
        elements.append(Element(
            name=name, width=float(width), height=float(height), material=name, stands_on=elements[-1].name, plan=plan,
            **sized,
        ))  # fmt: skip
    pairs = [(below.material, above.material) for below, above in pairwise(elements)]
    elements[0] = elements[0].model_copy(update={"material": "ground"})
    pairs[0] = ("ground", pairs[0][1])
    return Scene(
        name="stack", reference=elements[-1].name, elements=tuple(elements), materials=materials,
        contacts=tuple(ContactLaw(between=pair, damping_ratio=setting.contact_damping_ratio) for pair in pairs),
    )  # fmt: skip


def name_of_first_failed_stack_check(
    setting: ParametersOfStackCases, motion: Motion, results: CaseResults, case_index: int
) -> str:
    """Return the name of the first check that the results of a case fail; empty if all checks hold."""
    fallen, amplitude = results.overturned[case_index] == 1, float(setting.amplitude_factor_by_case[case_index])
    if not CaseStatus(results.status[case_index]).trajectory_has_known_outcome:
        return "" if (results.overturned[case_index] == INT8_MISSING).all() else "flag in spite of the mark"
    if not np.isin(results.overturned[case_index], (0, 1)).all():
        return "no flag and no mark"
    if (np.diff(fallen.astype(int)) < 0).any():
        return "a stone stands on a fallen one"
    if any(
        (np.isfinite(getattr(results, name)[case_index]) != fallen).any()
        for name in ("fall_azimuth", "overturning_time")
    ):
        return "flag, azimuth and time"
    numbers = (results.energy_error[case_index], results.peak_penetration[case_index], *results.peak_tilt[case_index])
    slips = [
        getattr(results, name)[case_index] for name in ("residual_slip_north", "residual_slip_east", "residual_twist")
    ]
    if not (np.isfinite(numbers).all() and all(np.isfinite(values[~fallen]).all() for values in slips)):
        return "a number is not finite"
    if results.energy_error[case_index] > MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO:
        return "energy balance"
    if results.peak_penetration[case_index] > MAX_PENETRATION_TO_HALF_SIDE_RATIO * 0.5 * setting.stone_sizes.min() * (
        1.0 + 1e-6
    ):
        return "penetration"
    critical = np.degrees(np.arctan2(setting.stone_sizes[:, :2].min(axis=1), setting.stone_sizes[:, 2]))
    lowest = int(np.argmax(fallen))
    if (
        fallen.any()
        and not results.slid_off[case_index, lowest]
        and results.peak_tilt[case_index, lowest] < 0.99 * critical[lowest]
    ):
        return "fallen without tilt"
    up = np.zeros(motion.sample_count) if motion.up is None else amplitude * motion.up
    weight = STANDARD_GRAVITY + up
    demand = np.inf if (weight <= 0.0).any() else float(np.max(amplitude * np.abs(motion.north) / weight))
    onset = min(setting.min_joint_opening_acceleration / STANDARD_GRAVITY, float(setting.friction_by_case[case_index]))
    if results.status[case_index] == CaseStatus.AT_REST and demand > onset:
        return "left out above a threshold"
    if amplitude == 0.0 and (fallen.any() or max(np.abs(slips[0]).max(), np.abs(slips[1]).max()) > 1e-9):
        return "moved without motion"
    if (
        fallen.any()
        and demand < MAX_SHARE_OF_ONSET_ACCELERATION_WITHOUT_FALL * onset
        and setting.static_penetration_to_width_ratio < MAX_PENETRATION_TO_WIDTH_OF_STIFF_CONTACT
    ):
        return "fell below the least acceleration that moves a joint"
    return ""


def simulate_stack_cases_and_check_outcomes(
    setting: ParametersOfStackCases, setting_index_as_noise_seed: int
) -> dict[str, NDArray[Any]]:
    """Run the cases of a stack setting and check their outcomes.

    Return the columns of the map of stacks, with a value for each case.

    `setting_index_as_noise_seed` is the index of the setting on the map; it is the seed of the noise.
    """
    motion, stones = motion_of_case(setting.motion_with_1_g_peak, setting_index_as_noise_seed), len(setting.stone_sizes)
    above = np.cumsum(setting.stone_masses[::-1])[::-1] - setting.stone_masses
    relative = setting.stone_sizes[:, 2] / setting.stone_sizes[:, :2].min(axis=1)
    alike = {
        "stones": stones, "kind": setting.boxes_prisms_or_drums, "motion": setting.motion_with_1_g_peak.motion_kind,
        "sampling_interval": setting.motion_with_1_g_peak.sampling_interval,
        "thinnest": relative.min(), "slenderest": relative.max(), "mass_ratio": (above / setting.stone_masses).max(),
        "penetration_ratio": setting.static_penetration_to_width_ratio, "damping": setting.contact_damping_ratio,
        "ending": np.int8(StabilityCheckVerdict.ARGUMENT_REFUSED), "fallen": np.int8(-1), "energy_error": np.nan,
        "block_steps": np.int64(0),
    }  # fmt: skip
    rows: dict[str, NDArray[Any]] = {
        name: np.full(PARALLEL_CASE_COUNT_PER_SCENE, value) for name, value in alike.items()
    }
    peak = setting.amplitude_factor_by_case * np.abs(motion.north).max()
    down = 0.0 if motion.up is None else -float(motion.up.min()) / STANDARD_GRAVITY
    onset = np.minimum(setting.min_joint_opening_acceleration, setting.friction_by_case * STANDARD_GRAVITY)
    rows |= {
        "friction": setting.friction_by_case, "orientation_deg": setting.orientation_deg_by_case, "peak": peak,
        "vertical": setting.amplitude_factor_by_case * down, "acceleration_ratio": peak / np.maximum(onset, 1e-9),
        "reason": np.full(PARALLEL_CASE_COUNT_PER_SCENE, "", object),
    }  # fmt: skip
    scene = stack_scene_from_parameters(setting)
    height, ratio = reference_element_height_and_b_over_h(scene)
    try:
        cases = Cases(
            setting.orientation_deg_by_case, height, ratio, setting.friction_by_case, setting.amplitude_factor_by_case
        )
        model = Stack(scene, VertexContact(static_penetration=setting.static_penetration_to_width_ratio))
        found = simulate_cases(
            model,
            motion,
            cases,
            NumericalOptions(budget=BODY_STEP_COST_IN_BLOCK_STEPS * MAX_STEPS_OF_STACK_CASE * stones),
        )
    except ArgumentError as error:
        rows["reason"][:] = str(error).partition(":")[0].partition(" ")[0]
        return rows
    for row in range(PARALLEL_CASE_COUNT_PER_SCENE):
        reason = name_of_first_failed_stack_check(setting, motion, found, row)
        rows["ending"][row] = StabilityCheckVerdict.WRONG_WITHOUT_WARNING if reason else int(found.status[row])
        rows["reason"][row] = reason
        if not reason and CaseStatus(found.status[row]).trajectory_has_known_outcome:
            rows["fallen"][row] = np.count_nonzero(found.overturned[row])
    rows["energy_error"][:], rows["block_steps"][:] = found.energy_error, found.block_steps
    return rows
