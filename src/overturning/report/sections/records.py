"""The records: their peaks, where blocks fall under each, where they were recorded, and their figures."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from overturning.report.blocks import Block, Column, Figure, Note, Row, Section, Table, number_columns, text_columns
from overturning.report.results import Results
from overturning.report.text import degrees, number, percent
from overturning.statistics.boundary import boundary, easiest_azimuth
from overturning.statistics.circular import wrap_axis
from overturning.statistics.direction import fall_axis, fall_direction
from overturning.statistics.falls import overturns
from overturning.units import CM, GAL

if TYPE_CHECKING:
    import xarray as xr


def records(results: Results) -> Section:
    """Peaks of each record, directions of its falls, maps of the stations."""
    blocks: list[Block] = [
        _peaks(results),
        Note(
            "Azimuths in degrees clockwise from north. Peaks are the largest over the azimuths of the study, each with the "
            "azimuth along which it is reached. Overturned: share of the record's cases."
        ),
        Note("A click on a heading sorts.", medium="page"),
    ]
    if results.fallen > 0:
        blocks.append(_directions(results))
    if maps := _maps(results):
        pairs = [Row(maps[i : i + 2], shares=(1.0, 1.0)) for i in range(0, len(maps), 2)]
        about = Note(
            "Stations and epicentres as the records or the record table state them; a fault whose strike is known is drawn "
            "through the epicentre."
        )
        blocks += [*pairs, about]
    return Section("Records", tuple(blocks), anchor="records")


def record_by_record(results: Results) -> Section:
    """The figures of each record."""
    sections = []
    for name in results.names:
        polar = Figure(results.figures / "polar" / f"{name.id}.png", "where blocks fall, by azimuth and B/H")
        peaks = Figure(results.figures / "intensity" / f"{name.id}.png", "peak acceleration and velocity by azimuth")
        pair = Row((polar, peaks), shares=(1.25, 1.0))
        sections.append(Section(name.heading, (pair,), anchor=name.id, together=True))
    return Section("Record by record", tuple(sections), anchor="figures")


def _peaks(results: Results) -> Table:
    """One row per record: names, largest intensities with their azimuths, share of cases that overturn."""
    shares = overturns(results.cube).mean(["azimuth", "height", "b_over_h", "friction"]).compute().to_numpy()
    pulses, normals = (results.cube[name].to_numpy().astype(float) for name in ("pulse", "fault_normal"))
    azimuth = results.intensity["azimuth"].to_numpy()
    rows = []
    for index, name in enumerate(results.names):
        cells = []
        for measure, unit, digits in (("pga", GAL, 0), ("pgv", CM, 1), ("pgd", CM, 1)):
            values = results.intensity[measure].isel(record=index).to_numpy()
            cells += [f"{values.max() / unit:.{digits}f}", degrees(float(azimuth[int(values.argmax())] % 180))]
        pulse = {1.0: "yes", 0.0: "no"}.get(float(pulses[index]), "–")
        # The azimuth of the PGD is left out: it hangs on the filter.
        named = (name.id, name.station, name.event, pulse, degrees(float(normals[index])))
        rows.append((*named, *cells[:-1], percent(float(shares[index]))))
    columns = (
        Column("record", "link"),
        *text_columns("station", "earthquake", "pulse"),
        *number_columns("fault normal", "PGA, Gal", "along", "PGV, cm/s", "along", "PGD, cm", "overturned"),
    )
    return Table(columns, tuple(rows), anchor="peaks", sortable=True)


def _directions(results: Results) -> Section:
    heads = (
        *("mean fall direction", "resultant", "mean fall axis", "resultant", "easiest axis", "from the fault normal"),
        "easier by",
    )
    rows = tuple(
        (name.id, *vars(row).values()) for name, row in zip(results.names, record_directions(results.cube), strict=True)
    )
    note = Note(
        "Over all cases of a record, each plane once. A direction has a head (towards 60°), an axis has none (60° and 240° "
        "are the same); a resultant of 1 means all falls alike, of 0 falls to every side alike. Easiest axis: along it the "
        "lowest block at the highest friction overturns up to the largest B/H; easier by: that B/H over the one of the "
        "hardest azimuth."
    )
    table = Table((Column("record", "link"), *number_columns(*heads)), rows, anchor="directions", sortable=True)
    return Section("Where blocks fall, by record", (table, note))


def _maps(results: Results) -> tuple[Figure, ...]:
    """The map of each earthquake whose epicentre or stations are known, with the distances."""
    from overturning.figures.site_map import distances, sites_by_earthquake

    return tuple(
        Figure(results.figures / "maps" / f"{number}.svg", f"map: {event}", " ".join(distances(site)))
        for number, (event, site) in enumerate(sites_by_earthquake(results.cube).items(), 1)
    )


@dataclass(frozen=True)
class RecordDirection:
    """Where blocks fall under one record, as cells of a table: dashes where nothing falls.

    Attributes
    ----------
    direction, direction_resultant : str
        Mean fall direction over all cases of the record.
    axis, axis_resultant : str
        Mean fall axis over them.
    easiest, easiest_from_normal, ratio : str
        Azimuth of easiest overturning of the lowest block at the highest friction, its angle from the fault normal, and
        the largest B/H along it over that along the hardest azimuth.
    """

    direction: str
    direction_resultant: str
    axis: str
    axis_resultant: str
    easiest: str
    easiest_from_normal: str
    ratio: str


def record_directions(cube: "xr.Dataset") -> list[RecordDirection]:
    """Where blocks fall under each record of a cube."""
    over = ("height", "b_over_h", "friction")
    direction, axis = fall_direction(cube, over=over).compute(), fall_axis(cube, over=over).compute()
    one = cube.isel(height=[0], friction=[cube.sizes["friction"] - 1])
    easiest = easiest_azimuth(boundary(one), cube["b_over_h"]).isel(height=0, friction=0)
    normals = cube["fault_normal"].to_numpy()
    rows = []
    for index in range(cube.sizes["record"]):
        best, ratio = float(easiest["easiest_axis"][index]), float(easiest["ratio"][index])
        bound = "" if math.isnan(ratio) or bool(easiest["bounded"][index]) else "≥ "
        apart = abs(float(wrap_axis(best - normals[index]))) if np.isfinite(normals[index]) else math.nan
        rows.append(
            RecordDirection(
                degrees(float(direction["mean_direction"][index]), 360),
                number(float(direction["direction_resultant"][index])),
                degrees(float(axis["mean_axis"][index]), 180),
                number(float(axis["axis_resultant"][index])),
                degrees(best, 180),
                degrees(apart),
                bound + number(ratio),
            )
        )
    return rows
