"""Write fragility curves: CSV table and OpenQuake models."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np

from overturning.errors import ArgumentError
from overturning.files import atomic_write
from overturning.statistics.fragility import FittedFragilityCurve

OPENQUAKE_INTENSITY_LEVEL_COUNT: Final = 25
"""Number of intensities at which a curve is tabulated for OpenQuake."""


def write_fragility_csv(fragility_curves: Sequence[FittedFragilityCurve], csv_path: Path) -> None:
    """Write fragility curves to a CSV file, one row per curve.

    Columns: class of stones, intensity measure and unit, median with its interval, spread, range of the intensities,
    spreads between records and between stones, and OpenQuake identifier.

    The spreads are NaN if the median lies outside the range of the intensities, so that no curve can be drawn.
    """
    lines = ["stones,measure,unit,median,median_low,median_high,log_spread,least,most,record_spread,other_spread,id"]
    for one in fragility_curves:
        median, ends, spread = one.median_interval_and_log_std_censored_to_data
        values = (
            median,
            *ends,
            spread,
            one.min_intensity_of_validity_range,
            one.max_intensity_of_validity_range,
            *one.log_std_between_records_and_between_stones,
        )
        numbers = ",".join(f"{value:.6g}" for value in values)
        lines.append(
            f'"{one.stone_class}",{one.measure},{one.unit},{numbers},{one.stone_class_as_openquake_identifier}'
        )
    with atomic_write(csv_path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")


def openquake_file_name(intensity_measure_name: str) -> str:
    """Return the name of the OpenQuake file for an intensity measure, such as ``fragility-sa-0.5.xml``."""
    return f"fragility-{intensity_measure_name.lower().replace('(', '-').rstrip(')')}.xml"


def is_openquake_measure(intensity_measure_name: str) -> bool:
    """True if OpenQuake knows the intensity measure named `intensity_measure_name`: PGA, PGV or SA(period)."""
    return re.fullmatch(r"PG[AV]|SA\([0-9.]+\)", intensity_measure_name) is not None


def write_openquake_fragility_model(
    fragility_curves: Sequence[FittedFragilityCurve], xml_path: Path, openquake_model_id: str
) -> None:
    """Write the fragility curves of one intensity measure as an OpenQuake model file (NRML 0.5, discrete functions).

    The limit state is ``fallen``; curves without a fit are left out. The intensity levels stay within the fitted range,
    even if the probability at the largest level is below one half. PGA and SA have to be in g and PGV in cm/s, as
    OpenQuake requires. The id of a function is `FittedFragilityCurve.stone_class_as_openquake_identifier`, which an
    exposure model uses as taxonomy.

    Raises
    ------
    ArgumentError
        If the curves have different measures, or one that OpenQuake does not have.
    """
    measures = {one.measure for one in fragility_curves}
    if len(measures) != 1 or not all(map(is_openquake_measure, measures)):
        raise ArgumentError(
            f"curves of {', '.join(sorted(measures)) or 'nothing'}; give those of PGA or PGV, or of one SA(period)"
        )
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<nrml xmlns="http://openquake.org/xmlns/nrml/0.5">',
        f'<fragilityModel id={quoteattr(openquake_model_id)} assetCategory="contents" lossCategory="contents">',
        "<description>Falls of gravestones, computed; nothing is known beyond the levels of a function</description>",
        "<limitStates>fallen</limitStates>",
    ]
    for one in fragility_curves:
        if not math.isfinite(one.median):
            continue
        levels = np.geomspace(
            one.min_intensity_of_validity_range, one.max_intensity_of_validity_range, OPENQUAKE_INTENSITY_LEVEL_COUNT
        )
        intensities = " ".join(f"{value:.6g}" for value in levels)
        probabilities = " ".join(f"{value:.6f}" for value in one.fall_probability(levels))
        lines += [
            f'<fragilityFunction id={quoteattr(one.stone_class_as_openquake_identifier)} format="discrete">',
            f'<imls imt="{one.measure}" noDamageLimit="{one.min_intensity_of_validity_range:.6g}">{intensities}</imls>',
            f'<poes ls="fallen">{probabilities}</poes>',
            "</fragilityFunction>",
        ]
    lines += ["</fragilityModel>", "</nrml>"]
    with atomic_write(xml_path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")
