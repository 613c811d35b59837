"""How a study's cases are run again more exactly: a block's with the fast kernel, a scene's with that of polygons."""

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.cases import Cases, run_cases
from overturning.dem.contact import Contact
from overturning.dem.polygon.cases import run_scene_cases
from overturning.dem.polygon.scene import ContactLaw, Scene
from overturning.dem.polygon.simulate import block_contact, is_block
from overturning.motion.motion import Motion
from overturning.study.config import Study
from overturning.study.sweep import simulation_arguments

FINER: Final = 8
"""Steps of the first repetition in each of the study's."""

STIFFER: Final = 4.0
"""Stiffness of the second repetition over the study's; the step follows, as 1/√4, where the contact and not rocking limits it."""

Again = Callable[[Motion, Cases], tuple[NDArray[np.int8], NDArray[np.int64]]]
"""Flags, shape (n, elements), and block steps, shape (n,), of cases under a motion."""


def repetitions(study: Study) -> dict[str, Again]:
    """How each repetition of a study's nominal cases is computed, by name.

    A step given in seconds shrinks with the period of the stiffer contact; an automatic one follows the stable one.
    """
    step = study.simulation.time_step
    shorter = step if isinstance(step, str) else step / np.sqrt(STIFFER)
    if study.scene is None:
        given = simulation_arguments(study)
        stiff = given | {"contact": stiffer_contact(given["contact"]), "time_step": shorter}
        return {"finer": _block(**given, refinement=FINER), "stiffer": _block(**stiff)}
    simulation = study.simulation
    common: dict[str, Any] = {"scheme": simulation.scheme, "leave_out": simulation.leave_out}
    return {
        "finer": _scene(study.scene, time_step=step, refinement=FINER, **common),
        "stiffer": _scene(stiffer_scene(study.scene), time_step=shorter, **common),
    }


def stiffer_contact(contact: Contact) -> Contact:
    """The contact with springs `STIFFER` times as stiff and the same damping, ratio or dashpot, as was given."""
    if contact.stiffness == "auto":
        return replace(contact, static_penetration=contact.static_penetration / STIFFER)
    assert not isinstance(contact.stiffness, str)  # checked by Contact
    return replace(contact, stiffness=contact.stiffness * STIFFER)


def stiffer_scene(scene: Scene) -> Scene:
    """The scene with all springs `STIFFER` times as stiff, also those of the default contact law."""
    given = {frozenset(law.between): law for law in scene.contacts}
    laws = []
    for pair in itertools.combinations_with_replacement(scene.materials, 2):
        law = given.get(frozenset(pair), ContactLaw(between=pair))
        changed: dict[str, float] = {"static_penetration": law.static_penetration / STIFFER}
        if law.stiffness != "auto":
            changed = {"stiffness": law.stiffness * STIFFER}
        laws.append(law.model_copy(update=changed))
    return scene.model_copy(update={"contacts": tuple(laws)})


def _block(**arguments: Any) -> Again:
    def again(motion: Motion, cases: Cases) -> tuple[NDArray[np.int8], NDArray[np.int64]]:
        found = run_cases(motion, cases, **arguments)
        return found.overturned[:, None], found.block_steps

    return again


def _scene(scene: Scene, *, scheme: str | None, time_step: float | str, leave_out: bool, refinement: int = 1) -> Again:
    given: dict[str, Any] = {"time_step": time_step, "leave_out": leave_out, "refinement": refinement}
    if scheme is not None:
        given["scheme"] = scheme
    if is_block(scene):
        # As the sweep does it: the fast kernel, with the scene's own contact, density and, where it has one, friction.
        law = scene.law(*scene.elements)
        given |= {"contact": block_contact(scene), "density": scene.materials[scene.elements[1].material].density}
        run = _block(**given)
        if law.friction is None:
            return run
        friction = law.friction
        return lambda motion, cases: run(motion, replace(cases, friction=np.full(cases.size, friction)))

    def again(motion: Motion, cases: Cases) -> tuple[NDArray[np.int8], NDArray[np.int64]]:
        found = run_scene_cases(scene, motion, cases, **given)
        return found.overturned, found.block_steps

    return again
