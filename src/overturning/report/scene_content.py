"""What the report says of a scene: its drawing, how often and which way each element falls, stack against monolith."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.dem.scene import gravestone
from overturning.report.sentences import percent
from overturning.statistics.elements import StoneComparison, compare_stones, falls_by_element
from overturning.statistics.planes import fall_probability
from overturning.study.config import Study
from overturning.study.scenes import NOMINAL, scene_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def sentence(found: StoneComparison) -> str:
    """One comparison as a sentence."""
    text = (
        f"Of {found.cases} cases the {found.name} falls in {found.both + found.only_this} and the {found.other} in "
        f"{found.both + found.only_other}; in {found.only_this} only the {found.name} falls, in {found.only_other} only "
        f"the {found.other}."
    )
    if found.both:
        text += (
            f" Where both fall ({found.both}), they go to the same side in {percent(found.same_side / found.both)}, and the "
            f"{found.name} falls first in {percent(found.earlier / found.both)}."
        )
    elif found.only_this and not found.only_other:
        text += f" So the {found.name} falls first in every case in which anything falls."
    return text


def spread_sentence(name: str, cube: "xr.Dataset") -> str | None:
    """How probable the fall of one stone is over the neighbourhood of the ensemble; None where none was run.

    Parameters
    ----------
    name : str
        What to call it.
    cube : xarray.Dataset
        Cube of one element.
    """
    if "probability_towards" not in cube or not (cube["members"] > 0).any():
        return None
    chance = fall_probability(cube)
    falls = (chance["towards"] + chance["away"]).to_numpy()
    again = cube["members"].to_numpy() > 0
    divided = again & (falls > 0) & (falls < 1)
    return (
        f"With amplitude, shape, friction, damping and azimuth spread as the study states, the {name} falls with a probability of "
        f"{percent(float(np.nanmean(falls)))}, the mean over all cases; of the {int(again.sum())} cases near a change of outcome "
        f"some runs fall and others stand in {int(divided.sum())}."
    )


def scene_content(study: Study, results: Path) -> dict[str, Any] | None:
    """Drawing, table and comparisons of a study's scenes.

    Parameters
    ----------
    study : Study
        The study.
    results : Path
        Folder of its results, with a cube for each variant.

    Returns
    -------
    dict or None
        None for a study of a single block without a scene. ``drawing`` and ``roses`` are SVG elements; ``elements`` are
        rows of `ElementFalls` by scene, ``comparisons`` sentences.
    """
    if study.scene == gravestone() and not any(variant.scene for variant in study.variants.values()):
        return None
    from overturning.figures.scene import element_roses_figure, scenes_figure
    from overturning.figures.style import style
    from overturning.study.cube import open_cube

    names = [NOMINAL, *study.variants]
    scenes = {name: scene_of(study, name) for name in names}
    cubes = {
        name: open_cube(results / ("cube.nc" if name == NOMINAL else f"cube.{name}.nc"), element=None) for name in names
    }
    try:
        stones: dict[str, xr.Dataset] = {}
        tables = []
        for name, cube in cubes.items():
            label = scenes[name].title or scenes[name].name
            rows = falls_by_element(cube)
            if "element" not in cube.dims:
                rows = [type(row)(scenes[name].free[0], *list(vars(row).values())[1:]) for row in rows]
            tables += [(label, row) for row in rows]
        for name, cube in cubes.items():
            several = "element" in cube.dims
            reference = scenes[name].reference_name
            title = f"{reference} of the {scenes[name].name} scene" if several else scenes[name].name
            stones[title] = cube.sel(element=reference) if several else cube
        first, *others = stones.items()
        comparisons = [sentence(compare_stones(*first, *other)) for other in others]
        comparisons += [said for title, cube in stones.items() if (said := spread_sentence(title, cube))]
        with style():
            drawing = _svg(scenes_figure(list(scenes.values())), "scene-drawing")
            roses = _svg(element_roses_figure(stones), "scene-roses")
    finally:
        for cube in cubes.values():
            cube.close()
    return {"drawing": drawing, "roses": roses, "elements": tables, "comparisons": comparisons}


def _svg(figure: "Figure", name: str) -> str:
    from overturning.figures.style import save
    from overturning.report.page import inline_svg

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "figure" / f"{name}.svg"
        save(figure, path)
        return inline_svg(path)
