"""Drawings of scenes, and roses of the fall azimuths of their elements."""

from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from overturning.figures.rose import common_rose_radius_as_root_of_share, draw_fall_rose
from overturning.figures.style import INK, PAGE_WIDTH_INCHES, SERIES_COLOURS, create_panel_grid
from overturning.model.geometry import scale_and_place_elements
from overturning.model.scene import Scene
from overturning.statistics.roses import fall_rose_from_fault_normal_if_known

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


_MAX_TITLE_LINE_CHARACTERS: Final = 32
"""Line length of the title above a panel, in characters."""


def draw_scene(
    axes: Any,
    scene: Scene,
    reference_element_height: float | None = None,
    reference_element_b_over_h: float | None = None,
) -> None:
    """Draw a 2-D scene to scale; elements that move with the ground are grey, fixed elements hatched."""
    placed = scale_and_place_elements(scene, reference_element_height, reference_element_b_over_h)
    free = [item for item in placed if not item.has_prescribed_motion]
    low = min(float(item.vertices_in_scene[:, 1].min()) for item in free)
    high = max(float(item.vertices_in_scene[:, 1].max()) for item in free)
    reach = max(float(np.abs(item.vertices_in_scene[:, 0]).max()) for item in free) + 0.35 * (high - low)
    for item in placed:
        axes.fill(
            *item.vertices_in_scene.T, facecolor="#d9d9d6" if item.has_prescribed_motion else "#f4ead9", edgecolor=INK,
            linewidth=0.8,
            hatch="//" if item.element.kind == "held" else None,
        )  # fmt: skip
        if not item.has_prescribed_motion:
            axes.plot(item.centre_of_mass_x, item.centre_of_mass_z, marker="+", color=SERIES_COLOURS[0], markersize=5)
            axes.annotate(
                item.element.name, (float(item.vertices_in_scene[:, 0].max()), item.centre_of_mass_z), (4, 0),
                textcoords="offset points",
                va="center", fontsize=7.5,
            )  # fmt: skip
    axes.set(xlim=(-reach, reach), ylim=(low - 0.12 * (high - low), high + 0.06 * (high - low)), aspect="equal")
    axes.set(xlabel="m", yticks=[])
    axes.spines["left"].set_visible(False)
    axes.set_title(_scene_name_and_title(scene), parse_math=False)


def _scene_name_and_title(scene: Scene) -> str:
    """Return the name of a scene, with its title on the following lines."""
    return (
        scene.name
        if scene.title in ("", scene.name)
        else f"{scene.name}\n{fill(scene.title, _MAX_TITLE_LINE_CHARACTERS)}"
    )


def draw_scenes_side_by_side(scenes: Sequence[Scene]) -> "Figure":
    """Draw one or more scenes side by side, all to the same scale."""
    lines = max(_scene_name_and_title(scene).count("\n") for scene in scenes)
    figure, panels = create_panel_grid(1, len(scenes), 2.7 * len(scenes), 3.4 + 0.2 * lines)
    for axes, scene in zip(panels[0], scenes, strict=True):
        draw_scene(axes, scene)
    lows, highs = zip(*(axes.get_ylim() for axes in panels[0]), strict=True)
    reach = max(axes.get_xlim()[1] for axes in panels[0])
    for axes in panels[0]:
        axes.set(xlim=(-reach, reach), ylim=(min(lows), max(highs)))
    return figure


def fall_roses_by_element_figure(cube_by_element_name: Mapping[str, "xr.Dataset"]) -> "Figure":
    """Draw one rose of fall directions per element (stone) of a scene, from all records together."""
    columns = min(len(cube_by_element_name), 3)
    rows = -(-len(cube_by_element_name) // columns)
    figure, panels = create_panel_grid(
        rows,
        columns,
        max(PAGE_WIDTH_INCHES / 3 * columns, 3.3),
        2.4 * rows,
        len(cube_by_element_name),
        polar=True,
    )
    roses = {name: fall_rose_from_fault_normal_if_known(cube) for name, cube in cube_by_element_name.items()}
    top = common_rose_radius_as_root_of_share(*roses.values())
    for axes, (name, rose) in zip(panels.ravel(), roses.items(), strict=False):
        draw_fall_rose(axes, rose, top)
        axes.set_title(f"{name}\n{rose.earthquake_count_title}", pad=12, fontsize=9, parse_math=False)
    return figure
