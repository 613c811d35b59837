"""Options of `overturning one` that film a cell of a cube."""

import shlex
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.errors import OverturningError
from overturning.model.contact import DEFAULT_CONTACT_DAMPING_RATIO
from overturning.model.planes import PlanarModel
from overturning.model.scene import Scene, gravestone, load_scene
from overturning.study.cube import study_of_cube
from overturning.study.scenes import (
    StudyToSceneSizeConversion,
    settings_changed_by_variant,
    variant_contact_settings,
    variant_model,
    variant_uses_vertical_motion,
)
from overturning.study.schema import Study
from overturning.study.sections import RecordSettings, SimulationSettings
from overturning.units import DEFAULT_STONE_DENSITY_KG_M3

if TYPE_CHECKING:
    import xarray as xr


def film_command_options_and_stone_sizes(cube: "xr.Dataset") -> dict[str, Any]:
    """Return the options with which `overturning one` films cases of a results cube, and the stone sizes to give.

    Returns
    -------
    dict
        ``missing``: reasons why `overturning one` cannot simulate these cases, or ""; ``options``: its options, list of
        str; ``heights`` (m) and ``ratios`` (B/H): size of the scene's reference element for each height and B/H of the
        cube; ``friction``: False if the scene sets all its friction coefficients; ``pulses``: definition of each
        synthetic pulse, by record id.
    """
    if "study" not in cube.attrs:
        empty: dict[str, Any] = {"options": [], "heights": [], "ratios": [], "friction": True, "pulses": {}}
        return {"missing": "the cube belongs to no study", **empty}
    study, variant = study_of_cube(cube), str(cube.attrs["variant"])
    missing, options = _unsupported_reasons_and_motion_options(study, variant)
    own_missing, own_options = _obstacles_and_model_options_of_overturning_one(study, variant)
    model, sizes = variant_model(study, variant), StudyToSceneSizeConversion.for_variant(study, variant)
    height, ratio = (np.asarray(cube[name].to_numpy(), np.float64) for name in ("height", "b_over_h"))
    return {
        "missing": "; ".join(missing + own_missing),
        "options": options + own_options,
        "heights": [round(float(one), 9) for one in sizes.to_variant_reference_stone_heights(height)],
        "ratios": [round(float(one), 9) for one in sizes.to_variant_reference_stone_b_over_h(ratio, ratio)],
        "friction": not isinstance(model, PlanarModel) or model.scene.has_contact_with_unset_friction,
        "pulses": dict(study.records.pulses),
    }


def _unsupported_reasons_and_motion_options(study: Study, variant: str) -> tuple[list[str], list[str]]:
    """Return reasons why `overturning one` cannot apply a study's motions, and the options that select the motions."""
    own = settings_changed_by_variant(study, variant)
    missing = []
    if study.processing is not None:
        missing.append("the study processes its records in its own way")
    if own.site is not None or study.site is not None:
        missing.append("the motion goes through soil")
    if study.simulation.model_copy(update={"vertical": True}) != SimulationSettings():
        missing.append("the study has numerical settings of its own")
    options = [] if variant_uses_vertical_motion(study, variant) else ["--no-vertical"]
    for name, words in (("table", "record table"), ("folder", "folder of records")):
        if (given := getattr(study.records, name)) == RecordSettings.model_fields[name].default:
            continue
        if Path(given).name == given and not Path(given).exists():  # of an absolute path, results state only the name
            missing.append(f"the {words} {given} is not in the project's folder")
        options += [f"--{name}", shlex.quote(given)]
    return missing, options


def _obstacles_and_model_options_of_overturning_one(study: Study, variant: str) -> tuple[list[str], list[str]]:
    """Return reasons why `overturning one` cannot simulate a study's block or scene, and the options that set it."""
    contact = variant_contact_settings(study, variant)
    ratio = contact.damping_ratio
    missing = [] if contact.stiffness_ratio == 1.0 else ["the contact has a stiffness ratio of its own"]
    options = [] if ratio in (None, DEFAULT_CONTACT_DAMPING_RATIO) else ["--damping-ratio", f"{ratio:g}"]
    if study.body is not None:
        if study.body.scan is not None:
            missing.append("the results do not contain the file of the scan, which overturning one --mesh FILE needs")
        elif study.body.vertices is not None:
            missing.append("the body is given by its vertices")
        plan = study.body.plan
        return missing, [*options, "--body", *([] if plan == "rectangle" else ["--plan", str(plan)])]
    scene = settings_changed_by_variant(study, variant).scene or study.scene
    if scene != gravestone():
        known = _scene_file_holds_same_scene(scene)
        return [] if known else ["the scene is no file of config/scenes"], ["--scene", scene.name]
    options += [] if study.density == DEFAULT_STONE_DENSITY_KG_M3 else ["--density", f"{study.density:g}"]
    options += [] if contact.damping is None else ["--damping", f"{contact.damping:g}"]
    options += [] if contact.stiffness == "auto" else ["--stiffness", f"{contact.stiffness:g}"]
    return missing, options


def _scene_file_holds_same_scene(scene: Scene) -> bool:
    """True if a scene file with the name of `scene` exists and defines an equal scene."""
    with suppress(OverturningError):
        return load_scene(scene.name) == scene
    return False
