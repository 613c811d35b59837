"""The records: maps of a few, cases to watch, their peaks, where blocks fall under each, their figures."""

import math
from functools import partial
from typing import Any, Final

import numpy as np

from overturning.figures.polar_map import plane_map_figure
from overturning.figures.site_map import MOST_SITES, distance_sentences, sites_of
from overturning.model.status import Status
from overturning.records.record import processing_entry_text
from overturning.report.blocks import Bullets, Disclosure, Figure, Film, Link, Note, Row, Said, Section, section, table
from overturning.report.results import RecordName, Results
from overturning.report.text import degrees, number, of_group
from overturning.statistics.boundary import easiest_azimuth, overturning_boundary
from overturning.statistics.by_record import record_groups
from overturning.statistics.circular import LEAST_RESULTANT, wrap_axis
from overturning.statistics.falls import overturned_shares_by_record
from overturning.statistics.illustrative import WHICH_SIDE
from overturning.study.cube import first_shown_block, record_provenance
from overturning.units import CM, GAL

MAP_WIDTH: Final = 0.7
"""Of a polar map on paper, as a part of the width of a page: two are as high as the page."""

EXPLORER = "explore.html"
"""Name of the page of `overturning explore`, beside the report."""

_PEAKS = (("pga", GAL, 0), ("pgv", CM, 1), ("pgd", CM, 1))
"""Measures with unit and decimals of a table."""


@section("Which way blocks fall", "maps")
def maps(results: Results) -> Said:
    """Maps of all records, or of a few of those that the question is about."""
    chosen = results.first_records
    if len(chosen) < len(results.record_names):
        which = of_group(next(iter(record_groups(results.cube))))
        yield Note(
            f"Of the {len(results.record_names)} records the first {len(chosen)}{which} that are of different "
            "earthquakes, in the order of the study; those in whose map nothing falls are passed over where there are "
            "others. The maps of the others stand with the records, below on the page."
        )
    yield from _compared_maps(results, chosen)
    chance = (
        "White to dark: the probability of falling towards the azimuth, over the neighbourhood of each case; hatched "
        "grey: no run falls, to either side. "
    )
    yield Note(results.words.map.format(chance=chance if "members" in results.cube else ""))
    yield Link("Look around in all cases: point at a cell, see what is known of it", EXPLORER)


def _compared_maps(results: Results, chosen: list[RecordName]) -> Said:
    """Maps of several records: in planes on one radial scale, in one figure."""
    if not results.model.one_component:
        shown = [_map(results, name) for name in chosen]
        for pair in (tuple(shown[i : i + 2]) for i in range(0, len(shown), 2)):
            yield Row(pair) if len(pair) == 2 else pair[0]
        return
    places = [results.record_names.index(name) for name in chosen]
    block = results.cube.sel(first_shown_block(results.cube, results.study))
    cubes = [block.isel(record=place).load() for place in places]
    peaks = [results.intensity["pgv"].isel(record=place) for place in places]
    title = chosen[0].heading if len(chosen) == 1 else "Where blocks fall"
    drawing = results.drawn("maps", partial(plane_map_figure, cubes, title, peaks))
    alt = "where blocks fall, by azimuth and B/H, under " + "; ".join(name.heading for name in chosen)
    yield Figure(drawing, alt, width=MAP_WIDTH if len(chosen) == 1 else 1.0)


def _map(results: Results, name: RecordName) -> Figure:
    alt = f"{name.heading}: where blocks fall, by {results.model.direction} and B/H"
    return Figure(results.figures / "polar" / f"{name.id}.svg", alt, width=MAP_WIDTH)


@section("Cases to watch", "illustrative")
def illustrative(results: Results) -> Said:
    """The illustrative cases as films; none where there is none."""
    if not results.illustrative:
        return
    yield Note("The page report.html shows them as films.", medium="paper")
    for case in results.illustrative:
        behind = tuple(Figure(results.figures / "illustrative" / file, **about) for file, about in case.figures.items())
        rule = Note(f"Chosen by rule: {case.rule}.")
        film = Film(case.film, case.block, results.figures / "illustrative" / case.strip)
        shown = (film, Bullets(case.outcomes), rule, Disclosure("Motion and response", behind))
        yield Section(case.title, shown)
    if WHICH_SIDE not in {case.title for case in results.illustrative}:
        yield Note(f"No block falls to opposite sides at two neighbouring {results.model.direction}s.")
    keys = f"Keys: space plays and pauses, ← and → step, Home and End, s changes the speed, {case.keys}."
    yield Note(keys, medium="page")


