"""Scenes: what stands where, of what, and how it touches. The model behind the files in config/scenes/."""

from pathlib import Path
from typing import Annotated, Any, Literal, Self

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from overturning.dem.contact import STATIC_PENETRATION
from overturning.errors import ConfigError
from overturning.units import GRANITE_DENSITY, STANDARD_GRAVITY

MOST_ELEMENTS = 64
"""More would make the columns of the kernel longer than the processor's caches."""

Name = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]*$")]
Positive = Annotated[float, Field(gt=0)]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Material(_Model):
    """What an element is made of."""

    density: Positive = Field(default=GRANITE_DENSITY, description="density, kg/m³")


class ContactLaw(_Model):
    """Springs, dashpots and slider between two materials, at each vertex."""

    between: tuple[Name, Name] = Field(description="the two materials, in any order")
    friction: Annotated[float, Field(ge=0)] | None = Field(
        default=None, description="friction coefficient µ; not given: the one that the study sweeps"
    )
    stiffness: Literal["auto"] | Positive = Field(
        default="auto",
        description="normal spring K_n per vertex and metre of depth, N/m; auto: from the weight carried",
    )
    static_penetration: Positive = Field(
        default=STATIC_PENETRATION,
        description="stiffness auto: static penetration as a share of the width of the contact",
    )
    stiffness_ratio: float = Field(default=1.0, ge=0, description="K_s/K_n")
    damping_ratio: float | None = Field(
        default=None, ge=0, description="damping ratio ξ of heave of what the contact carries; 1 where nothing is given"
    )
    damping: float | None = Field(default=None, ge=0, description="dashpot per vertex and metre of depth, N·s/m")

    @model_validator(mode="after")
    def _one_damping(self) -> Self:
        if self.damping_ratio is not None and self.damping is not None:
            raise ValueError("damping_ratio and damping are both given; keep one")
        return self


class Element(_Model):
    """A rigid convex polygon."""

    name: Name = Field(description="name, unique in the scene")
    kind: Literal["free", "driven", "held"] = Field(
        default="free",
        description="free: moves by itself; driven: moves with the record; held: stays where it is in space",
    )
    material: Name = Field(default="stone", description="material")
    width: Positive | None = Field(default=None, description="width of a rectangle, m")
    height: Positive | None = Field(default=None, description="height of a rectangle, m")
    vertices: tuple[tuple[float, float], ...] | None = Field(
        default=None, description="vertices [x, z] of any other convex polygon, counter-clockwise, m"
    )
    depth: Positive = Field(default=1.0, description="depth across the plane, m")
    stands_on: Name | None = Field(
        default=None, description="element on whose highest level the lowest vertex stands; not given: on z = 0"
    )
    at: tuple[float, float] = Field(
        default=(0.0, 0.0),
        description="shift [x, z], m: of a rectangle's lower side's middle, or of the vertices' origin; "
        "z counts from the level of `stands_on` where that is given",
    )
    rotation_deg: float = Field(default=0.0, description="rotation towards +x before it is placed, degrees")
    fallen_rotation_deg: float = Field(
        default=90.0, gt=0, le=180, description="rotation that counts as overturned, degrees"
    )
    fallen_drop: Positive | None = Field(
        default=None, description="drop of the centre that counts as overturned too, m; not given: rotation only"
    )

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        rectangle = self.width is not None and self.height is not None
        if (self.vertices is None) != rectangle or (self.vertices and (self.width or self.height)):
            raise ValueError(f"element {self.name}: give either width and height, or vertices")
        return self


