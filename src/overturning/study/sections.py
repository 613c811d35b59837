"""Sections of a study file for the simulation: records, contact, simulation, ensemble, check, body."""

from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self

import numpy as np
from pydantic import (
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)

from overturning.errors import ArgumentError, OverturningError
from overturning.model.contact import ContactSettings
from overturning.model.scene import Scene, load_scene
from overturning.quantities import Degree, Metre, Second, parse_quantity
from overturning.records.site import SoilSite
from overturning.study.values import ValueListOrRange
from overturning.validation import StrictModel

if TYPE_CHECKING:
    from overturning.model.scan import ScanResult
    from overturning.model.shapes import Shape

StudyOrVariantName = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,99}$")]
"""Name of a study or variant: names of files begin with it, and file systems allow a name of 255 bytes."""

PulseName = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,99}$")]


class RecordSettings(StrictModel):
    """Records that a study uses, the table that describes them, and the folder of their files."""

    table: str = Field(
        default="config/records.tsv", description="record table, tab-separated; path from the project's folder"
    )
    folder: str = Field(default="resources/records", description="folder of the record files that the user provides")
    use: tuple[str, ...] = Field(
        default=(),
        min_length=1,
        validate_default=True,
        description="ids of the records in the table, in the order of the cube; required unless there are `pulses`",
    )
    pulses: dict[PulseName, str] = Field(
        default={},
        description="synthetic records by id, one line each: `sine amplitude_gal=300 period_s=1 azimuth_deg=60`",
    )

    @model_validator(mode="before")
    @classmethod
    def _add_all_pulse_ids_to_used_records(cls, unvalidated_record_settings: Any) -> Any:
        """Add all synthetic pulses to the list of records that the study uses."""
        if (
            isinstance(unvalidated_record_settings, dict)
            and isinstance(unvalidated_record_settings.get("pulses"), dict)
            and unvalidated_record_settings["pulses"]
        ):
            use = list(unvalidated_record_settings.get("use") or ())
            return unvalidated_record_settings | {
                "use": [*use, *(name for name in unvalidated_record_settings["pulses"] if name not in use)]
            }
        return unvalidated_record_settings

    @field_validator("use")
    @classmethod
    def _check_unique_ids(cls, record_ids: tuple[str, ...]) -> tuple[str, ...]:
        """Raise a ValueError if a record id occurs twice in the list of records."""
        twice = sorted({name for name in record_ids if record_ids.count(name) > 1})
        if twice:
            raise ValueError(f"{', '.join(twice)} stands twice; name each record once")
        return record_ids


class SimulationSettings(StrictModel):
    """Numerical settings of a study: scheme, time step, vertical motion, omission of samples that move no block."""

    scheme: str | None = Field(default=None, description="integration scheme; not given: the default of the kernel")
    time_step: Literal["auto"] | Second = Field(
        default="auto",
        description="largest time step, s; auto: a share of the stable one (docs/method.md)",
    )
    vertical: bool = Field(default=True, description="apply the vertical motion of the records that have one")
    leave_out: bool = Field(
        default=True,
        description="omit samples that do not change the motion of a rigid block; few flags change",
    )

    @field_validator("time_step")
    @classmethod
    def _check_time_step_is_positive(cls, time_step_s_or_auto: float | str) -> float | str:
        """Raise a ValueError if the time step is not positive."""
        if isinstance(time_step_s_or_auto, float) and time_step_s_or_auto <= 0:
            raise ValueError("the time step must be above 0 s, or auto")
        return time_step_s_or_auto


def load_scene_if_name_or_path(scene_name_or_path_or_scene: Any) -> Any:
    """Load a scene from its name or file path; any other value is returned unchanged."""
    # A name or path is read at once, so that a filled-in study holds the whole scene.
    return (
        load_scene(scene_name_or_path_or_scene)
        if isinstance(scene_name_or_path_or_scene, str)
        else scene_name_or_path_or_scene
    )


SceneChoice = Annotated[Scene, BeforeValidator(load_scene_if_name_or_path, json_schema_input_type=str | Scene)]


class Variant(StrictModel):
    """Settings of a variant, the study repeated with another contact, scene, soil, or use of vertical motion."""

    scene: SceneChoice | None = Field(
        default=None,
        description="scene of this variant, scaled like the study's; B/H applies if its reference element has the "
        "same name",
    )
    contact: ContactSettings | None = Field(
        default=None, description="contact of this variant; keys that it does not give are those of the study"
    )
    site: SoilSite | None = Field(
        default=None,
        description="soil layers of this variant, through which the records are propagated",
    )
    vertical: bool | None = Field(
        default=None,
        description="apply the vertical motion of the records in this variant; not given: as in the study",
    )


