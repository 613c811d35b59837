"""Common base class of the 2-D and the 3-D model of a scene: names of elements, sizes, attributes of a dataset."""

from typing import TYPE_CHECKING

from typing_extensions import override

from overturning.arrays import ArrayLike
from overturning.errors import ArgumentError
from overturning.model.cases import MAX_STONE_HEIGHT_M, MIN_STONE_HEIGHT_M
from overturning.model.geometry import rounded_reference_height_and_b_over_h
from overturning.model.model import Model

if TYPE_CHECKING:
    from overturning.model.scene import Scene


class SceneModel(Model):
    """Abstract base class of the models, 2-D and 3-D, that simulate a scene of several elements.

    Attributes
    ----------
    scene : Scene
        Scene with its elements.
    """

    scene: "Scene"

    @property
    @override
    def free_element_names(self) -> tuple[str, ...]:
        return self.scene.free_element_names

    @property
    @override
    def identifying_dataset_attributes(self) -> dict[str, str]:
        return {"scene": self.scene.name}

    @override
    def height_and_b_over_h_or_defaults(
        self, height: ArrayLike | None, b_over_h: ArrayLike | None
    ) -> tuple[ArrayLike, ArrayLike]:
        """Return heights (m) and B/H of the cases; None is replaced by the size of the scene's reference element."""
        own_height, own_ratio = rounded_reference_height_and_b_over_h(self.scene)
        if height is None and not MIN_STONE_HEIGHT_M <= own_height <= MAX_STONE_HEIGHT_M:
            raise ArgumentError(
                f"height: element {self.scene.size_reference_element_name} of scene {self.scene.name} is "
                f"{own_height:g} m high; a stone is {MIN_STONE_HEIGHT_M:g} to {MAX_STONE_HEIGHT_M:g} m high: "
                "name another element with reference: in the scene, or give the height"
            )
        return own_height if height is None else height, own_ratio if b_over_h is None else b_over_h
