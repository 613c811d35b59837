"""Model, grid, sizes and numerical settings of a study or of one of its variants."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.numerics import NumericalOptions, ProgressCallback
from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.errors import ConfigError
from overturning.model.body import Body
from overturning.model.contact import DEFAULT_CONTACT_DAMPING_RATIO, Contact, ContactSettings, VertexContact
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.grid import CaseGrid
from overturning.model.model import Model
from overturning.model.planes import PlanarModel
from overturning.model.scene import Scene, gravestone
from overturning.model.stack import Stack
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.study.schema import Study
from overturning.study.sections import Variant

if TYPE_CHECKING:
    import xarray as xr
    from distributed import Client

NAME_OF_STUDY_ITSELF_AMONG_VARIANTS = "nominal"
"""Name of the study itself in the list of its variants."""


def variant_names(study: Study) -> list[str]:
    """Return "nominal" (the study itself) and the names of its variants (the study with some settings changed)."""
    return [NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, *study.variants]


def settings_changed_by_variant(study: Study, variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS) -> Variant:
    """Return the settings of a study that a variant (a repetition of the study) changes; the others are None.

    A `ConfigError` is raised if the study has no such variant.
    """
    if variant not in variant_names(study):
        raise ConfigError(f"{study.name}: no variant {variant!r}; known: {', '.join(variant_names(study))}")
    return study.variants.get(variant, Variant())


def variant_contact_settings(study: Study, variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS) -> ContactSettings:
    """Return the contact settings of a variant of a study, which are the study's unless the variant changes them."""
    own = settings_changed_by_variant(study, variant).contact
    return study.contact if own is None else own


def variant_scene(study: Study, variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS) -> Scene:
    """Return the scene of a study or variant; the default gravestone gets the study's density and contact settings."""
    scene = settings_changed_by_variant(study, variant).scene or study.scene
    if scene != gravestone():
        return scene
    return gravestone(Contact(**variant_contact_settings(study, variant).model_dump()), study.density)


def select_outcomes_of_element(cube: "xr.Dataset", element_name: str) -> "xr.Dataset":
    """Select the outcomes of one scene element from a results cube; a cube of one element is returned unchanged."""
    return cube.sel(element=element_name) if "element" in cube.dims else cube


def compared_element_names_of_study_and_variant(study: Study, variant: str) -> tuple[str, str]:
    """Return the names of the scene elements whose outcomes are compared between a study and one of its variants.

    These are the elements shown by default in the scenes of study and variant. If their names differ, but an element
    of one of these names is in both scenes, this name is returned twice.
    """
    scenes = [variant_scene(study, name) for name in (NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant)]
    shown = [scene.name_of_element_shown_by_default for scene in scenes]
    in_both = [name for name in shown if all(name in scene.free_element_names for scene in scenes)]
    return (in_both[0], in_both[0]) if in_both else (shown[0], shown[1])


def variant_model(study: Study, variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS) -> Model:
    """Return the mechanical model of a study or of one of its variants: 2-D scene, 3-D body or stack.

    A `ConfigError` is raised if the study has no such variant.
    """
    if study.is_stack:
        return Stack(variant_scene(study, variant))
    if study.body is None:
        return PlanarModel(variant_scene(study, variant))
    contact = variant_contact_settings(study, variant)
    ratio = DEFAULT_CONTACT_DAMPING_RATIO if contact.damping_ratio is None else contact.damping_ratio
    return Body(study.body.body_shape(), VertexContact(stiffness_ratio=contact.stiffness_ratio, damping_ratio=ratio))


def variant_grid(study: Study, variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS) -> CaseGrid:
    """Return the parameter grid of a study or variant: directions, height, B/H, D/B, friction, amplitude, elements."""
    model = variant_model(study, variant)
    values = {
        "height": study.height, "b_over_h": study.b_over_h, "aspect": study.aspect_ratios_d_over_b,
        "friction": study.friction,
    }  # fmt: skip
    rows = {name: np.array(values[name], np.float64) for name in model.case_dims_without_direction}
    element = model.free_element_names if len(model.free_element_names) > 1 else ()
    amplitude = study.amplitude if len(study.amplitude) > 1 else ()
    return CaseGrid(
        {model.direction_dimension_name: directions_as_int16_if_whole(study.azimuths_or_orientations_deg)} | rows,
        element,
        amplitude,
    )


def cube_covers_study_grid(cube: "xr.Dataset", study: Study) -> bool:
    """True if a results cube has every direction, block size, friction and amplitude of its study or variant."""
    grid = variant_grid(study, cube.attrs["variant"])
    whole = grid.values_by_dimension | (
        {"amplitude": np.array(grid.motion_amplitude_factors_if_several)}
        if grid.motion_amplitude_factors_if_several
        else {}
    )
    return all(cube.sizes.get(name) == row.size and np.allclose(cube[name], row) for name, row in whole.items())


def directions_as_int16_if_whole(directions_deg: Sequence[float]) -> NDArray[Any]:
    """Convert directions (degrees) to an array: int16 if all are whole numbers, otherwise float64."""
    given = np.array(directions_deg, np.float64)
    return given.astype(np.int16) if np.array_equal(given, np.round(given)) else given


