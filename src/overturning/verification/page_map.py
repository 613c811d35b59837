"""The map of stability as Markdown: how cases end, and what is out of reach, counted in the run."""

import itertools
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.contact import PRECISION_FLOOR
from overturning.dem.numerics import BUDGET
from overturning.dem.plan import DEEPEST
from overturning.verification.stability import Ending
from overturning.verification.stability_cases import SPECIAL
from overturning.verification.stability_scene_cases import SCENES
from overturning.verification.table import Columns

_HEADS: Final = tuple(ending.name.lower().replace("_", " ") for ending in Ending)


def _head(first: str) -> list[str]:
    return [f"| {first} | cases | {' | '.join(_HEADS)} |", "|---" * (len(_HEADS) + 2) + "|"]


def _counted(first: str, kinds: Mapping[str, NDArray[np.bool_]], rows: Columns) -> list[str]:
    lines = _head(first)
    for name, chosen in kinds.items():
        counted = [int((rows["ending"][chosen] == ending).sum()) for ending in Ending]
        lines.append(f"| {name} | {int(chosen.sum())} | {' | '.join(map(str, counted))} |")
    return lines


def _summary(rows: Columns) -> str:
    right = rows["ending"] == Ending.RIGHT
    reasons, number = np.unique(rows["reason"][rows["ending"] == Ending.REFUSED], return_counts=True)
    refusals = ", ".join(f"{count} for `{name}`" for name, count in zip(reasons, number, strict=True))
    return (
        f"The largest residual of work and energy among the {int(right.sum())} right ones is "
        f"{np.max(rows['energy_error'][right]):.4f}, its median {np.median(rows['energy_error'][right]):.2g}. "
        f"Refused: {refusals or 'none'}. Silent: {int((rows['ending'] == Ending.SILENT).sum())}."
    )


def blocks_table(rows: Columns, about: Mapping[str, Any]) -> str:
    """How the blocks of the map end, as Markdown."""
    kinds = {"space-filling": ~np.isin(rows["motion"], SPECIAL)} | {name: rows["motion"] == name for name in SPECIAL}
    lines = _counted("motion", kinds, rows)
    lines += [
        "",
        f"{len(rows['ending'])} cases in all, at most {about['budget']:.3g} block steps each. {_summary(rows)}",
    ]
    lines += ["", *_head("δ/B")]
    edges = (0.0, 1e-9, 1e-7, 1e-5, 1e-3, 1e-2, 1e-1, np.inf)
    for low, high in itertools.pairwise(edges):
        chosen = (rows["penetration_ratio"] >= low) & (rows["penetration_ratio"] < high)
        shares = [
            f"{100 * np.mean(rows['ending'][chosen] == ending):.1f} %" if chosen.any() else "–" for ending in Ending
        ]
        lines.append(f"| {low:g} to {high:g} | {int(chosen.sum())} | {' | '.join(shares)} |")
    return "\n".join(lines)


def scenes_table(rows: Columns, about: Mapping[str, Any]) -> str:
    """How the cases of the scenes end, as Markdown."""
    harm = np.isin(rows["motion"], SPECIAL)
    kinds: dict[str, NDArray[np.bool_]] = {}
    for scene in SCENES:
        mine = rows["scene"] == scene
        kinds |= {f"{scene}, space-filling": mine & ~harm, f"{scene}, motions made to do harm": mine & harm}
    lines = _counted("scene", kinds, rows)
    lines += [
        "",
        f"{len(rows['ending'])} cases in all, at most {about['budget']:.3g} steps each, {about['special_budget']:.3g} under motions "
        f"made to do harm. {_summary(rows)} Of {int((rows['as_block'] >= 0).sum())} gravestones that stay on the ground and are "
        f"answered by the block's own kernel too, {int((rows['as_block'] == 0).sum())} have another flag there.",
    ]
    return "\n".join(lines)


def reach(blocks: Columns, about: Mapping[str, Any], scenes: Columns) -> str:
    """What is out of reach, and why, with the shares of this run, as a Markdown list."""
    ending, ratio = blocks["ending"], blocks["penetration_ratio"]
    soft = ratio > 0.1
    unstable = (ending == Ending.UNSTABLE) & (ratio < 1e-2)
    # The penetration is in B, its limit a share of half the smaller side.
    sunk = blocks["penetration"] > 0.5 * DEEPEST * np.minimum(1.0, 1.0 / blocks["b_over_h"])
    over, undecided = ending == Ending.OVER_BUDGET, ending == Ending.UNDECIDED
    in_scenes = (scenes["ending"] == Ending.UNSTABLE) & (scenes["penetration_ratio"] < 1e-2)
    lines = [
        f"δ/B above about 0.1, or δ above a tenth of the smaller side: the block's own weight presses its corners in so far that the "
        f"contact law means nothing. Marked `unstable`: {_percent(ending[soft] == Ending.UNSTABLE)} of the {int(soft.sum())} blocks "
        "with δ/B above 0.1.",
        f"δ below {PRECISION_FLOOR * np.finfo(float).eps:.1g} H: double precision does not hold the penetration of a block at rest. "
        "Refused, naming `stiffness`; a scene likewise, by its height.",
        f"Strong shaking on lightly damped contacts: corners are thrown up and come down fast. Of the {int(unstable.sum())} unstable "
        f"blocks with δ/B below 10⁻² {_percent(blocks['damping'][unstable] < 0.1)} have ξ below 0.1; half of them have a peak above "
        f"{np.median(blocks['acceleration_ratio'][unstable]):.0f} g·B/H. {_percent(sunk[unstable])} sink in too deep; of the others work "
        f"and energy do not balance to 10⁻². Of the {int(in_scenes.sum())} such cases of scenes "
        f"{_percent(scenes['damping'][in_scenes] < 0.1)} have ξ below 0.1, and half a peak above "
        f"{np.median(scenes['acceleration_ratio'][in_scenes]):.0f} times the threshold of rocking.",
        f"Stiff springs on small blocks under long records: the stable step is so short that the budget of block steps runs out "
        f"(`over_budget`). Of {int(over.sum())} such blocks half are lower than {np.median(blocks['height'][over]):.2g} m. The map's "
        f"budget, {about['budget']:.2g}, is far below a study's, {BUDGET:.0e}.",
        f"Blocks on little friction that still slide 20/p seconds after the record, with energy enough to fall if they tripped: "
        f"`undecided`. Of {int(undecided.sum())} such blocks {_percent(blocks['friction'][undecided] < 0.02)} have µ below 0.02.",
    ]
    return "\n".join(f"- {line}" for line in lines)


def _percent(chosen: NDArray[np.bool_]) -> str:
    return f"{100 * np.mean(chosen):.0f} %" if len(chosen) else "none"
