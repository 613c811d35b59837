"""Scene files (config/scenes/): elements, their positions, materials and contact laws."""

from functools import lru_cache, partial
from itertools import combinations
from pathlib import Path
from typing import Any, Final, Self

import numpy as np
from pydantic import Field, ValidationError, model_validator

from overturning.arrays import convert_argument_to_float_array
from overturning.errors import ArgumentError, ConfigError
from overturning.files import path_in_working_folder_or_package, read_yaml_mapping
from overturning.model.contact import Contact
from overturning.model.element import ContactLaw, Element, LowercaseHyphenName, Material, PositiveNumber
from overturning.model.geometry import (
    MIN_GROUND_WIDTH_FOR_SINGLE_BLOCK_KERNEL_M,
    MIN_GROUND_WIDTH_TO_LARGEST_ELEMENT_RATIO,
)
from overturning.model.support import check_elements_have_support_without_overlap
from overturning.units import DEFAULT_STONE_DENSITY_KG_M3, STANDARD_GRAVITY
from overturning.validation import StrictModel, describe_invalid_keys, make_constructor_raise_argument_errors

MAX_SCENE_ELEMENTS: Final = 64
"""Largest number of elements; with more, the arrays of the kernel exceed the processor's caches."""


@make_constructor_raise_argument_errors
class Scene(StrictModel):
    """Scene of rigid polygons (elements) with materials, contact laws and gravity."""

    name: LowercaseHyphenName = Field(description="name")
    title: str = Field(default="", description="title in reports")
    gravity: PositiveNumber = Field(default=STANDARD_GRAVITY, description="acceleration of gravity, m/s²")
    reference: LowercaseHyphenName | None = Field(
        default=None,
        description="element whose height and B/H the study sweeps (all lengths scale with its height); "
        "not given: the first free one",
    )
    materials: dict[LowercaseHyphenName, Material] = Field(
        default={"stone": Material()}, description="materials by name"
    )
    contacts: tuple[ContactLaw, ...] = Field(
        default=(), description="contact laws; pairs of materials without one have the default law"
    )
    elements: tuple[Element, ...] = Field(min_length=2, max_length=MAX_SCENE_ELEMENTS, description="the elements")

    @model_validator(mode="after")
    def _check_unique_known_names_and_element_kinds(self) -> Self:
        """Raise a ValueError if names are repeated or unknown, or if the scene has no driven or no free element."""
        names = [element.name for element in self.elements]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"element {twice[0]} is listed twice; give each element its own name")
        kinds = {element.kind for element in self.elements}
        if "driven" not in kinds:
            raise ValueError(f"no element is driven by the record; set kind: driven for the ground, perhaps {names[0]}")
        if "free" not in kinds:
            raise ValueError("no element is free; nothing could overturn")
        for index, element in enumerate(self.elements):
            of, below = f"element {element.name}", element.stands_on
            if element.material not in self.materials:
                raise ValueError(f"{of}: no material {element.material!r}; known: {', '.join(self.materials)}")
            if below is not None and below not in names[:index]:
                raise ValueError(f"{of}: stands_on {below!r} is not an element listed before it")
        if self.reference is not None and self.reference not in names:
            raise ValueError(f"reference: no element {self.reference!r}; known: {', '.join(names)}")
        for index, law in enumerate(self.contacts):
            for material in law.between:
                if material not in self.materials:
                    raise ValueError(f"contacts: no material {material!r}; known: {', '.join(self.materials)}")
            if any(set(law.between) == set(other.between) for other in self.contacts[:index]):
                raise ValueError(f"contacts: {' and '.join(law.between)} have two laws; keep one")
        return self

    @model_validator(mode="after")
    def _check_elements_supported_and_reference_not_ground(self) -> Self:
        """Raise an error if elements overlap or lack support, or if a single block has its ground as reference."""
        check_elements_have_support_without_overlap(self)
        # The single-block kernel applies the height and B/H of each case to the block.
        if self.can_use_single_block_kernel and self.size_reference_element_name not in self.free_element_names:
            raise ValueError(
                f"reference: {self.size_reference_element_name} is the ground of a single block; leave it out, or name "
                f"{self.free_element_names[0]}"
            )
        return self

    @property
    def free_element_names(self) -> tuple[str, ...]:
        """Names of the elements of the scene that forces can move, in order."""
        return tuple(element.name for element in self.elements if element.kind == "free")

    @property
    def size_reference_element_name(self) -> str:
        """Name of the reference element: the element whose height and B/H are varied in a study."""
        return self.reference or self.free_element_names[0]

    @property
    def name_of_element_shown_by_default(self) -> str:
        """Name of the element to show if only one is shown: the reference element if free, else the last free one."""
        return (
            self.size_reference_element_name
            if self.size_reference_element_name in self.free_element_names
            else self.free_element_names[-1]
        )

    @property
    def has_contact_with_unset_friction(self) -> bool:
        """True if the scene file leaves the friction of at least one contact open, so that a study can vary it."""
        pairs = combinations(self.elements, 2)
        return any(self.contact_law(a, b).friction is None for a, b in pairs if "free" in (a.kind, b.kind))

    @property
    def can_use_single_block_kernel(self) -> bool:
        """True if the faster kernel can simulate the scene: one upright rectangle on wide driven ground.

        A stiffness or dashpot given per metre of depth acts over the smaller depth of the two elements. The faster
        kernel uses the depth of the block; this must then not exceed that of the ground.
        """
        if len(self.elements) != 2 or self.gravity != STANDARD_GRAVITY:
            return False
        ground, block = self.elements
        law = self.contact_law(ground, block)
        per_depth = law.stiffness != "auto" or law.damping is not None
        return (
            ground.kind == "driven"
            and block.kind == "free"
            and ground.width is not None
            and block.width is not None
            and ground.rotation_deg == block.rotation_deg == 0
            and block.fallen_rotation_deg in (None, 90)
            and block.fallen_drop is None
            and block.at[0] == (0.0 if block.stands_on else ground.at[0])
            and (block.depth <= ground.depth or not per_depth)
            and ground.width
            > max(
                MIN_GROUND_WIDTH_FOR_SINGLE_BLOCK_KERNEL_M,
                MIN_GROUND_WIDTH_TO_LARGEST_ELEMENT_RATIO * max(block.width, block.height or 0.0),
            )
        )

    def element(self, name: str) -> Element:
        """Return the element of the scene with the given name."""
        return next(element for element in self.elements if element.name == name)

    def contact_law(self, element: Element, other_element: Element) -> ContactLaw:
        """Return the contact law between two elements, by their materials."""
        return self.contact_law_of_materials(element.material, other_element.material)

    def contact_law_of_materials(
        self, material: LowercaseHyphenName, other_material: LowercaseHyphenName
    ) -> ContactLaw:
        """Return the contact law of two materials; the default law if the scene has none for them."""
        laws = (law for law in self.contacts if set(law.between) == {material, other_material})
        return next(laws, ContactLaw(between=(material, other_material)))