@dataclass(frozen=True)
class StudyToSceneSizeConversion:
    """Conversion of the study's heights and B/H to those of the stone that sets the size of a variant's scene."""

    scene_over_study_height_ratio: float = 1.0  # factor on the study's heights
    scene_b_over_h_if_study_reference_differs: float | None = (
        None  # set if the study's B/H are of another reference element
    )
    converted_b_over_h_decimal_places: int | None = 12  # to which B/H is rounded; None: not rounded (default scene)

    @classmethod
    def for_variant(cls, study: Study, variant: str) -> "StudyToSceneSizeConversion":
        """Create the conversion of stone sizes from a study to a variant; both scenes are scaled by the same factor."""
        scene = settings_changed_by_variant(study, variant).scene or study.scene
        if scene == study.scene:
            return cls(converted_b_over_h_decimal_places=None if scene == gravestone() else 12)
        own_height, own_ratio = reference_element_height_and_b_over_h(scene)
        factor = own_height / reference_element_height_and_b_over_h(study.scene)[0]
        return cls(
            factor, own_ratio if scene.size_reference_element_name != study.scene.size_reference_element_name else None
        )

    def to_variant_reference_stone_heights(self, study_height_m_by_case: FloatArray) -> FloatArray:
        """Convert heights of the study's stone, m, to those of the stone that sets the size of the variant's scene."""
        return (
            study_height_m_by_case
            if self.scene_over_study_height_ratio == 1.0
            else np.round(study_height_m_by_case * self.scene_over_study_height_ratio, 10)
        )

    def to_variant_reference_stone_b_over_h(
        self, study_b_over_h_by_case: FloatArray, nominal_b_over_h_values_of_study: FloatArray
    ) -> FloatArray:
        """Convert B/H of the study's stone to those of the stone that sets the size of the variant's scene.

        If that stone keeps its own B/H, the result is this B/H times the ratio of the study stone's B/H, which varies
        in ensembles, to the nearest value in `nominal_b_over_h_values_of_study`.
        """
        if self.scene_b_over_h_if_study_reference_differs is not None:
            # The scene keeps its own B/H, multiplied by the deviation of the member from the nominal B/H.
            study_b_over_h_by_case = self.scene_b_over_h_if_study_reference_differs * (
                study_b_over_h_by_case
                / nominal_b_over_h_values_of_study[
                    np.abs(np.log(study_b_over_h_by_case[:, None] / nominal_b_over_h_values_of_study)).argmin(axis=1)
                ]
            )
        return (
            study_b_over_h_by_case
            if self.converted_b_over_h_decimal_places is None
            else np.round(study_b_over_h_by_case, self.converted_b_over_h_decimal_places)
        )


def note_on_different_stone_size_of_variant(study: Study, variant: str) -> str:
    """Return a note if the stone of a study's variant has another height or B/H than that of the study; else ""."""
    sizes = StudyToSceneSizeConversion.for_variant(study, variant)
    own, stone = study.scene.size_reference_element_name, variant_scene(study, variant).size_reference_element_name
    height_ratio, b_over_h = sizes.scene_over_study_height_ratio, sizes.scene_b_over_h_if_study_reference_differs
    said = [] if height_ratio == 1.0 else [f"{height_ratio:.3g} times that height"]
    said += [] if b_over_h is None else [f"a B/H of {b_over_h:.3g} whatever the {own} has"]
    return f"H and B/H are those of the study's {own}; the {stone} has {' and '.join(said)}" if said else ""


def numerical_options_of_study(
    study: Study, thread_count: int = 1, progress: ProgressCallback | None = None, dask_client: "Client | None" = None
) -> NumericalOptions:
    """Return the numerical options of a study: integration scheme, time step, threads and progress callback."""
    given = study.simulation
    return NumericalOptions(
        scheme=given.scheme or DEFAULT_SCHEME,
        time_step=given.time_step,
        leave_out=given.leave_out,
        threads=thread_count,
        progress=progress,
        client=dask_client,
    )


def variant_uses_vertical_motion(study: Study, variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS) -> bool:
    """True if a study or variant applies the vertical ground motion of records that have a vertical component."""
    own = settings_changed_by_variant(study, variant).vertical
    return study.simulation.vertical if own is None else own


def names_of_settings_in_which_variants_differ(study: Study, variant: str, other_variant: str) -> list[str]:
    """Name the settings (scene, contact, vertical motion, site) in which two variants of a study differ."""
    one, other = settings_changed_by_variant(study, variant), settings_changed_by_variant(study, other_variant)
    differing = {
        "scene": (one.scene or study.scene) != (other.scene or study.scene),
        "contact": variant_contact_settings(study, variant) != variant_contact_settings(study, other_variant),
        "vertical": variant_uses_vertical_motion(study, variant) != variant_uses_vertical_motion(study, other_variant),
        "site": one.site != other.site,
    }
    return [name for name, differs in differing.items() if differs]


def record_motion_with_up_only_if_variant_uses_it(
    study: Study, record: Record, variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
) -> Motion:
    """Return the motion of a record, without vertical component if the study or variant does not apply it."""
    return Motion.of(record if variant_uses_vertical_motion(study, variant) else replace(record, up=None))
