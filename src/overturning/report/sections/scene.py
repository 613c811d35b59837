"""The study's scenes: their drawing, how often and which way each element falls, stack against monolith."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from overturning.report.blocks import Figure, Note, Paragraph, Section, Table, number_columns, text_columns
from overturning.report.results import Results, has_scene, reference_cube
from overturning.report.text import number, percent
from overturning.statistics.elements import ElementFalls, StoneComparison, compare_stones, falls_by_element
from overturning.statistics.planes import fall_probability
from overturning.study.config import Study
from overturning.study.scenes import scene_of

if TYPE_CHECKING:
    import xarray as xr


def scene(results: Results) -> Section | None:
    """Drawing, table and comparisons; none for a single block."""
    return scene_section(results.study, results.cubes, results.drawings) if has_scene(results.study) else None


def scene_section(study: Study, cubes: "Mapping[str, xr.Dataset]", folder: Path) -> Section:
    """Drawing, table and comparisons of a study's scenes.

    Parameters
    ----------
    study : Study
        The study.
    cubes : mapping of xarray.Dataset
        Cubes of all elements, of the study itself and of its variants, by name.
    folder : Path
        Where to draw.

    Returns
    -------
    Section
    """
    from overturning.figures.scene import element_roses_figure, scenes_figure
    from overturning.figures.style import save, style

    scenes = {name: one for name in cubes if (one := scene_of(study, name)) is not None}
    stones: dict[str, xr.Dataset] = {}
    rows = []
    for name, cube in cubes.items():
        one, several = scenes[name], "element" in cube.dims
        stones[f"{one.reference_name} of the {one.name} scene" if several else one.name] = reference_cube(
            study, name, cube
        )
        elements = falls_by_element(cube)
        rows += [
            element_row(one.title or one.name, row if several else replace(row, name=one.free[0])) for row in elements
        ]
    first, *others = stones.items()
    sentences = [comparison_sentence(compare_stones(*first, *other)) for other in others]
    sentences += [text for title, cube in stones.items() if (text := spread_sentence(title, cube))]
    with style():
        save(scenes_figure(list(scenes.values())), folder / "scene.svg")
        save(element_roses_figure(stones), folder / "scene-roses.svg")
    return Section(
        "The scene",
        (
            Figure(
                folder / "scene.svg",
                "the scenes, drawn to scale",
                "To scale; crosses are centres of mass, grey moves with the record.",
                width=0.85,
            ),
            *map(Paragraph, sentences),
            Table(
                text_columns("scene", "element")
                + number_columns("cases", "falls", "share", "falls first in", "median time, s"),
                tuple(rows),
            ),
            Note(
                "A fall is a rotation of 90°, or what the scene file sets. Cases without an outcome are not counted. "
                "Elsewhere in this report “the block” is the reference element of the study's own scene."
            ),
            Figure(
                folder / "scene-roses.svg",
                "roses of fall azimuths of each stone",
                "Azimuths towards which each stone falls, over all cases.",
                width=0.85,
            ),
        ),
        anchor="scene",
    )


def element_row(label: str, row: ElementFalls) -> tuple[str, ...]:
    """Cells of one element of a scene."""
    falls = (str(row.cases), str(row.falls), percent(row.share), str(row.first))
    return (label, row.name, *falls, number(row.median_time))


def comparison_sentence(found: StoneComparison) -> str:
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