def gravestone(contact: Contact | None = None, density: float = DEFAULT_STONE_DENSITY_KG_M3) -> Scene:
    """Return the default scene: one rectangular stone, 0.24 m × 0.6 m, on a wide driven ground.

    Parameters
    ----------
    contact : Contact, optional
        Contact law of the stone's corners; `Contact()` if not given.
    density : float
        Density, kg/m³.

    Raises
    ------
    ArgumentError
        If the density is not finite and above 0, or the contact is that of a 3-D body.
    """
    if contact is not None and not isinstance(contact, Contact):
        raise ArgumentError(f"contact: {contact!r}; a 2-D stone has a Contact")
    number = convert_argument_to_float_array("density", density)
    if isinstance(density, bool) or number.ndim or not (np.isfinite(number) and number > 0):
        raise ArgumentError(f"density: {density}; it must be finite and above 0 kg/m³")
    return _gravestone_from_checked_values(contact, float(number))


@lru_cache(maxsize=64)
def _gravestone_from_checked_values(contact: Contact | None, density: float) -> Scene:
    """Return the default scene with a contact law and a density, kg/m³, that have been checked."""
    laws = () if contact is None else (ContactLaw(between=("stone", "stone"), **contact.model_dump()),)
    return Scene(
        name="gravestone",
        title="A gravestone on its base",
        reference="stone",
        materials={"stone": Material(density=density)},
        contacts=laws,
        elements=(
            Element(name="ground", kind="driven", width=40.0, height=1.0, at=(0.0, -1.0)),
            Element(name="stone", width=0.24, height=0.6, stands_on="ground"),
        ),
    )


SCENE_FOLDER = Path("config") / "scenes"


def load_scene(name: str | Path, root: str | Path = Path()) -> Scene:
    """Return the checked scene of a file, given by its path or by its name in config/scenes.

    Parameters
    ----------
    name : str or Path
        Path of a scene file, or its name in config/scenes without ``.yaml``.
    root : str or Path
        Folder to which paths are relative.

    Returns
    -------
    Scene
        Scene for `overturning.simulate` and `overturning.trajectory`.

    Raises
    ------
    ConfigError
        If the file does not exist, or a key, a value or the geometry is wrong.
    """
    if not isinstance(name, str | Path):
        raise ConfigError(f"scene: a {type(name).__name__}; give the path or name of a file, or make a Scene(…)")
    root = Path(root)
    path = root / name
    if path.suffix not in {".yaml", ".yml"}:
        path = path_in_working_folder_or_package(root / SCENE_FOLDER / f"{name}.yaml")
    if not path.is_file():
        folders = {root / SCENE_FOLDER, path_in_working_folder_or_package(SCENE_FOLDER)}
        known = ", ".join(sorted({file.stem for folder in folders for file in folder.glob("*.yaml")})) or "none"
        raise ConfigError(f"scene {name}: no file {path}; known: {known}")
    return parse_scene_content(read_yaml_mapping(path, "scene", "see docs/scenes.md"), str(path))


def parse_scene_content(scene_file_content: dict[str, Any], file_name_in_messages: str = "scene") -> Scene:
    """Return the scene described by a scene file's content; an error message has one line per wrong key."""
    try:
        return Scene.model_validate(scene_file_content)
    except ValidationError as error:
        lines = describe_invalid_keys(error, Scene, partial(_key_path_with_element_name, scene_file_content))
        raise ConfigError("\n       ".join(f"{file_name_in_messages}: {line}" for line in lines)) from None


def _key_path_with_element_name(scene_file_content: Any, key_path: list[int | str]) -> list[int | str]:
    """Replace the index of an element by its name in the path of a wrong key in a scene file, for an error message."""
    if len(key_path) > 1 and key_path[0] == "elements" and isinstance(key_path[1], int):
        element = scene_file_content["elements"][key_path[1]]
        if isinstance(element, dict) and "name" in element:
            return [key_path[0], str(element["name"]), *key_path[2:]]
    return key_path
