"""What a study, or a variant of it, simulates: its model, the grid of cases, at which sizes, and how."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.numerics import Numerics, Progress
from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.errors import ConfigError
from overturning.model.body import Body
from overturning.model.contact import DAMPING_RATIO, Contact, VertexContact
from overturning.model.geometry import native_size
from overturning.model.grid import Grid
from overturning.model.model import Model
from overturning.model.planes import Planes
from overturning.model.scene import Scene, gravestone
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.study.schema import Study
from overturning.study.sections import ContactSettings, Variant

NOMINAL = "nominal"
"""Name of the study's own setting among its variants."""


def variant_names(study: Study) -> list[str]:
    """Names of the settings of a study, the nominal one first."""
    return [NOMINAL, *study.variants]


def setting_of(study: Study, variant: str = NOMINAL) -> Variant:
    """What a variant changes, `None` where it is as the study has it; of the nominal one nothing.

    A `ConfigError` says that the study has no such variant.
    """
    if variant not in variant_names(study):
        raise ConfigError(f"{study.name}: no variant {variant!r}; known: {', '.join(variant_names(study))}")
    return study.variants.get(variant, Variant())


def contact_of(study: Study, variant: str = NOMINAL) -> ContactSettings:
    """The contact of a variant: its own, or the study's."""
    own = setting_of(study, variant).contact
    return study.contact if own is None else own


def scene_of(study: Study, variant: str = NOMINAL) -> Scene:
    """The scene of a variant, as of `setting_of`; the default one with the density and contact that the study gives."""
    scene = setting_of(study, variant).scene or study.scene
    if scene != gravestone():
        return scene
    return gravestone(Contact(**contact_of(study, variant).model_dump()), study.density)


def model_for(study: Study, variant: str = NOMINAL) -> Model:
    """What a variant simulates; a `ConfigError` if the study has no such variant."""
    if study.body is None:
        return Planes(scene_of(study, variant))
    contact = contact_of(study, variant)
    ratio = DAMPING_RATIO if contact.damping_ratio is None else contact.damping_ratio
    return Body(study.body.shape(), VertexContact(stiffness_ratio=contact.stiffness_ratio, damping_ratio=ratio))


def grid_of(study: Study, variant: str = NOMINAL) -> Grid:
    """The grid of a study, or of a variant; directions ascending, int16 where all are whole, float64 otherwise."""
    model = model_for(study, variant)
    values = {
        "height": study.height, "b_over_h": study.b_over_h, "aspect": study.aspects, "friction": study.friction,
    }  # fmt: skip
    rows = {name: np.array(values[name], np.float64) for name in model.case_dims}
    element = model.elements if len(model.elements) > 1 else ()
    amplitude = study.amplitude if len(study.amplitude) > 1 else ()
    return Grid({model.direction: directions(study.directions)} | rows, element, amplitude)


def directions(values: Sequence[float]) -> NDArray[Any]:
    """Directions as int16 where all are whole, float64 otherwise."""
    given = np.array(values, np.float64)
    return given.astype(np.int16) if np.array_equal(given, np.round(given)) else given


@dataclass(frozen=True)
class Sizes:
    """How the sizes of a variant's scene follow from those of the study's."""

    factor: float = 1.0  # on the study's heights
    own_ratio: float | None = None  # the scene's B/H, where the study's are not for its reference element
    digits: int | None = 12  # to which a B/H is rounded, in a scene that the study names

    @classmethod
    def of(cls, study: Study, variant: str) -> "Sizes":
        """Those of a variant: scaled by the same factor as the study's own scene."""
        scene = setting_of(study, variant).scene or study.scene
        if scene == study.scene:
            return cls(digits=None if scene == gravestone() else 12)
        own_height, own_ratio = native_size(scene)
        factor = own_height / native_size(study.scene)[0]
        return cls(factor, own_ratio if scene.reference_name != study.scene.reference_name else None)

    def heights(self, height: FloatArray) -> FloatArray:
        """Heights of the scene's reference element where the study's are these, m."""
        return height if self.factor == 1.0 else np.round(height * self.factor, 10)

    def ratios(self, b_over_h: FloatArray, nominal: FloatArray) -> FloatArray:
        """B/H of the scene's reference element where the study's are these, each near one of the nominal ones."""
        if self.own_ratio is not None:
            # The scene keeps its own slenderness; the factor on the study's applies to it.
            b_over_h = self.own_ratio * (b_over_h / nominal[np.abs(np.log(b_over_h[:, None] / nominal)).argmin(axis=1)])
        return b_over_h if self.digits is None else np.round(b_over_h, self.digits)


def size_note(study: Study, variant: str) -> str:
    """What the heights and B/H of a study mean in a variant whose stone has others; nothing where they are its own."""
    sizes = Sizes.of(study, variant)
    own, stone = study.scene.reference_name, scene_of(study, variant).reference_name
    said = [] if sizes.factor == 1.0 else [f"{sizes.factor:.3g} times that height"]
    said += [] if sizes.own_ratio is None else [f"a B/H of {sizes.own_ratio:.3g} whatever the {own} has"]
    return f"H and B/H are those of the study's {own}; the {stone} has {' and '.join(said)}" if said else ""


def numerics_of(study: Study, threads: int = 1, progress: Progress | None = None, client: Any = None) -> Numerics:
    """How a study is computed."""
    given = study.simulation
    scheme, taken = given.scheme or DEFAULT_SCHEME, {"threads": threads, "progress": progress, "client": client}
    return Numerics(scheme=scheme, time_step=given.time_step, leave_out=given.leave_out, **taken)


def uses_vertical(study: Study, variant: str = NOMINAL) -> bool:
    """Whether a variant applies the vertical motion of the records that have one."""
    own = setting_of(study, variant).vertical
    return study.simulation.vertical if own is None else own


def motion_of(study: Study, record: Record, variant: str = NOMINAL) -> Motion:
    """The motion of a record as a variant applies it: without the vertical component where it leaves that out."""
    return Motion.of(record if uses_vertical(study, variant) else replace(record, up=None))
