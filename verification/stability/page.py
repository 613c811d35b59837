"""Markdown tables and lists of the map of stability: outcomes of its cases, and inputs without an answer."""

import itertools
from collections.abc import Mapping
from typing import Final

import numpy as np
import pandas as pd

from overturning.dem.limits import MAX_PENETRATION_TO_HALF_SIDE_RATIO
from overturning.dem.numerics import DEFAULT_MAX_BLOCK_STEPS_PER_CASE
from overturning.model.contact import MIN_PENETRATION_TO_ROUNDING_ERROR_RATIO
from verification.stability.cases import ADVERSARIAL_MOTION_KINDS, SCENE_NAMES
from verification.stability.checks import StabilityCheckVerdict
from verification.tables import MeasuredNumber, markdown_table, wrap_text

MAX_PENETRATION_TO_WIDTH_OF_STIFF_CONTACT: Final = 1e-5
"""δ/B below which contacts are stiff: here only extreme cases should be marked."""

_OUTCOME_COLUMN_HEADERS: Final = tuple(ending.label.replace("_", " ") for ending in StabilityCheckVerdict)


def markdown_by_marker(block_rows: pd.DataFrame, scene_rows: pd.DataFrame, stack_rows: pd.DataFrame) -> dict[str, str]:
    """Return the tables of the stability maps as Markdown, by marker."""
    return {
        "stability": _block_outcome_tables(block_rows), "scenes": _scene_outcome_table(scene_rows),
        "stacks": _stack_outcome_tables_by_motion_and_stone_count(stack_rows),
        "reach": _paragraphs_on_inputs_without_outcome(block_rows, scene_rows)
    }  # fmt: skip


def stability_numbers_for_summary_table(
    block_rows: pd.DataFrame, scene_rows: pd.DataFrame, stack_rows: pd.DataFrame
) -> list[MeasuredNumber]:
    """Return measured numbers of the stability maps for the summary table."""
    made = []
    for name, rows in (("blocks", block_rows), ("scenes", scene_rows), ("stacks", stack_rows)):
        silent, right = (
            rows["ending"] == StabilityCheckVerdict.WRONG_WITHOUT_WARNING,
            rows["ending"] == StabilityCheckVerdict.ALL_CHECKS_HOLD,
        )
        energy = float(rows["energy_error"][right].max())
        made += [
            MeasuredNumber(f"map of stability, {name}: cases", len(rows)),
            MeasuredNumber(f"map of stability, {name}: wrong without a mark", int(silent.sum())),
            MeasuredNumber(f"map of stability, {name}: largest residual of work and energy", energy),
        ]
    stiff = block_rows["ending"][block_rows["penetration_ratio"] < MAX_PENETRATION_TO_WIDTH_OF_STIFF_CONTACT]
    marked = 100 * float((stiff == StabilityCheckVerdict.NUMERICALLY_UNSTABLE).mean())
    made.append(
        MeasuredNumber(
            f"map of stability, blocks: marked, δ/B below {MAX_PENETRATION_TO_WIDTH_OF_STIFF_CONTACT:g}", marked, "%"
        )
    )
    return made


def _outcome_count_table(
    first_column_header: str, row_mask_by_case_kind: Mapping[str, "pd.Series[bool]"], rows: pd.DataFrame
) -> str:
    """Return a table of the number of cases with each outcome, one row per kind of case."""
    lines = []
    for name, chosen in row_mask_by_case_kind.items():
        endings = rows["ending"][chosen]
        lines.append((name, len(endings), *((endings == ending).sum() for ending in StabilityCheckVerdict)))
    return markdown_table((first_column_header, "cases", *_OUTCOME_COLUMN_HEADERS), lines)


def _paragraph_on_energy_error_refusals_silent_errors(rows: pd.DataFrame, check_count_in_words: str = "six") -> str:
    """Return a paragraph on energy errors, refused inputs, and wrong outcomes without a warning."""
    energy = rows["energy_error"][rows["ending"] == StabilityCheckVerdict.ALL_CHECKS_HOLD]
    reasons = rows["reason"][rows["ending"] == StabilityCheckVerdict.ARGUMENT_REFUSED].value_counts().sort_index()
    refusals = " or ".join(f"`{name}` ({count} inputs)" for name, count in reasons.items())
    named = f", with an error that names the argument {refusals}" if refusals else ""
    return (
        f"Among the {len(energy)} cases that pass all {check_count_in_words} checks, the largest residual of work and "
        f"energy is {energy.max():.4f} and the median residual {energy.median():.2g}. The program refused "
        f"{reasons.sum()} inputs{named}. The number of cases with the label *silent* (a wrong outcome without warning) "
        f"is {(rows['ending'] == StabilityCheckVerdict.WRONG_WITHOUT_WARNING).sum()}."
    )