class ConvergenceCheckSettings(StrictModel):
    """Settings of the convergence check, which computes a random sample of cases again more exactly."""

    share: float = Field(
        default=0.02,
        gt=0,
        le=1,
        description="share of the cases of the study that is repeated; `verification: none`: no check",
    )
    at_least: int = Field(
        default=200,
        ge=1,
        description="smallest number of repeated cases; a smaller study is repeated completely",
    )
    cost: float = Field(
        default=1.0,
        gt=0,
        description="limit of the block steps of both repetitions, as a share of those of the study",
    )
    seed: int = Field(default=1, ge=0, description="seed of the random choice of cases")


_SCAN_KEYS: Final = ("mesh_unit", "relief", "scan")
"""Keys of a scanned body, stored only if they are given, so that other studies keep their text and hash."""

AspectRatioDOverB = Annotated[float, Field(gt=0, le=10)]
PolygonSideCount = Annotated[int, Field(ge=3, le=96)]


class PropertiesFromScanMesh(StrictModel):
    """Properties of a scanned stone, filled in from its mesh."""

    volume: float = Field(gt=0, description="volume, m³")
    tilt: Degree = Field(ge=0, le=180, description="tilt of the scan's own vertical in the stable pose, degrees")
    centre_of_mass: tuple[Metre, Metre, Metre] = Field(description="centre of mass of the volume, m")
    inertia: tuple[float, float, float, float, float, float] = Field(
        description="moments of inertia xx, yy, zz and products xy, xz, yz about the centre per mass, m²"
    )


def read_scan_of_body(unvalidated_body_settings: Mapping[str, Any]) -> "ScanResult":
    """Read a scanned stone from the mesh file that a study's body settings name.

    The keys used are ``mesh`` (the file), ``mesh_unit`` and ``relief``: the height above the lowest point of the base
    up to which points of the base rest on the ground. An `OverturningError` is raised if the file is unsuitable.
    """
    from overturning.model.mesh import read_scanned_stone

    unit, relief = unvalidated_body_settings.get("mesh_unit"), unvalidated_body_settings.get("relief")
    return read_scanned_stone(
        str(unvalidated_body_settings["mesh"]), unit, None if relief is None else parse_quantity(relief, "m")
    )