class Scene(_Model):
    """A scene: elements, materials, contact laws, gravity."""

    name: Name = Field(description="name")
    title: str = Field(default="", description="title in reports")
    gravity: Positive = Field(default=STANDARD_GRAVITY, description="acceleration of gravity, m/s²")
    reference: Name | None = Field(
        default=None,
        description="element whose height and B/H the study sweeps (all lengths scale with its height); "
        "not given: the first free one",
    )
    materials: dict[Name, Material] = Field(default={"stone": Material()}, description="materials by name")
    contacts: tuple[ContactLaw, ...] = Field(
        default=(), description="contact laws; pairs of materials without one have the default law"
    )
    elements: tuple[Element, ...] = Field(min_length=2, max_length=MOST_ELEMENTS, description="the elements")

    @model_validator(mode="after")
    def _names_fit(self) -> Self:
        names = [element.name for element in self.elements]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"element {twice[0]} stands twice; give each element its own name")
        if not any(element.kind == "driven" for element in self.elements):
            raise ValueError(f"no element is driven by the record; set kind: driven for the ground, perhaps {names[0]}")
        if not any(element.kind == "free" for element in self.elements):
            raise ValueError("no element is free; nothing could overturn")
        for index, element in enumerate(self.elements):
            if element.material not in self.materials:
                raise ValueError(
                    f"element {element.name}: no material {element.material!r}; known: {', '.join(self.materials)}"
                )
            if element.stands_on is not None and element.stands_on not in names[:index]:
                raise ValueError(
                    f"element {element.name}: stands_on {element.stands_on!r} is not an element listed before it"
                )
        if self.reference is not None and self.reference not in names:
            raise ValueError(f"reference: no element {self.reference!r}; known: {', '.join(names)}")
        seen = set()
        for law in self.contacts:
            for material in law.between:
                if material not in self.materials:
                    raise ValueError(f"contacts: no material {material!r}; known: {', '.join(self.materials)}")
            if frozenset(law.between) in seen:
                raise ValueError(f"contacts: {' and '.join(law.between)} have two laws; keep one")
            seen.add(frozenset(law.between))
        return self

    @model_validator(mode="after")
    def _can_stand(self) -> Self:
        # Late: the geometry imports the model.
        from overturning.dem.polygon.geometry import check_geometry

        try:
            check_geometry(self)
        except ValueError as error:
            raise ValueError(str(error)) from None
        return self

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free elements, in order."""
        return tuple(element.name for element in self.elements if element.kind == "free")

    @property
    def reference_name(self) -> str:
        """The element whose height and slenderness are swept."""
        return self.reference or self.free[0]

    def element(self, name: str) -> Element:
        """The element of a name."""
        return next(element for element in self.elements if element.name == name)

    def law(self, one: Element, other: Element) -> ContactLaw:
        """The contact law of two elements."""
        materials = frozenset((one.material, other.material))
        for law in self.contacts:
            if frozenset(law.between) == materials:
                return law
        return ContactLaw(between=(one.material, other.material))


SCENES = Path("config") / "scenes"


def load_scene(name: str | Path, root: Path = Path()) -> Scene:
    """Read and check a scene file.

    Parameters
    ----------
    name : str or Path
        A file, or the name of one in config/scenes without ``.yaml``.
    root : Path
        Folder from which paths count.

    Returns
    -------
    Scene

    Raises
    ------
    ConfigError
        If there is no such file, or a key, a value or the geometry is wrong; names file, element and remedy.
    """
    path = root / name
    if path.suffix not in {".yaml", ".yml"}:
        path = root / SCENES / f"{name}.yaml"
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8-sig"))
    except OSError:
        known = ", ".join(sorted(file.stem for file in (root / SCENES).glob("*.yaml"))) or "none"
        raise ConfigError(f"scene {name}: no file {path}; known: {known}") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: not a UTF-8 text; save it as UTF-8") from None
    except yaml.YAMLError as error:
        raise ConfigError(f"{path}: not valid YAML ({getattr(error, 'problem', None) or 'unreadable'})") from None
    if not isinstance(data, dict):
        raise ConfigError(f"{path}: a scene is a mapping of keys to values; see docs/scenes.md")
    return check_scene(data, str(path))


def check_scene(data: dict[str, Any], where: str = "scene") -> Scene:
    """Check the content of a scene file.

    Raises
    ------
    ConfigError
        One line per wrong key; names the element where it is one's.
    """
    try:
        return Scene.model_validate(data)
    except ValidationError as error:
        lines = []
        for item in error.errors():
            key = ".".join(_part(data, item["loc"], depth) for depth in range(len(item["loc"])))
            message = item["msg"].removeprefix("Value error, ")
            message = {"extra_forbidden": "unknown key", "missing": "this key is needed"}.get(item["type"], message)
            lines.append(f"{where}: {key}: {message}" if key else f"{where}: {message}")
        raise ConfigError("\n       ".join(dict.fromkeys(lines))) from None


def _part(data: Any, location: tuple[int | str, ...], depth: int) -> str:
    # An element is better known by its name than by its number.
    if depth == 1 and location[0] == "elements" and isinstance(location[1], int):
        element = data["elements"][location[1]]
        if isinstance(element, dict) and "name" in element:
            return str(element["name"])
    return str(location[depth])