def _block_outcome_tables(rows: pd.DataFrame) -> str:
    """Return the tables of outcomes of single blocks."""
    kinds = {"space-filling": ~rows["motion"].isin(ADVERSARIAL_MOTION_KINDS)} | {
        n: rows["motion"] == n for n in ADVERSARIAL_MOTION_KINDS
    }
    by_motion = _outcome_count_table("motion", kinds, rows)
    by_penetration = _outcome_share_table_by_penetration(rows, (0.0, 1e-9, 1e-7, 1e-5, 1e-3, 1e-2, 1e-1, np.inf))
    budget = f"The table counts {len(rows)} cases; each of them may use at most {rows.attrs['budget']:.3g} time steps."
    paragraph = wrap_text(f"{budget} {_paragraph_on_energy_error_refusals_silent_errors(rows)}")
    return f"{by_motion}\n\n{paragraph}\n\n{by_penetration}"


def _outcome_share_table_by_penetration(rows: pd.DataFrame, penetration_to_width_ratio_edges: tuple[float, ...]) -> str:
    """Return a table of the share of each outcome by the penetration at rest over width, in intervals."""
    lines = []
    for low, high in itertools.pairwise(penetration_to_width_ratio_edges):
        endings = rows["ending"][(rows["penetration_ratio"] >= low) & (rows["penetration_ratio"] < high)]
        shares = [f"{100 * (endings == e).mean():.1f} %" if len(endings) else "–" for e in StabilityCheckVerdict]
        lines.append((f"{low:g} to {high:g}", len(endings), *shares))
    return markdown_table(("δ/B", "cases", *_OUTCOME_COLUMN_HEADERS), lines)


def _scene_outcome_table(rows: pd.DataFrame) -> str:
    """Return the table of outcomes of scenes."""
    adversarial = rows["motion"].isin(ADVERSARIAL_MOTION_KINDS)
    kinds: dict[str, pd.Series[bool]] = {}
    for scene in SCENE_NAMES:
        mine = rows["scene"] == scene
        kinds |= {f"{scene}, space-filling": mine & ~adversarial, f"{scene}, adversarial motions": mine & adversarial}
    compared = rows["as_block"][rows["as_block"] >= 0]
    summary = (
        f"The table counts {len(rows)} cases of scenes. A case may use at most {rows.attrs['budget']:.3g} time steps, "
        f"or {rows.attrs['adversarial_budget']:.3g} time steps under adversarial motions (chosen to make the program "
        f"fail). {_paragraph_on_energy_error_refusals_silent_errors(rows)} "
        f"The {len(compared)} cases of gravestones that do not slide off the ground were also run with the program for "
        f"single blocks; the flags of the two programs differ in {(compared == 0).sum()} of these cases."
    )
    return f"{_outcome_count_table('scene', kinds, rows)}\n\n{wrap_text(summary)}"


def _stack_outcome_tables_by_motion_and_stone_count(rows: pd.DataFrame) -> str:
    """Return the tables of outcomes of 3-D stacks: by motion, number of stones, kind, and penetration at rest."""
    tables = [
        _outcome_count_table(head, {str(name): rows[column] == name for name in sorted(rows[column].unique())}, rows)
        for head, column in (("motion", "motion"), ("stones", "stones"), ("kind of stack", "kind"))
    ]
    right, unstable = (
        rows["ending"] == StabilityCheckVerdict.ALL_CHECKS_HOLD,
        rows["ending"] == StabilityCheckVerdict.NUMERICALLY_UNSTABLE,
    )
    falls = rows["vertical"] > 1.0
    summary = (
        f"The tables count {len(rows)} cases with at most {rows.attrs['budget']:.3g} time steps each. "
        f"{_paragraph_on_energy_error_refusals_silent_errors(rows, 'nine')} In {int((rows['fallen'] > 0).sum())} of "
        f"the "
        f"cases at least "
        f"one stone of the stack falls; in {int((rows['fallen'] > 1).sum())} of these cases, more than one falls. "
        f"The ground accelerates downwards by more than 1 g in {_percent_text(falls[unstable])} of the "
        f"{int(unstable.sum())} unstable cases, and in {_percent_text(falls[right])} of the {int(right.sum())} cases "
        f"labelled *right*. The damping ratio ξ is below 0.1 in {_percent_text(rows['damping'][unstable] < 0.1)} of "
        f"the unstable cases, and in {_percent_text(rows['damping'][right] < 0.1)} of the cases labelled *right*."
    )
    by_penetration = _outcome_share_table_by_penetration(rows, (0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2))
    return "\n\n".join([*tables, wrap_text(summary), by_penetration])


