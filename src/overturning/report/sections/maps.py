"""Polar maps of a few records, before anything else that is drawn."""

from functools import partial

import numpy as np

from overturning.report.blocks import Block, Figure, Link, Note, Section
from overturning.report.results import RecordName, Results
from overturning.statistics.by_record import by_record
from overturning.statistics.falls import fall_means

MOST_MAPS = 4
"""Maps that stand at the beginning; those of further records stand with the records."""

EXPLORER = "explore.html"
"""Name of the page of `overturning explore`, beside the report."""


def maps(results: Results) -> Section:
    """Maps of all records, or of the few in whose falls the axes agree most."""
    chosen = records_first(results)
    blocks: list[Block] = []
    if len(chosen) < len(results.names):
        blocks.append(
            Note(
                f"Of the {len(results.names)} records the {len(chosen)} whose fall axes agree most (largest resultant "
                "over all "
                "blocks); the maps of the others stand with the records, below."
            )
        )
    blocks += [polar_map(results, name) for name in chosen]
    chance = "Colour: the probability of that fall over the neighbourhood of each case. "
    blocks.append(Note(results.words.map.format(chance=chance if "members" in results.cube else "")))
    if results.model.one_component:
        blocks.append(Link("Look around in all cases: point at a cell, see what is known of it", EXPLORER))
    return Section("Which way blocks fall", tuple(blocks), anchor="maps")


def records_first(results: Results) -> list[RecordName]:
    """Records whose maps stand first, in the order of the cube."""
    if len(results.names) <= MOST_MAPS:
        return list(results.names)
    model = results.model
    axes = by_record(partial(fall_means, over=model.case_dims), results.cube, model.reads)
    best = np.argsort(-np.nan_to_num(axes["axis_resultant"].to_numpy(), nan=-1.0), kind="stable")[:MOST_MAPS]
    return [results.names[index] for index in sorted(best.tolist())]


def polar_map(results: Results, name: RecordName) -> Figure:
    """The map of a record."""
    alt = f"{name.heading}: where blocks fall, by {results.model.direction} and B/H"
    return Figure(results.figures / "polar" / f"{name.id}.svg", alt)
