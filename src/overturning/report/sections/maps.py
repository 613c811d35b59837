"""Polar maps of a few records, before anything else that is drawn."""

from functools import partial

import numpy as np

from overturning.report.blocks import Block, Figure, Link, Note, Section
from overturning.report.results import RecordName, Results
from overturning.statistics.by_record import by_record
from overturning.statistics.direction import OF_FALLS, case_dims, fall_axis

MOST_MAPS = 4
"""Maps that stand at the beginning; those of further records stand with the records."""

EXPLORER = "explore.html"
"""Name of the page of `overturning explore`, beside the report."""

_ABOUT = (
    "Angle: the azimuth towards which the block falls, north up, clockwise. Radius: slenderness B/H. {colour}The two halves of "
    "a map mirror each other: a block that falls to one side falls away from the other."
)

_ABOUT_SPACE = (
    "Across: the azimuth that the first side of the block faces; up: slenderness B/H; colour and arrow: the azimuth of the fall, "
    "north up. Beside it the rose of all falls of the record."
)


def maps(results: Results) -> Section:
    """Maps of all records, or of the few in whose falls the axes agree most."""
    chosen = records_first(results)
    blocks: list[Block] = []
    if len(chosen) < len(results.names):
        blocks.append(
            Note(
                f"Of the {len(results.names)} records the {len(chosen)} whose fall axes agree most (largest resultant over all "
                "blocks); the maps of the others stand with the records, below."
            )
        )
    blocks += [polar_map(results, name) for name in chosen]
    if results.in_space:
        return Section("Which way blocks fall", (*blocks, Note(_ABOUT_SPACE)), anchor="maps")
    colour = "Colour: the probability of that fall over the neighbourhood of each case. "
    blocks.append(Note(_ABOUT.format(colour=colour if "probability_towards" in results.cube else "")))
    blocks.append(Link("Look around in all cases: point at a cell, see what is known of it", EXPLORER))
    return Section("Which way blocks fall", tuple(blocks), anchor="maps")


def records_first(results: Results) -> list[RecordName]:
    """Records whose maps stand first, in the order of the cube."""
    if len(results.names) <= MOST_MAPS:
        return list(results.names)
    axes = by_record(partial(fall_axis, over=case_dims(results.cube)), results.cube, OF_FALLS)
    best = np.argsort(-np.nan_to_num(axes["axis_resultant"].to_numpy(), nan=-1.0), kind="stable")[:MOST_MAPS]
    return [results.names[index] for index in sorted(best.tolist())]


def polar_map(results: Results, name: RecordName) -> Figure:
    """The map of a record."""
    alt = f"{name.heading}: where blocks fall, by {'orientation' if results.in_space else 'azimuth'} and B/H"
    return Figure(results.figures / "polar" / f"{name.id}.svg", alt)