@section("Records", "records")
def records(results: Results) -> Said:
    """Peaks of each record, directions of its falls, maps of the stations."""
    yield from _peaks(results)
    yield from _processing(results)
    if results.share_overturned > 0:
        heads = ["record", "mean fall direction", "resultant", "mean fall axis", "resultant", "from the fault normal"]
        if results.model.one_component:
            heads[-1:] = ["easiest axis", "from the fault normal", "easier by"]
        rows = [(name.id, *cells) for name, cells in zip(results.record_names, record_directions(results), strict=True)]
        directions = table(heads, rows, "l", anchor="directions", sortable=True)
        yield Section("Where blocks fall, by record", (directions, Note(results.words.means)))
    sites = sites_of(results.cube)
    for first in range(0, len(sites), MOST_SITES):
        some, path = sites[first : first + MOST_SITES], results.figures / "maps" / f"{first // MOST_SITES + 1}.svg"
        told = " ".join(distance_sentences(some[0])) if len(some) == 1 else ""
        alt = "map: " + "; ".join(site.name for site in some)
        yield Figure(path, alt, told, width=min(1.0, 0.62 * len(some)))
    if sites:
        yield Note(
            "Stations, epicentres and traces as the records or the record table state them, with their sources in the "
            "record table. Arrows: the mean axis of the falls; none where falls have no clear axis."
        )


def _odd_records(results: Results) -> Said:
    """Which records drift, and by what that is told, and which leave every case at rest."""
    drifts = {name: account.get("drift") for name, account in record_provenance(results.cube).items()}
    if drifting := ". ".join(f"{name}: {why}" for name, why in drifts.items() if why):
        yield Note(f"A PGD in brackets is that of a record that drifts, and not the ground's. {drifting}.")
    at_rest = results.cube["status"] == Status.AT_REST
    still = at_rest.all([name for name in at_rest.dims if name != "record"]).compute().to_numpy()
    if weak := [name.id for name, one in zip(results.record_names, still, strict=True) if one]:
        yield Note(f"Too weak to move any stone of the study: {', '.join(weak)}.")


@section("Record by record", "figures", medium="page")
def record_by_record(results: Results) -> Said:
    """The figures of each record."""
    yield Note(
        f"Beside the report, {results.figures.name}/history/ has a page of each record (record.svg): time histories "
        "before and after processing, Fourier amplitudes, signal-to-noise ratio, Husid plot, and what was taken away."
    )
    for name in results.record_names:
        path = results.figures / "intensity" / f"{name.id}.svg"
        peaks = Figure(path, "peak acceleration and velocity by azimuth", width=0.7)
        shown: list[Any] = [peaks] if name in results.first_records else [_map(results, name), peaks]
        if results.study.several_blocks:
            alt = f"{name.heading}: where blocks of all sizes and frictions fall"
            every = Figure(results.figures / "blocks" / f"{name.id}.svg", alt)
            shown.append(Disclosure("All heights and frictions", (every,)))
        yield Section(name.heading, tuple(shown), anchor=name.id, together=True)


def _peaks(results: Results) -> Said:
    """One row per record: names, largest intensities with their azimuths, share of cases that overturn."""
    shares = overturned_shares_by_record(results.cube).to_numpy()
    pulses, normals = (results.cube[name].to_numpy().astype(float) for name in ("pulse", "fault_normal"))
    azimuth, accounts = results.intensity["azimuth"].to_numpy(), record_provenance(results.cube)
    vertical, rows = results.intensity["pga_vertical"].to_numpy(), []
    more = ("vertical PGA, Gal",) if np.isfinite(vertical).any() else ()
    for index, name in enumerate(results.record_names):
        cells: list[Any] = []
        for measure, unit, digits in _PEAKS:
            values = results.intensity[measure].isel(record=index).to_numpy()
            cells += [f"{values.max() / unit:.{digits}f}", float(azimuth[int(values.argmax())] % 180)]
        cells[-2] = f"({cells[-2]})" if accounts.get(name.id, {}).get("drift") else cells[-2]
        pulse = {1.0: "yes", 0.0: "no"}.get(float(pulses[index]), "–")
        named = (name.id, name.station, name.event, pulse, float(normals[index]))
        cells[-1:] = ["–" if math.isnan(vertical[index]) else f"{vertical[index] / GAL:.0f}"] if more else []
        rows.append((*named, *cells, float(shares[index])))
    heads = ("record", "station", "earthquake", "pulse", "fault normal", "PGA, Gal", "along", "PGV, cm/s", "along")
    formats = f"lttt°n°n°n{'n' * len(more)}%"
    yield table((*heads, "PGD, cm", *more, "overturned"), rows, formats, anchor="peaks", sortable=True)
    yield Note(
        "Azimuths in degrees clockwise from north. Peaks are the largest over the azimuths of the study, each with the "
        f"azimuth along which it is reached. Overturned: share of the record's cases{results.of_known}."
    )
    yield Note("A click on a heading sorts.", medium="page")
    yield from _odd_records(results)


