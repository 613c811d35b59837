"""The records: their peaks, where blocks fall under each, where they were recorded, and their figures."""

import math
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from overturning.model.falls import model_of
from overturning.records.record import summary
from overturning.report.blocks import Block, Figure, Note, Row, Section, Table
from overturning.report.results import Results
from overturning.report.sections.maps import polar_map, records_first
from overturning.report.text import degrees, number, percent
from overturning.statistics.boundary import boundary, easiest_azimuth
from overturning.statistics.by_record import by_record
from overturning.statistics.circular import wrap_axis
from overturning.statistics.falls import fall_means, overturns
from overturning.study.cube import processing_of
from overturning.units import CM, GAL

LEAST_RESULTANT = 0.05
"""Resultant below which falls go every way alike and a mean direction or axis would be chance."""


def records(results: Results) -> Section:
    """Peaks of each record, directions of its falls, maps of the stations."""
    about_peaks = Note(
        "Azimuths in degrees clockwise from north. Peaks are the largest over the azimuths of the study, each with the "
        "azimuth along which it is reached. Overturned: share of the record's cases."
    )
    blocks: list[Block] = [_peaks(results), about_peaks, Note("A click on a heading sorts.", medium="page")]
    blocks += _processing(results)
    if results.fallen > 0:
        blocks.append(_directions(results))
    if maps := _maps(results):
        about_maps = Note(
            "Stations and epicentres as the records or the record table state them; a fault whose strike is known is "
            "drawn "
            "through the epicentre."
        )
        blocks += [*(Row(maps[i : i + 2], shares=(1.0, 1.0)) for i in range(0, len(maps), 2)), about_maps]
    return Section("Records", tuple(blocks), anchor="records")


def record_by_record(results: Results) -> Section:
    """The figures of each record."""
    sections = []
    first = records_first(results)
    for name in results.names:
        peaks = Figure(
            results.figures / "intensity" / f"{name.id}.svg", "peak acceleration and velocity by azimuth", width=0.7
        )
        shown = (peaks,) if name in first else (polar_map(results, name), peaks)
        sections.append(Section(name.heading, shown, anchor=name.id, together=True))
    beside = Note(
        f"Beside the report, {results.figures.name}/history/ has a page of each record (record.svg): time histories "
        "before and "
        "after processing, Fourier amplitudes, signal-to-noise ratio, Husid plot, and what was taken away."
    )
    return Section("Record by record", (beside, *sections), anchor="figures")


def _peaks(results: Results) -> Table:
    """One row per record: names, largest intensities with their azimuths, share of cases that overturn."""
    falls = overturns(results.cube)
    shares = falls.mean([name for name in falls.dims if name != "record"]).compute().to_numpy()
    pulses, normals = (results.cube[name].to_numpy().astype(float) for name in ("pulse", "fault_normal"))
    azimuth = results.intensity["azimuth"].to_numpy()
    rows = []
    for index, name in enumerate(results.names):
        cells = []
        for measure, unit, digits in (("pga", GAL, 0), ("pgv", CM, 1), ("pgd", CM, 1)):
            values = results.intensity[measure].isel(record=index).to_numpy()
            cells += [f"{values.max() / unit:.{digits}f}", degrees(float(azimuth[int(values.argmax())] % 180))]
        pulse = {1.0: "yes", 0.0: "no"}.get(float(pulses[index]), "–")
        named = (name.id, name.station, name.event, pulse, degrees(float(normals[index])))
        rows.append((*named, *cells[:-1], percent(float(shares[index]))))
    heads = ("record", "station", "earthquake", "pulse", "fault normal", "PGA, Gal", "along", "PGV, cm/s", "along")
    return Table((*heads, "PGD, cm", "overturned"), tuple(rows), "lttt", anchor="peaks", sortable=True)


def _processing(results: Results) -> list[Block]:
    """What was done to each record, by whom, and what that changed."""
    heads = ("record", "data and processing", "PGA, Gal", "PGV, cm/s", "PGD, cm", "computed", "declared or trusted")
    accounts = processing_of(results.cube)
    named = [(name.id, accounts[name.id]) for name in results.names if name.id in accounts]
    if not named:
        return []
    rows = tuple((name, *_account(account)) for name, account in named)
    note = Note(
        "Raw data is as the recorder gave it; what an agency did to processed data is told as far as its file tells "
        "it. Peaks "
        "are the largest of north and east, before → after what was done here. Computed is the length of the motion, "
        "from its "
        "first sample (UTC); of it each case leaves out the beginning that cannot move its block."
    )
    return [Section("Processing of the records", (Table(heads, rows, "lwnnntw", anchor="processing"), note))]


