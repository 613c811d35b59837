"""The scene axis of the stability map: shipped scenes at all sizes, with all contacts, under the map's motions."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.model.element import ContactLaw, Material
from overturning.model.scene import Scene, load_scene
from verification.stability.cases import (
    ADVERSARIAL,
    PAPER_DAMPING,
    StabilityCase,
    space_filling,
)

SCENES: Final = ("gravestone", "three-tier", "against-a-wall", "boulder")
"""Of config/scenes; the gravestone, too, in the general kernel."""

TOGETHER: Final = 8
"""Cases that share all but friction, amplitude and side: the general kernel runs so many beside one another."""

SHARE_ABSOLUTE: Final = 1 / 3
"""Share of the settings with K_n in N/m; the others have a share of the width as static penetration."""


@dataclass(frozen=True)
class SceneSetting:
    """What `TOGETHER` cases of a scene share, and in what they differ.

    Attributes
    ----------
    scene : str
        Name of the scene.
    common : StabilityCase
        Contact, sizes and motion; its height is that of the reference element, its B/H a factor on the scene's own, its
        peak that of the motion before the amplitudes, its friction unused.
    static_penetration : float
        δ/B of each contact; NaN where the stiffness is absolute.
    friction, amplitude, azimuth_deg : ndarray, shape (TOGETHER,)
        μ, factor on the motion, and 0 or 180.
    """

    scene: str
    common: StabilityCase
    static_penetration: float
    friction: FloatArray
    amplitude: FloatArray
    azimuth_deg: FloatArray


def scene_settings(per_scene: int, adversarial: int, seed: int) -> list[SceneSetting]:
    """Settings of all scenes, from the block's own space-filling sample and its adversarial motions.

    Parameters
    ----------
    per_scene, adversarial : int
        Settings of each scene, and of each scene under each adversarial motion.
    seed : int
        Of the sample.
    """
    found = []
    for number, scene in enumerate(SCENES):
        generator = np.random.Generator(np.random.PCG64([seed, number]))
        sample = space_filling(per_scene, seed + 100 * (number + 1))
        found += [_setting(scene, case, generator) for case in sample]
        for place, motion in enumerate(ADVERSARIAL):
            for case in space_filling(adversarial, seed + 100 * (number + 1) + place + 1):
                # Ordinary sizes, so that most cases get an answer instead of running out of their budget.
                interval = {"ten minutes": 0.05, "0.01 Hz sine": 0.05, "50 Hz sine": 0.002}.get(motion, 0.01)
                ordinary = replace(
                    case, motion=motion, height=0.1 * (case.height / 0.01) ** 0.4, sampling_interval=interval
                )
                found.append(_setting(scene, ordinary, generator, softest=1e-6, stiffest=1e-2))
    return found


def _setting(
    scene: str, case: StabilityCase, generator: np.random.Generator, softest: float = 1e-12, stiffest: float = 0.5
) -> SceneSetting:
    # The stiffness of the block's case, 1e4 to 1e13 N/m, evenly spread over its logarithm, as a share of that range.
    share = np.log(case.stiffness / 1e4) / np.log(1e9)
    absolute = softest == 1e-12 and generator.random() < SHARE_ABSOLUTE
    factor = 1.0 if generator.random() < 0.5 else float(np.exp(generator.uniform(np.log(0.5), np.log(2.2))))
    vertical = case.motion == "vertical above g"
    amplitude = generator.uniform(0.7, 1.3, TOGETHER) if vertical else 20.0 * generator.random(TOGETHER) ** 3
    amplitude[0] *= generator.random() < 0.5 or vertical
    friction = np.where(generator.random(TOGETHER) < 0.05, 0.0, 10.0 ** generator.uniform(-2.0, 1.0, TOGETHER))
    return SceneSetting(
        scene,
        replace(case, b_over_h=factor, peak=9.80665, friction=float("nan")),
        float("nan") if absolute else float(stiffest * (softest / stiffest) ** share),
        friction,
        amplitude,
        np.where(generator.random(TOGETHER) < 0.5, 0.0, 180.0),
    )


def scene_of_setting(setting: SceneSetting, root: Path = Path()) -> Scene:
    """The scene with the setting's density and contact law."""
    scene, case = load_scene(setting.scene, root), setting.common
    damping = {"damping": PAPER_DAMPING} if np.isnan(case.damping_ratio) else {"damping_ratio": case.damping_ratio}
    law = ContactLaw(between=("stone", "stone"), **damping)
    if np.isnan(setting.static_penetration):
        law = law.model_copy(update={"stiffness": case.stiffness})
    else:
        law = law.model_copy(update={"static_penetration": setting.static_penetration})
    return scene.model_copy(update={"materials": {"stone": Material(density=case.density)}, "contacts": (law,)})
