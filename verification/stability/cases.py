"""Cases of the stability map: blocks, contacts and motions over wide ranges, and adversarial motions.

The shipped scenes are run with all sizes and contacts under the same motions.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.model.element import ContactLaw, Material
from overturning.model.scene import Scene, load_scene
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

MOTION_SAMPLE_COUNT: Final = 256
"""Samples of a motion of the space-filling part; only two in a hundred motions last 25 s, most are shorter."""

ORIGINAL_PAPER_DASHPOT_N_S_PER_M: Final = 3500.0
"""Dashpot of the original paper, N·s/m."""

SPACE_FILLING_MOTION_KINDS: Final = ("pulse", "noise", "square")
"""Motions of the space-filling part: one sine cycle, white noise, a square wave."""

ADVERSARIAL_MOTION_KINDS: Final = (
    "impulse",
    "ten minutes",
    "0.01 Hz sine",
    "50 Hz sine",
    "vertical above g",
    "constant offset",
)
"""Adversarial motions."""

SHARE_OF_CASES_WITH_VERTICAL_MOTION: Final = 1 / 3


@dataclass(frozen=True)
class BlockCaseOfNumericalStabilityMap:
    """One case of the map of stability: block, contact and motion, in SI units."""

    normal_stiffness_per_corner: float
    """Normal stiffness of a corner, per metre of depth, N/m."""
    heave_damping_ratio: float
    """Requested damping ratio of heave; NaN: the dashpot of the original paper."""
    b_over_h: float
    height: float
    density: float
    friction: float
    peak_horizontal_acceleration: float
    sampling_interval: float
    requested_step_to_stable_step_ratio: float
    """Requested time step over the longest stable one; NaN: automatic."""
    scheme: str
    motion_kind: str
    """One of `SPACE_FILLING_MOTION_KINDS` or `ADVERSARIAL_MOTION_KINDS`."""
    motion_period_in_samples: float
    """Period of pulse and square wave, in samples."""
    peak_upward_to_horizontal_ratio: float
    """Largest upward over largest horizontal acceleration."""

    def parameters_as_map_columns(self) -> dict[str, Any]:
        """Return the parameters as columns of a row of the map; see `maps.BLOCK_COLUMN_LONG_NAMES_AND_UNITS`."""
        return {_COLUMN_BY_DIFFERENTLY_NAMED_PARAMETER.get(name, name): value for name, value in vars(self).items()}

    @property
    def time_step_argument_of_run_cases(self) -> str:
        """Time step as an argument of `run_cases`: "auto", or a fraction of the longest stable step."""
        return (
            "auto"
            if np.isnan(self.requested_step_to_stable_step_ratio)
            else f"{self.requested_step_to_stable_step_ratio:.6f} stable"
        )


_COLUMN_BY_DIFFERENTLY_NAMED_PARAMETER: Final = {
    "normal_stiffness_per_corner": "stiffness", "heave_damping_ratio": "damping_ratio",
    "peak_horizontal_acceleration": "peak", "requested_step_to_stable_step_ratio": "step_fraction",
    "motion_kind": "motion", "motion_period_in_samples": "period", "peak_upward_to_horizontal_ratio": "vertical",
}  # fmt: skip
"""Columns of the map with another name than the parameter of `BlockCaseOfNumericalStabilityMap`."""


def _log_interpolate(share_of_log_range: FloatArray, value_at_0: float, value_at_1: float) -> FloatArray:
    """Interpolate between two positive values on a logarithmic scale, at shares of the range from 0 to 1."""
    return np.asarray(value_at_0 * (value_at_1 / value_at_0) ** share_of_log_range)


def space_filling_cases(case_count: int, seed: int) -> list[BlockCaseOfNumericalStabilityMap]:
    """Return cases of single blocks that fill wide ranges of all parameters: a scrambled Sobol sequence (Owen 1998).

    Stiffness, sizes, density and sampling interval are log-uniform; damping, friction and peak acceleration include 0.
    `seed` is that of the scramble.
    """
    from scipy.stats import qmc

    sobol = qmc.Sobol(d=13, scramble=True, rng=np.random.Generator(np.random.PCG64(seed)))
    u = np.clip(sobol.random_base2(max(int(np.ceil(np.log2(case_count))), 1))[:case_count], 0.0, 1.0 - 1e-12).T
    damping = np.where(u[1] < 0.05, 0.0, _log_interpolate(np.clip((u[1] - 0.05) / 0.85, 0.0, 1.0), 1e-3, 20.0))
    columns = {
        "normal_stiffness_per_corner": _log_interpolate(u[0], 1e4, 1e13),
        "heave_damping_ratio": np.where(u[1] > 0.9, np.nan, damping),
        "b_over_h": _log_interpolate(u[2], 0.02, 5.0),
        "height": _log_interpolate(u[3], 0.01, 50.0),
        "density": _log_interpolate(u[4], 500.0, 20_000.0),
        "friction": np.where(u[5] < 0.05, 0.0, _log_interpolate((u[5] - 0.05) / 0.95, 0.01, 10.0)),
        "peak_horizontal_acceleration": np.where(u[6] < 0.02, 0.0, 20.0 * u[6] ** 3) * STANDARD_GRAVITY,
        "sampling_interval": _log_interpolate(u[7], 1e-4, 0.1),
        "requested_step_to_stable_step_ratio": np.where(
            u[8] < 0.5, np.nan, _log_interpolate((u[8] - 0.5) / 0.5, 0.05, 1.0)
        ),
        "motion_period_in_samples": _log_interpolate(u[11], 2.0, 200.0),
        "peak_upward_to_horizontal_ratio": np.where(
            u[12] < SHARE_OF_CASES_WITH_VERTICAL_MOTION, 1.5 * u[12] / SHARE_OF_CASES_WITH_VERTICAL_MOTION, 0.0
        ),
    }
    schemes = np.where(u[9] < 0.8, "centred", "cundall")
    shapes = np.array(SPACE_FILLING_MOTION_KINDS)[(u[10] * len(SPACE_FILLING_MOTION_KINDS)).astype(int)]
    return [
        BlockCaseOfNumericalStabilityMap(
            scheme=str(schemes[row]),
            motion_kind=str(shapes[row]),
            **{name: float(values[row]) for name, values in columns.items()},
        )
        for row in range(case_count)
    ]


def cases_under_adversarial_motions(
    case_count_per_adversarial_motion: int, seed: int
) -> list[BlockCaseOfNumericalStabilityMap]:
    """Return cases under motions chosen to make the program fail: blocks of ordinary size on stiff contacts.

    Friction, damping and peak acceleration are from the whole ranges of `space_filling_cases`.
    """
    rows = []
    for number, motion in enumerate(ADVERSARIAL_MOTION_KINDS):
        for case in space_filling_cases(case_count_per_adversarial_motion, seed + 1 + number):
            # Ordinary sizes and stiff contacts, so that most cases have an answer and few are refused.
            height = 0.1 * (case.height / 0.01) ** 0.4
            penetration = 2e-6 * (case.normal_stiffness_per_corner / 1e4) ** (1 / 3)
            stiffness = case.density * height * STANDARD_GRAVITY / (2.0 * penetration)
            interval = {"ten minutes": 0.02, "0.01 Hz sine": 0.05, "50 Hz sine": 0.002}.get(motion, 0.01)
            peak = (
                case.peak_horizontal_acceleration
                if motion != "ten minutes"
                else min(case.peak_horizontal_acceleration, STANDARD_GRAVITY)
            )
            changed = {
                "normal_stiffness_per_corner": stiffness,
                "height": height,
                "peak_horizontal_acceleration": peak,
                "sampling_interval": interval,
            }
            rows.append(replace(case, motion_kind=motion, **changed))
    return rows


def motion_of_case(case: BlockCaseOfNumericalStabilityMap, noise_random_seed: int) -> Motion:
    """Return the motion of a case; `noise_random_seed` is the seed of its noise."""
    generator = np.random.Generator(np.random.PCG64([7, noise_random_seed]))
    peak, interval = case.peak_horizontal_acceleration, case.sampling_interval
    time = np.arange(MOTION_SAMPLE_COUNT, dtype=np.float64)
    match case.motion_kind:
        case "pulse":
            north = np.where(
                time <= case.motion_period_in_samples,
                peak * np.sin(2 * np.pi * time / case.motion_period_in_samples),
                0.0,
            )
        case "noise":
            north = generator.uniform(-peak, peak, MOTION_SAMPLE_COUNT)
        case "square":
            north = np.where(time % case.motion_period_in_samples < 0.5 * case.motion_period_in_samples, peak, -peak)
        case "impulse":
            north = np.where(time == 20, peak, 0.0)
        case "ten minutes":
            time = np.arange(int(600 / interval), dtype=np.float64)
            # Swelling and fading noise.
            north = peak * np.sin(np.pi * time / time.size) * generator.uniform(-1.0, 1.0, time.size)
        case "0.01 Hz sine":
            time = np.arange(int(200 / interval), dtype=np.float64)
            north = peak * np.sin(2 * np.pi * 0.01 * interval * time)
        case "50 Hz sine":
            time = np.arange(2000, dtype=np.float64)
            north = peak * np.sin(2 * np.pi * 50.0 * interval * time)
        case "vertical above g":
            north = peak * np.sin(2 * np.pi * time / 64)
        case "constant offset":
            north = np.full(MOTION_SAMPLE_COUNT, peak)
        case _:
            raise ValueError(f"motion: {case.motion_kind!r} is not known")
    up = None
    if case.motion_kind == "vertical above g":
        up = STANDARD_GRAVITY * (1.5 + case.peak_upward_to_horizontal_ratio) * np.sin(2 * np.pi * time / 48 + 1.0)
    elif case.peak_upward_to_horizontal_ratio > 0:
        up = case.peak_upward_to_horizontal_ratio * peak * generator.uniform(-1.0, 1.0, time.size)
    return Motion(north, np.zeros(time.size), up, sampling_interval=interval, trust_data=True)


SCENE_NAMES: Final = ("gravestone", "three-tier", "against-a-wall", "boulder")
"""Scenes of config/scenes; all of them, the gravestone included, run in the general kernel."""

PARALLEL_CASE_COUNT_PER_SCENE: Final = 8
"""Number of cases that differ only in friction, amplitude and side; the general kernel runs them side by side."""

SHARE_OF_SETTINGS_WITH_STIFFNESS_IN_N_PER_M: Final = 1 / 3
"""Share of the settings with K_n in N/m; in the others δ/B is given."""


@dataclass(frozen=True)
class ParametersOfSceneCases:
    """Common and individual parameters of `PARALLEL_CASE_COUNT_PER_SCENE` cases of a scene that run together."""

    scene_name: str
    common_parameters: BlockCaseOfNumericalStabilityMap
    """Common contact, sizes and motion: height of the reference element, B/H as a factor on that of the scene, and peak
    before the amplitudes; the friction is not used."""
    static_penetration_to_width_ratio: float
    """δ/B of each contact; NaN if the stiffness is given in N/m."""
    friction_by_case: FloatArray
    amplitude_factor_by_case: FloatArray
    """Factors on the motion."""
    azimuth_deg_by_case: FloatArray
    """Azimuths of the motion: 0 or 180."""


def sample_parameters_of_scene_cases(
    space_filling_count_per_scene: int, count_per_scene_and_adversarial_motion: int, seed: int
) -> list[ParametersOfSceneCases]:
    """Draw parameters of cases of each scene: under space-filling motions, and under each adversarial motion.

    Adversarial motions are chosen to make the program fail. Each item of the list has the parameters of several cases.
    """
    found = []
    for number, scene in enumerate(SCENE_NAMES):
        generator = np.random.Generator(np.random.PCG64([seed, number]))
        sample = space_filling_cases(space_filling_count_per_scene, seed + 100 * (number + 1))
        found += [_draw_parameters_of_scene_cases(scene, case, generator) for case in sample]
        for place, motion in enumerate(ADVERSARIAL_MOTION_KINDS):
            for case in space_filling_cases(
                count_per_scene_and_adversarial_motion, seed + 100 * (number + 1) + place + 1
            ):
                # Ordinary sizes, so that most cases end within their budget.
                interval = {"ten minutes": 0.05, "0.01 Hz sine": 0.05, "50 Hz sine": 0.002}.get(motion, 0.01)
                ordinary = replace(
                    case, motion_kind=motion, height=0.1 * (case.height / 0.01) ** 0.4, sampling_interval=interval
                )
                found.append(
                    _draw_parameters_of_scene_cases(
                        scene,
                        ordinary,
                        generator,
                        min_static_penetration_to_width_ratio=1e-6,
                        max_static_penetration_to_width_ratio=1e-2,
                    )
                )
    return found


def _draw_parameters_of_scene_cases(
    scene: str,
    case: BlockCaseOfNumericalStabilityMap,
    generator: np.random.Generator,
    min_static_penetration_to_width_ratio: float = 1e-12,
    max_static_penetration_to_width_ratio: float = 0.5,
) -> ParametersOfSceneCases:
    """Draw the common and individual parameters of cases of a scene.

    The stiffness of the contacts is given as static penetration over width, between the two limits: the stiffer the
    single-block case `case`, the smaller the penetration. With the default limits, some settings use the stiffness of
    `case` in N/m instead.
    """
    # Position of the stiffness of the block's case within the logarithmic range 1e4 to 1e13 N/m.
    share = np.log(case.normal_stiffness_per_corner / 1e4) / np.log(1e9)
    absolute = (
        min_static_penetration_to_width_ratio == 1e-12
        and generator.random() < SHARE_OF_SETTINGS_WITH_STIFFNESS_IN_N_PER_M
    )
    factor = 1.0 if generator.random() < 0.5 else float(np.exp(generator.uniform(np.log(0.5), np.log(2.2))))
    vertical = case.motion_kind == "vertical above g"
    amplitude = (
        generator.uniform(0.7, 1.3, PARALLEL_CASE_COUNT_PER_SCENE)
        if vertical
        else 20.0 * generator.random(PARALLEL_CASE_COUNT_PER_SCENE) ** 3
    )
    amplitude[0] *= generator.random() < 0.5 or vertical
    friction = np.where(
        generator.random(PARALLEL_CASE_COUNT_PER_SCENE) < 0.05,
        0.0,
        10.0 ** generator.uniform(-2.0, 1.0, PARALLEL_CASE_COUNT_PER_SCENE),
    )
    return ParametersOfSceneCases(
        scene,
        replace(case, b_over_h=factor, peak_horizontal_acceleration=9.80665, friction=float("nan")),
        float("nan")
        if absolute
        else float(
            max_static_penetration_to_width_ratio
            * (min_static_penetration_to_width_ratio / max_static_penetration_to_width_ratio) ** share
        ),
        friction,
        amplitude,
        np.where(generator.random(PARALLEL_CASE_COUNT_PER_SCENE) < 0.5, 0.0, 180.0),
    )


def load_scene_with_case_density_and_contact_law(
    setting: ParametersOfSceneCases, project_folder: Path = Path()
) -> Scene:
    """Load the scene named in `setting`, and return it with the density and contact law of `setting`."""
    scene, case = load_scene(setting.scene_name, project_folder), setting.common_parameters
    damping = (
        {"damping": ORIGINAL_PAPER_DASHPOT_N_S_PER_M}
        if np.isnan(case.heave_damping_ratio)
        else {"damping_ratio": case.heave_damping_ratio}
    )
    law = ContactLaw(between=("stone", "stone"), **damping)
    if np.isnan(setting.static_penetration_to_width_ratio):
        law = law.model_copy(update={"stiffness": case.normal_stiffness_per_corner})
    else:
        law = law.model_copy(update={"static_penetration": setting.static_penetration_to_width_ratio})
    return scene.model_copy(update={"materials": {"stone": Material(density=case.density)}, "contacts": (law,)})