def _paragraphs_on_inputs_without_outcome(block_rows: pd.DataFrame, scene_rows: pd.DataFrame) -> str:
    """Return a paragraph on each kind of input for which the program gives no outcome, with its share in this run."""
    ending, ratio = block_rows["ending"], block_rows["penetration_ratio"]
    soft = ratio > 0.1
    unstable = (ending == StabilityCheckVerdict.NUMERICALLY_UNSTABLE) & (ratio < 1e-2)
    # The penetration is in B, its limit a share of half the smaller side.
    sunk = block_rows["penetration"] > 0.5 * MAX_PENETRATION_TO_HALF_SIDE_RATIO * np.minimum(
        1.0, 1.0 / block_rows["b_over_h"]
    )
    over, undecided = (
        ending == StabilityCheckVerdict.OVER_STEP_BUDGET,
        ending == StabilityCheckVerdict.UNDECIDED_AT_END_TIME,
    )
    in_scenes = (scene_rows["ending"] == StabilityCheckVerdict.NUMERICALLY_UNSTABLE) & (
        scene_rows["penetration_ratio"] < 1e-2
    )
    lines = [
        "Very soft contacts have a penetration δ at rest above a tenth of the width B or, in a scene, of the smaller "
        "side of the element. If the contacts are very soft, the weight of the block presses its corners so deep "
        "into the base that the contact law no longer applies. "
        f"Of the {int(soft.sum())} blocks with δ/B above 0.1, "
        f"{_percent_text(ending[soft] == StabilityCheckVerdict.NUMERICALLY_UNSTABLE)} are marked `unstable`.",
        "Very stiff contacts have a penetration δ at rest below "
        f"{MIN_PENETRATION_TO_ROUNDING_ERROR_RATIO * np.finfo(float).eps:.1g} H, where "
        "H is the height: double precision cannot resolve such a penetration. The program refuses a block or "
        "scene whose contacts are too stiff for double precision, and the error names `stiffness`.",
        "On lightly damped contacts, strong shaking throws corners up, and the corners land fast. Of the "
        f"{int(unstable.sum())} unstable blocks with δ/B below 10⁻², "
        f"{_percent_text(block_rows['damping'][unstable] < 0.1)} "
        "have a damping ratio ξ below 0.1. Half of the unstable blocks with δ/B below 10⁻² are shaken with a peak "
        f"acceleration above {np.median(block_rows['acceleration_ratio'][unstable]):.0f} g·B/H. Of the "
        f"unstable blocks with δ/B below 10⁻², {_percent_text(sunk[unstable])} penetrate too deep; in the other "
        "blocks, work and energy do not balance to 10⁻². Of the "
        f"{int(in_scenes.sum())} unstable cases of scenes with δ/B below 10⁻², "
        f"{_percent_text(scene_rows['damping'][in_scenes] < 0.1)} have a damping ratio ξ below 0.1. Half of the "
        "unstable cases of scenes with δ/B below 10⁻² are shaken with a peak acceleration above "
        f"{np.median(scene_rows['acceleration_ratio'][in_scenes]):.0f} times the threshold of rocking.",
        "Small blocks under long records may need too many time steps, mostly with Cundall's scheme and stiff springs. "
        "A case that reaches the largest allowed number of steps is marked `over_budget`. Half of the "
        f"{int(over.sum())} blocks over budget are lower than {np.median(block_rows['height'][over]):.2g} m. "
        f"The program allows a case at most {block_rows.attrs['budget']:.2g} time steps in the map of stability, and "
        f"at most {DEFAULT_MAX_BLOCK_STEPS_PER_CASE:.0e} time steps in a study.",
        "Blocks on contacts with little damping may still bounce or rock strongly at the time 20/p after the record (p "
        "is the rocking frequency). They are marked `undecided` if they have enough energy to overturn. Of the "
        f"{int(undecided.sum())} undecided blocks, {_percent_text(block_rows['damping'][undecided] < 0.01)} have a "
        "damping ratio ξ below 0.01.",
    ]
    return "\n\n".join(wrap_text(line) for line in lines)


def _percent_text(flags: "pd.Series[bool]") -> str:
    """Return the share of True in percent as text."""
    return f"{100 * np.mean(flags):.0f} %" if len(flags) else "none"
