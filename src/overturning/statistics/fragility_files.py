"""Fragility curves as files: a table, and models for OpenQuake."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np

from overturning.errors import ArgumentError
from overturning.files import atomic_write
from overturning.statistics.fragility import Fragility

LEVELS: Final = 25
"""Number of intensities at which a curve is written."""


def write_fragility_csv(curves: Sequence[Fragility], path: Path) -> None:
    """Write curves as a table: class, measure, unit, median, interval and spread as `within_data`, range, `spreads`.

    Where the median lies beyond the data, the spread is missing too: both would be a curve where nothing is known.
    """
    lines = ["stones,measure,unit,median,median_low,median_high,log_spread,least,most,record_spread,other_spread,id"]
    for one in curves:
        median, ends, spread = one.within_data
        values = (median, *ends, spread, one.least, one.most, *one.spreads)
        numbers = ",".join(f"{value:.6g}" for value in values)
        lines.append(f'"{one.name}",{one.measure},{one.unit},{numbers},{one.identifier}')
    with atomic_write(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")


def measure_file(measure: str) -> str:
    """Name of the OpenQuake model of a measure: ``fragility-pga.xml``, ``fragility-sa-0.5.xml``."""
    return f"fragility-{measure.lower().replace('(', '-').rstrip(')')}.xml"


def for_openquake(measure: str) -> bool:
    """True if OpenQuake supports a measure: PGA, PGV or SA(period)."""
    return re.fullmatch(r"PG[AV]|SA\([0-9.]+\)", measure) is not None


def write_openquake(curves: Sequence[Fragility], path: Path, identifier: str) -> None:
    """Write the curves of one measure as an OpenQuake fragility model (NRML 0.5, discrete functions).

    The limit state is ``fallen``; curves that do not exist are left out. Levels are those of the data alone, also where
    the probability has not reached one half at the last. PGA and SA are in g and PGV in cm/s, as OpenQuake has it.
    Functions have the `identifier` of their class, which an exposure has as its taxonomy.

    Raises
    ------
    ArgumentError
        If the curves are of several measures, or of one that OpenQuake does not know.
    """
    measures = {one.measure for one in curves}
    if len(measures) != 1 or not all(map(for_openquake, measures)):
        raise ArgumentError(
            f"curves of {', '.join(sorted(measures)) or 'nothing'}; give those of PGA or PGV, or of one SA(period)"
        )
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<nrml xmlns="http://openquake.org/xmlns/nrml/0.5">',
        f'<fragilityModel id={quoteattr(identifier)} assetCategory="contents" lossCategory="contents">',
        "<description>Falls of gravestones, computed; nothing is known beyond the levels of a function</description>",
        "<limitStates>fallen</limitStates>",
    ]
    for one in curves:
        if not math.isfinite(one.median):
            continue
        levels = np.geomspace(one.least, one.most, LEVELS)
        intensities = " ".join(f"{value:.6g}" for value in levels)
        probabilities = " ".join(f"{value:.6f}" for value in one.probability(levels))
        lines += [
            f'<fragilityFunction id={quoteattr(one.identifier)} format="discrete">',
            f'<imls imt="{one.measure}" noDamageLimit="{one.least:.6g}">{intensities}</imls>',
            f'<poes ls="fallen">{probabilities}</poes>',
            "</fragilityFunction>",
        ]
    lines += ["</fragilityModel>", "</nrml>"]
    with atomic_write(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")
