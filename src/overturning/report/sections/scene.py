"""The study's scenes: their drawing, how often and which way each element falls, stack against monolith."""

from functools import partial

import numpy as np
import xarray as xr

from overturning.figures.scene import element_roses_figure, scenes_figure
from overturning.labels import element_size_note
from overturning.model.planes import FALLS, fall_probability
from overturning.model.scene import gravestone
from overturning.report.blocks import Figure, Note, Said, section, table
from overturning.report.results import Results
from overturning.report.sections.contrast import contrast_sentences
from overturning.report.text import percent
from overturning.settings import Ensemble
from overturning.statistics.by_record import iterate_records
from overturning.statistics.spread import first_batch_estimate, runs_disagree
from overturning.study.ensemble import BATCH
from overturning.study.scenes import NOMINAL, variant_scene, variant_size_note


@section("The scene", "scene")
def scene(results: Results) -> Said:
    """Drawing, table and comparisons of the study's scenes; none where it is of the default gravestone alone."""
    study = results.study
    if study.scene == gravestone() and not any(variant.scene for variant in study.variants.values()):
        return
    scenes = {name: variant_scene(study, name) for name in results.cubes}
    stones: dict[str, xr.Dataset] = {}
    rows = []
    for name, cube in results.cubes.items():
        one, several = scenes[name], "element" in cube.dims
        again = f", {name}" if name != NOMINAL and one == scenes[NOMINAL] else ""  # a variant of ground or motion
        title = f"{one.default_element} of the {one.name} scene{again}"
        stones[title] = results.reference_cube(name)
        for row in results.element_falls[name]:
            element = row.name if several else one.free_names[0]
            falls = (row.cases, row.falls, row.share, row.first, row.median_time)
            rows.append((f"{one.title or one.name}{again}", element, *falls))
    in_answer = study.primary.against if study.asks == "scene" else None
    drawing = results.drawn("scene", partial(scenes_figure, list(scenes.values())))
    roses = results.drawn("scene-roses", partial(element_roses_figure, stones))
    to_scale = "To scale; crosses are centres of mass, grey moves with the record."
    yield Figure(drawing, "the scenes, drawn to scale", to_scale, width=0.85)
    yield from (" ".join(contrast_sentences(results, name)) for name in study.variants if name != in_answer)
    yield from (spread_sentence(title, cube, study.ensemble) for title, cube in stones.items())
    another = f"; {sizes}" if (sizes := element_size_note(results.reference_cube(NOMINAL))) else ""
    heads = ("scene", "element", "cases", "falls", "share", "falls first in", "median time, s")
    yield table(heads, rows, "ttdd%d2")
    yield Note(
        "A stone has fallen that no longer stands where it stood: turned past the angle from which it could come back, "
        "lower by more than a tenth of its height or what the scene file sets, or without what carried it. Cases "
        "without an outcome are not counted. Elsewhere in this report “the block” is the "
        f"{scenes[NOMINAL].default_element} of the study's own scene{another}."
        f"{''.join(f' Variant {name}: {said}.' for name in study.variants if (said := variant_size_note(study, name)))}"
    )
    towards = f"{results.words.rose} {results.words.which}"
    yield Figure(roses, "roses of fall azimuths of each stone", towards)


def spread_sentence(name: str, cube: xr.Dataset, settings: Ensemble) -> str | None:
    """How probable the fall of the stone of that name is over the neighbourhood of the ensemble; None without one."""
    if "probability_towards" not in cube:
        return None
    total, known, again, differ = 0.0, 0, 0, 0.0
    for one in iterate_records(cube, (*FALLS, "members")):
        chance = fall_probability(one)
        falls, members = (chance["towards"] + chance["away"]).to_numpy(), one["members"].to_numpy()
        total += float(np.nansum(falls, dtype=np.float64))
        known += int(np.isfinite(falls).sum())
        again += int((members > 0).sum())
        differ += float(
            np.nansum(first_batch_estimate(runs_disagree, chance["towards"], chance["away"], members, settings))
        )
    if not again:
        return None
    return (
        f"With amplitude, shape, friction, damping and azimuth spread as the study states, the {name} falls with a "
        f"probability of {percent(total / known if known else np.nan)}, the mean over all cases; of the {again:,} "
        f"cases near a change of outcome some of the first {min(BATCH, settings.members)} runs fall and others stand "
        f"in {percent(differ / again)}."
    )
