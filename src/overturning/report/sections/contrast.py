"""A variant beside the study, case by case: with and without vertical motion, on rock and soil, stack and monolith."""

from functools import partial
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.figures.alignment import estimate_to_draw
from overturning.figures.answer import DrawnEstimate, contrast_figure
from overturning.findings.contrast import compared_records, differing_settings
from overturning.report.blocks import Figure
from overturning.report.results import Results
from overturning.report.text import counted, decimals, share
from overturning.statistics.bootstrap import Mean, mean_over_earthquakes, share_over_earthquakes
from overturning.statistics.elements import Contrast, count_common_falls, mean_contrast
from overturning.statistics.falls import overturned_shares_by_record
from overturning.study.scenes import NOMINAL, uses_vertical, variant_settings, variant_size_note

NO_VERTICAL: Final = "None of these records has vertical motion: with and without it all cases are the same."


def setting_said(results: Results, variant: str, against: str) -> str:
    """Under which setting a stone falls, as part of a sentence, told apart from another one by what they differ in."""
    study, differ = results.study, differing_settings(results.study, variant, against)
    itself = "in the study itself" if variant == NOMINAL else f"in the variant {variant}"
    own, other = (variant_settings(study, name).scene or study.scene for name in (variant, against))
    if differ == ["scene"]:
        return itself if own.name == other.name else f"in the {own.name} scene"
    if differ == ["vertical"]:
        return f"{'with' if uses_vertical(study, variant) else 'without'} vertical motion"
    return "on the ground as recorded" if differ == ["site"] and variant == NOMINAL else itself


def compared_said(results: Results, variant: str) -> str:
    """Of which records a comparison with a variant is, after a number of earthquakes; nothing where of all."""
    count, every = compared_records(results, variant).size, results.cube.sizes["record"]
    return "" if count == every else f" of the {counted(count, 'record')} with vertical motion"


def contrast_sentences(results: Results, variant: str | None = None) -> tuple[str, ...]:
    """In how many cases a stone falls under one setting only, and how its falls differ where it falls under both."""
    other = variant or results.study.primary.against
    if other is None:
        return ()
    places = compared_records(results, other)
    if not places.size:
        return (NO_VERTICAL,)
    counts = count_common_falls(*(results.reference_cube(name).isel(record=places) for name in (NOMINAL, other)))
    said = setting_said(results, NOMINAL, other), setting_said(results, other, NOMINAL)
    return contrast_told(mean_contrast(counts, results.events[places]), *said, of=compared_said(results, other))


def contrast_told(found: Contrast, this: str, that: str, of: str = "") -> tuple[str, ...]:
    """What a contrast says of a stone that falls ``this`` or ``that`` way, as of `setting_said`; `of` which records."""
    if not found.both.n:
        return ("In no case is the outcome known under both.",)
    first = (
        f"Case by case, over {counted(found.both.n, 'earthquake')}{of}: the stone falls only {this} in "
        f"{_share(found.only_this)} of the cases, only {that} in {_share(found.only_other)}, under both in "
        f"{_share(found.both)}."
    )
    if found.same_way.n:
        second = (
            f"Where it falls under both, it goes the same way in {_share(found.same_way)}, and falls earlier {this} in "
            f"{_share(found.earlier)}."
        )
    elif found.only_this.value > 0 and not found.only_other.value > 0:
        second = f"So it falls first {this} wherever it falls, and there is no second direction to compare."
    else:
        second = "So there are no two directions to compare."
    return first, second


def _share(mean: Mean) -> str:
    if not mean.high > 0 and not mean.value > 0:
        return "none"
    return share(mean.value, mean.low, mean.high, decimals(mean))


def contrast_shown(results: Results) -> Figure | None:
    """Shares of the cases in which the stone falls under both settings, and their difference, also by slenderness."""
    against, ratio = results.study.primary.against, results.cube["b_over_h"].to_numpy()
    if against is None or not (places := compared_records(results, against)).size:
        return None
    events, columns, rates = results.events[places], list[FloatArray](), dict[str, list[DrawnEstimate]]()
    for variant, other in ((NOMINAL, against), (against, NOMINAL)):
        cube = results.reference_cube(variant).isel(record=places)
        each = (
            overturned_shares_by_record(cube, "b_over_h").to_numpy() if ratio.size > 1 else np.empty((0, places.size))
        )
        columns.append(np.vstack([overturned_shares_by_record(cube).to_numpy()[None], each]))
        rates[setting_said(results, variant, other)] = [
            estimate_to_draw(share_over_earthquakes(one, events)) for one in columns[-1]
        ]
    less = [estimate_to_draw(mean_over_earthquakes(one, events)) for one in columns[0] - columns[1]]
    rows = ["all cases", *(f"B/H {value:.3g}" for value in ratio if ratio.size > 1)]
    drawing = results.drawn("contrast", partial(contrast_figure, rows, rates, less))
    sizes = variant_size_note(results.study, against)
    caption = (
        "Share of the cases in which the stone falls, over all cases and by slenderness, and the difference: means "
        f"over earthquakes, with 95 % intervals by bootstrap where there are enough.{f' {sizes}.' if sizes else ''}"
    )
    return Figure(drawing, "share of the cases that overturn under both settings, and the difference", caption)