def _account(account: dict[str, Any]) -> tuple[str, ...]:
    """Cells of a record's row, after its name."""
    steps = [summary(step) for step in account["steps"]]
    peaks = []
    for measure, unit, digits in (("pga", GAL, 0), ("pgv", CM, 1), ("pgd", CM, 1)):
        before, after = (f"{value / unit:.{digits}f}" for value in account["peaks"][measure])
        peaks.append(after if before == after else f"{before} → {after}")
    clock = account["start"].partition("T")[2].partition(".")[0].removesuffix("Z")
    computed = f"{account['duration_s']:.1f}\u00a0s" + (f" from\u00a0{clock}" if clock else "")
    said = [*account["declared"], *(f"trusted although {why}" for why in account["trusted"])]
    data = account["data"] + (f" ({account['agency']})" if account["agency"] else "")
    done = f"{data}; " + ("here: " + ", ".join(steps) if steps else "left alone here")
    return done, *peaks, computed, "; ".join(said) or "–"


def _directions(results: Results) -> Section:
    named = zip(results.names, record_directions(results.cube), strict=True)
    rows = tuple((name.id, *cells) for name, cells in named)
    heads = ["record", "mean fall direction", "resultant", "mean fall axis", "resultant", "from the fault normal"]
    if results.model.one_component:
        heads[-1:] = ["easiest axis", "from the fault normal", "easier by"]
    table = Table(tuple(heads), rows, "l", anchor="directions", sortable=True)
    return Section("Where blocks fall, by record", (table, Note(results.words.means)))


def _maps(results: Results) -> tuple[Figure, ...]:
    """The map of each earthquake whose epicentre or stations are known, with the distances."""
    from overturning.figures.site_map import distances, sites_by_earthquake

    return tuple(
        Figure(results.figures / "maps" / f"{number}.svg", f"map: {event}", " ".join(distances(site)))
        for number, (event, site) in enumerate(sites_by_earthquake(results.cube).items(), 1)
    )


def record_directions(cube: xr.Dataset) -> list[tuple[str, ...]]:
    """Where blocks fall under each record, as cells of a table.

    Mean fall direction and its resultant, mean fall axis and its resultant, over all cases; azimuth of easiest
    overturning of the lowest block at the highest friction, its angle from the fault normal, and the largest B/H along
    it over that along the hardest azimuth; where cases have no azimuth the angle of the mean axis from the fault normal
    instead. Dashes where nothing falls, and for a mean whose resultant is below `LEAST_RESULTANT`.
    """
    model = model_of(cube)
    found = by_record(partial(fall_means, over=model.case_dims), cube, model.reads)
    means = []
    for index in range(cube.sizes["record"]):
        head, length = (float(found[name][index]) for name in ("mean_direction", "direction_resultant"))
        line, strength = (float(found[name][index]) for name in ("mean_axis", "axis_resultant"))
        shown = (head if length >= LEAST_RESULTANT else math.nan, line if strength >= LEAST_RESULTANT else math.nan)
        means.append((degrees(shown[0], 360), number(length), degrees(shown[1], 180), number(strength)))
    if not model.one_component:
        off = np.abs(wrap_axis(found["mean_axis"].to_numpy() - cube["fault_normal"].to_numpy()))
        return [(*cells, degrees(float(one))) for cells, one in zip(means, off, strict=True)]
    one = cube.isel(height=[0], friction=[cube.sizes["friction"] - 1])
    easiest = easiest_azimuth(boundary(one), cube["b_over_h"]).isel(height=0, friction=0)
    rows: list[tuple[str, ...]] = []
    for index, normal in enumerate(cube["fault_normal"].to_numpy()):
        best, ratio = float(easiest["easiest_axis"][index]), float(easiest["ratio"][index])
        bound = "" if math.isnan(ratio) or bool(easiest["bounded"][index]) else "≥ "
        apart = abs(float(wrap_axis(best - normal))) if np.isfinite(normal) else math.nan
        rows.append((*means[index], degrees(best, 180), degrees(apart), bound + number(ratio)))
    return rows
