"""What soft ground changes: the fall rates and axes of a cemetery beside those on rock."""

from typing import Final

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.records.site import Site
from overturning.report.blocks import Answer, Note, Said, section, table
from overturning.report.results import Results
from overturning.report.sections.population import caution
from overturning.report.text import degrees, percent
from overturning.statistics.circular import LEAST_RESULTANT, wrap_axis
from overturning.study.cube import record_provenance
from overturning.study.scenes import NOMINAL, variant_settings
from overturning.units import STANDARD_GRAVITY

LEAST_FALLS: Final = 0.05
"""Fall rate from which the falls of a record have an axis to compare."""


@section("What soft ground changes", "ground")
def ground(results: Results) -> Said:
    """Variants through soil beside the study's own motions; none where there are none, or no population."""
    sites = {name: site for name in results.study.variants if (site := variant_settings(results.study, name).site)}
    if not sites or not results.populations:
        return
    layers = {name: _soil(site) for name, site in sites.items()}
    soils = list(layers.values())  # soils may differ in what is not said of them
    grounds = {NOMINAL: "rock"}
    grounds |= {name: soil if soils.count(soil) == 1 else f"{name}: {soil}" for name, soil in layers.items()}
    sentences, rows = [], []
    for factor in map(float, results.populations[NOMINAL]["amplitude"].to_numpy()):
        found = {name: results.populations[name].sel(amplitude=factor) for name in grounds}
        angles = {name: turned(found[name], found[NOMINAL]) for name in sites}
        turns = {name: degrees(float(np.median(angle))) for name, angle in angles.items() if angle.size}
        sentences.append(_sentence(grounds, found, turns, factor))
        for name, soil in grounds.items():
            rate, accounts = found[name]["fall_rate"], record_provenance(results.cubes[name]).values()
            pga = np.median([one["peaks"]["pga"][1] for one in accounts]) * factor / STANDARD_GRAVITY
            shift = f"{turns[name]} ({angles[name].size})" if name in turns else "–"
            rates = (float(rate.mean()), float(rate.median()), int((rate >= 0.5).sum()))
            rows.append((factor, soil, float(pga), *rates, shift))
    heads = ("factor", "ground", "PGA, g, median", "fall rate, mean", "median", "records with half or more")
    yield Answer(tuple(sentences))
    yield from caution(results.populations[NOMINAL])
    yield table((*heads, "axis turned, median (records)"), rows, "gt2%%", anchor="soft-ground")
    curved = {name: any(layer.curve for layer in site.layers) for name, site in sites.items()}
    said, motions = list[str](), sum(curved.values()) * len(results.record_names)
    if failed := failures(results, grounds):
        many = f"{len(failed)} of {motions} motions {'has' if len(failed) == 1 else 'have'}"
        said.append(f"{many} an iteration that did not converge: {'. '.join(failed)}.")
    elif motions:
        said.append(f"Every iteration of the {motions} motions converged.")
    if linear := [grounds[name] for name, curves in curved.items() if not curves]:
        are, them = ("is", "it") if len(linear) == 1 else ("are", "them")
        said.append(f"{' and '.join(linear)} {are} linear: strong motion softens {them} no more than weak.")
    yield " ".join(said)
    soften = (
        ": stronger records would soften the soil more. Strong motion on soft clay takes an equivalent-linear "
        "computation to strains where it is no longer trusted"
    )
    velocities = sorted({site.rock.velocity_m_s for site in sites.values()})
    vertical = " The vertical motion is that of the record." if results.records_with_vertical else ""
    yield Note(
        "The records are taken for rock, over which the soil lies (half-space of "
        f"{' and '.join(f'{velocity:g}' for velocity in velocities)} m/s); some of them were taken on soil themselves, "
        "so this is what a layer changes and not what happened there. A factor multiplies what comes through the "
        f"soil{soften if motions else ''}.{vertical} PGA is that of the larger of north and east. Axes are compared "
        "where 5 % of the stones or more fall on both grounds, and not every way alike. Means and medians here are "
        "over records, not over earthquakes."
    )


def _soil(site: Site) -> str:
    return " over ".join(f"{one.thickness_m:g} m of soil ({one.velocity_m_s:g} m/s)" for one in site.layers)


def turned(ground: xr.Dataset, rock: xr.Dataset) -> FloatArray:
    """Angles, degrees, by which the fall axes of records differ from those on rock, where both have one."""
    apart = np.abs(wrap_axis(ground["fall_axis"].to_numpy() - rock["fall_axis"].to_numpy()))
    for found in (ground, rock):
        clear = (found["fall_rate"] >= LEAST_FALLS) & (found["fall_resultant"] >= LEAST_RESULTANT)
        apart = np.where(clear, apart, np.nan)
    return np.asarray(apart[np.isfinite(apart)])


def _sentence(grounds: dict[str, str], found: dict[str, xr.Dataset], turns: dict[str, str], factor: float) -> str:
    """Mean fall rate on each ground, and how far the axes of falls are turned there."""
    parts = []
    for name, soil in grounds.items():
        axis = f", the axis of falls turned by {turns[name]}" if name in turns else ""
        over = "on" if name == NOMINAL else "through"
        parts.append(f"{percent(float(found[name]['fall_rate'].mean()))} {over} {soil}{axis}")
    under = "Under the records as they are" if factor == 1 else f"Under the motions at the surface times {factor:g}"
    how = " (turns are medians over the records)" if turns else ""
    return f"{under} the mean fall rate is {'; '.join(parts)}{how}."


def failures(results: Results, grounds: dict[str, str]) -> list[str]:
    """Which iterations did not converge: record, soil, and what the computation says of its components."""
    found = []
    for name, soil in grounds.items():
        for record, account in record_provenance(results.cubes[name]).items() if name != NOMINAL else ():
            said = (account["steps"] or [{}])[-1].get("chosen", "")
            parts = [part for part in said.split("; ") if "not converged" in part]
            found += [f"{record}, {soil}: {'; '.join(parts)}"] if parts else []
    return found