def _processing(results: Results) -> Said:
    """What was done to each record, by whom, and what that changed."""
    heads = ("record", "data and processing", "PGA, Gal", "PGV, cm/s", "PGD, cm", "computed", "declared or trusted")
    accounts = record_provenance(results.cube)
    named = [(name.id, accounts[name.id]) for name in results.record_names if name.id in accounts]
    if not named:
        return
    rows = [(name, *_account(account)) for name, account in named]
    note = Note(
        "Raw data is as the recorder gave it; what an agency did to processed data is told as far as its file tells "
        "it. Peaks are the largest of north and east, before → after what was done here. Computed is the length of "
        "the motion, from its first sample (UTC); of it each case leaves out the beginning that cannot move its block."
    )
    yield Section("Processing of the records", (table(heads, rows, "lwnnntw", anchor="processing"), note))


def _account(account: dict[str, Any]) -> tuple[str, ...]:
    """Cells of a record's row, after its name."""
    steps = [processing_entry_text(step) for step in account["steps"]]
    peaks = []
    for measure, unit, digits in _PEAKS:
        before, after = (f"{value / unit:.{digits}f}" for value in account["peaks"][measure])
        after = f"({after})" if measure == "pgd" and account.get("drift") else after
        peaks.append(after if before == after.strip("()") else f"{before} → {after}")
    clock = account["start"].partition("T")[2].partition(".")[0].removesuffix("Z")
    computed = f"{account['duration_s']:.1f}\u00a0s" + (f" from\u00a0{clock}" if clock else "")
    said = [*account["declared"], *(f"trusted although {why}" for why in account["trusted"])]
    said += account.get("notes", ())
    data = account["data"] + (f" ({account['agency']})" if account["agency"] else "")
    done = f"{data}; " + ("here: " + ", ".join(steps) if steps else "left alone here")
    return done, *peaks, computed, "; ".join(said) or "–"


def record_directions(results: Results) -> list[tuple[str, ...]]:
    """Where blocks fall under each record, as cells of a table.

    Mean fall direction and axis with their resultants, over the informative blocks; azimuth of easiest overturning of
    the lowest block at the highest friction, its angle from the fault normal, and the largest B/H along it over that
    along the hardest azimuth; where cases have no azimuth the angle of the mean axis from the fault normal
    instead. Dashes where nothing falls, and for a mean whose resultant is below `LEAST_RESULTANT`.
    """
    cube, found = results.cube, results.record_means
    normal, columns = cube["fault_normal"].to_numpy(), list[list[str]]()
    for kind, full in (("direction", 360), ("axis", 180)):
        lengths = found[f"{kind}_resultant"].to_numpy()
        angles = np.where(lengths >= LEAST_RESULTANT, found[f"mean_{kind}"], np.nan)
        columns += [[degrees(one, full) for one in angles.tolist()], [*map(number, lengths.tolist())]]
    if not results.model.one_component:
        off = np.abs(wrap_axis(found["mean_axis"].to_numpy() - normal))
        return list(zip(*columns, map(degrees, off.tolist()), strict=True))
    one = cube.isel(height=[0], friction=[cube.sizes["friction"] - 1])
    easiest = easiest_azimuth(overturning_boundary(one), cube["b_over_h"]).isel(height=0, friction=0)
    ratio = easiest["ratio"].to_numpy()
    best = np.where(ratio > 1.0 + 1e-9, easiest["easiest_axis"], np.nan)  # where all planes are alike none is easiest
    bounds = np.where(np.isnan(ratio) | easiest["bounded"], "", "≥ ")
    apart = np.abs(wrap_axis(best - normal)).tolist()
    columns += [[degrees(one, 180) for one in best.tolist()], [*map(degrees, apart)]]
    easier = (bound + number(one) for bound, one in zip(bounds.tolist(), ratio.tolist(), strict=True))
    return list(zip(*columns, easier, strict=True))