class BodyShapeSettings(StrictModel):
    """Shape of a study's 3-D body: plan and aspect D/B of a prism, vertices of a polyhedron, or a scanned stone."""

    plan: Literal["rectangle", "circle"] | PolygonSideCount = Field(
        default="rectangle",
        description=(
            "base of a right prism: `rectangle`, `circle`, or the number of sides of a regular one; with many sides a "
            "prism that slides takes far more time than a `circle`"
        ),
    )
    aspect: ValueListOrRange[AspectRatioDOverB] = Field(
        default=(1.0,),
        description="D/B of a rectangle, width across the orientation over width along it: a list, or a range",
    )
    vertices: tuple[tuple[Metre, Metre, Metre], ...] | None = Field(
        default=None,
        description="instead of a prism: vertices of a convex body that stands on its lowest face (x, y, z up; m)",
    )

    mesh: str | None = Field(
        default=None,
        description="instead of vertices: scan of a stone (closed mesh; OBJ, PLY or STL; z up), which need not be "
        "convex; path from the project's folder. It is placed in its nearest stable pose",
    )
    mesh_unit: Literal["m", "cm", "mm"] | None = Field(
        default=None, description="unit of the mesh; not given: metres, if the size of the stone is plausible"
    )
    relief: Metre | None = Field(
        default=None,
        ge=0,
        le=0.03,
        description="only with a mesh: height above its lowest point up to which the points of the base bear, m; not "
        "given: 0.002, or a convex mesh on one of its faces",
    )
    scan: PropertiesFromScanMesh | None = Field(
        default=None, description="filled in from the mesh: properties of the stone, whose `vertices` can touch"
    )

    @model_validator(mode="before")
    @classmethod
    def _replace_mesh_file_by_its_vertices(cls, unvalidated_body_settings: Any) -> Any:
        """Replace the mesh file in the settings of a body by the vertices and properties that are read from it."""
        # A mesh is read at once, so that a filled-in study holds the whole body.
        if not isinstance(unvalidated_body_settings, dict) or unvalidated_body_settings.get("mesh") is None:
            return unvalidated_body_settings
        if unvalidated_body_settings.get("vertices") is not None:
            raise ValueError("vertices and mesh are both given; keep one")
        from overturning.model.scan import ScannedStone

        if unvalidated_body_settings.get("mesh_unit") not in (None, "m", "cm", "mm"):
            return unvalidated_body_settings  # the field says what is wrong
        try:
            read = read_scan_of_body(unvalidated_body_settings)
        except OverturningError as error:
            raise ValueError(f"mesh: {error}") from None
        filled = {key: value for key, value in unvalidated_body_settings.items() if key not in ("mesh", "mesh_unit")}
        shape: Any = read.shape
        filled["vertices"] = np.asarray(shape.vertices).tolist()
        if isinstance(shape, ScannedStone):
            filled["relief"] = shape.max_load_bearing_base_point_height_m
            filled["scan"] = {
                "volume": round(read.volume_m3, 9),
                "tilt": round(read.rotation_to_stable_pose.scan_tilt_from_stable_pose_deg, 3),
                "centre_of_mass": np.asarray(shape.centre_of_mass).tolist(),
                "inertia": np.asarray(shape.inertia_moments_and_products_per_mass).tolist(),
            }
        return filled

    @model_serializer(mode="wrap")
    def _leave_out_empty_scan_keys(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Return the settings as a dictionary, without the keys for scanned stones if the body is not a scan."""
        content: dict[str, Any] = handler(self)
        return {key: value for key, value in content.items() if value is not None or key not in _SCAN_KEYS}

    @model_validator(mode="after")
    def _check_shape(self) -> Self:
        """Raise a ValueError if the body's shape is invalid or incompatible with the other settings of the body."""
        try:
            shape = self.body_shape()
        except ArgumentError as error:
            raise ValueError(str(error).removeprefix("body: ")) from None
        if self.vertices is not None and self.plan != "rectangle":
            raise ValueError(f"plan {self.plan}: the body has vertices of its own; keep one of them")
        if (self.relief is None) != (self.scan is None):
            raise ValueError("relief: only a mesh that is not a convex polyhedron on its face has one; leave it out")
        if not shape.depth_over_width_is_parameter and self.aspect != (1.0,):
            raise ValueError(f"aspect {list(self.aspect)}: only a rectangle has one; leave it out")
        return self

    def body_shape(self) -> "Shape":
        """Return the shape of the 3-D body; raise an `ArgumentError` if it is invalid."""
        # Imported lazily: 2-D studies do not need it.
        from overturning.model.shapes import Polyhedron, shape_from_name_or_sides

        if self.scan is not None and self.vertices is not None and self.relief is not None:
            return _create_scanned_stone(self.vertices, self.scan, self.relief)
        return shape_from_name_or_sides(self.plan if self.vertices is None else Polyhedron(self.vertices))


@lru_cache(maxsize=4)
def _create_scanned_stone(
    vertices_xyz_m: tuple[tuple[float, float, float], ...],
    scan_properties: PropertiesFromScanMesh,
    max_height_of_bearing_base_points_m: float,
) -> "Shape":
    """Create the body of a scanned stone; cached, because computing its outlines takes a second."""
    from overturning.model.scan import ScannedStone

    return ScannedStone(
        vertices_xyz_m, scan_properties.centre_of_mass, scan_properties.inertia, max_height_of_bearing_base_points_m
    )


class OrientationRange(StrictModel):
    """Orientations of a body or stack, from start by step, over the smallest rotation after which it looks the same."""

    start: Degree = Field(
        default=0.0, ge=0, lt=360, description="first azimuth that the body faces, degrees clockwise from north"
    )
    step: Degree = Field(
        default=5.0,
        gt=0,
        le=360,
        description="step of the orientations, degrees; must divide the rotation after which the body looks the same "
        "(a square 90°, a rectangle 180°)",
    )

    def orientations_of_stack(self, scene: Scene) -> tuple[float, ...]:
        """Return the orientations of a stack to simulate, degrees, within the rotation that maps it onto itself.

        They are in ascending order. A ValueError is raised as by `orientations_of_body`.
        """
        from overturning.model.stack import Stack

        try:
            period = Stack(scene).rotational_symmetry_period_deg
        except ArgumentError as error:
            raise ValueError(str(error).replace("orientation_deg:", "orientation:", 1)) from None
        count = round(period / self.step)
        if count < 1 or abs(count * self.step - period) > 1e-9:
            raise ValueError(
                f"orientation: a step of {self.step:g}° does not divide {period:g}°, after which the stack looks the "
                "same; choose one that does"
            )
        self._check_start_below_step()
        return tuple(round(self.start + self.step * number, 10) for number in range(count))

    def _check_start_below_step(self) -> None:
        """Raise a ValueError if the first orientation is not below the step."""
        if self.start >= self.step:
            raise ValueError(f"orientation.start: {self.start:g}°; it must lie below the step, {self.step:g}°")

    def orientations_of_body(self, body: BodyShapeSettings) -> tuple[float, ...]:
        """Return the orientations of a body to simulate, degrees, within the rotation that maps it onto itself.

        A ValueError is raised if the step does not divide this rotation for every aspect D/B of the body, or if the
        start does not lie below the step.
        """
        from overturning.model.shapes import orientations_over_symmetry_period_deg

        shape = body.body_shape()
        try:
            # The step must fit the symmetry of each aspect.
            for aspect in body.aspect:
                orientations_over_symmetry_period_deg(self.step, shape, aspect)
            grid = orientations_over_symmetry_period_deg(self.step, shape, body.aspect)
        except ArgumentError as error:
            raise ValueError(str(error)) from None
        self._check_start_below_step()
        return tuple(round(self.start + value, 10) for value in grid.tolist())
