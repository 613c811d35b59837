"""What soft ground changes: fall rate and direction through the soil of each variant beside the records as they are."""

from typing import Final

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.records.steps import Site
from overturning.report.blocks import Answer, Block, Note, Paragraph, Section, Table
from overturning.report.results import Results
from overturning.report.text import degrees, number, percent
from overturning.statistics.circular import wrap_axis
from overturning.study.cube import processing_of
from overturning.study.scenes import NOMINAL, site_of
from overturning.units import STANDARD_GRAVITY

LEAST_FALLS: Final = 0.05
"""Fall rate from which the falls of a record have an axis to compare."""


def ground(results: Results) -> Section | None:
    """Variants through soil beside the study's own motions; none where there are none, or no population."""
    names = [name for name in results.study.variants if site_of(results.study, name)]
    if not names or not results.populations:
        return None
    amplitude = results.populations[NOMINAL]["amplitude"].to_numpy()
    blocks: list[Block] = [
        Answer(tuple(_sentence(results, names, float(factor)) for factor in amplitude)),
        _table(results, names),
    ]
    blocks += [Paragraph(_converged(results, names)), Note(_limits(results, names))]
    return Section("What soft ground changes", tuple(blocks), anchor="ground")


def _soil(site: Site) -> str:
    return " over ".join(f"{one.thickness_m:g} m of soil ({one.velocity_m_s:g} m/s)" for one in site.layers)


def _grounds(results: Results, names: list[str]) -> dict[str, str]:
    """The names of the cubes with what each ground is called."""
    sites = {name: site_of(results.study, name) for name in names}
    return {NOMINAL: "rock"} | {name: _soil(site) for name, site in sites.items() if site is not None}


def turned(ground: xr.Dataset, rock: xr.Dataset) -> FloatArray:
    """Angles, degrees, by which the fall axes of records differ from those on rock, where enough falls on both."""
    enough = np.minimum(ground["fall_rate"].to_numpy(), rock["fall_rate"].to_numpy()) >= LEAST_FALLS
    apart = np.abs(wrap_axis(ground["fall_axis"].to_numpy() - rock["fall_axis"].to_numpy()))
    return np.asarray(apart[enough & np.isfinite(apart)])


def _at(results: Results, name: str, factor: float) -> xr.Dataset:
    return results.populations[name].sel(amplitude=factor)


def _sentence(results: Results, names: list[str], factor: float) -> str:
    rock, parts = _at(results, NOMINAL, factor), []
    for name, soil in _grounds(results, names).items():
        found = _at(results, name, factor)
        angle = turned(found, rock)
        axis = (
            f", the axis of falls turned by {degrees(float(np.median(angle)))}"
            if name != NOMINAL and angle.size
            else ""
        )
        over = "on" if name == NOMINAL else "through"
        parts.append(f"{percent(float(found['fall_rate'].mean()))} {over} {soil}{axis}")
    times = "as they are" if factor == 1 else f"times {factor:g}"
    told = " (turns are medians over the records)" if any("turned" in part for part in parts) else ""
    return f"Under the records {times} the mean fall rate is {'; '.join(parts)}{told}."


def _table(results: Results, names: list[str]) -> Table:
    rows = []
    for factor in results.populations[NOMINAL]["amplitude"].to_numpy():
        for name, soil in _grounds(results, names).items():
            found = _at(results, name, float(factor))
            rate, angle = found["fall_rate"].to_numpy(), turned(found, _at(results, NOMINAL, float(factor)))
            accounts = processing_of(results.cubes[name]).values()
            pga = np.median([one["peaks"]["pga"][1] for one in accounts]) * factor / STANDARD_GRAVITY
            shift = f"{degrees(float(np.median(angle)))} ({angle.size})" if name != NOMINAL and angle.size else "–"
            rows.append((
                f"{factor:g}", soil, number(float(pga)), percent(float(rate.mean())), percent(float(np.median(rate))),
                str(int((rate >= 0.5).sum())), shift,
            ))  # fmt: skip
    heads = (
        "factor", "ground", "PGA, g, median", "fall rate, mean", "median", "records with half or more",
        "axis turned, median (records)",
    )  # fmt: skip
    return Table(heads, tuple(rows), "nt", anchor="soft-ground")


def failures(results: Results, names: list[str]) -> list[str]:
    """Which iterations did not converge: record, soil, and what the computation says of its components."""
    found = []
    for name in names:
        for record, account in processing_of(results.cubes[name]).items():
            said = (account["steps"] or [{}])[-1].get("chosen", "")
            parts = [part for part in said.split("; ") if "not converged" in part]
            found += [f"{record}, {_grounds(results, names)[name]}: {'; '.join(parts)}"] if parts else []
    return found


def _converged(results: Results, names: list[str]) -> str:
    failed, motions = failures(results, names), len(names) * len(results.names)
    if not failed:
        return f"Every iteration of the {motions} motions converged."
    have = "has" if len(failed) == 1 else "have"
    return f"{len(failed)} of {motions} motions {have} an iteration that did not converge: {'. '.join(failed)}."


def _limits(results: Results, names: list[str]) -> str:
    rates = (
        " PGA is that of the larger of north and east. Axes are compared where 5 % of the stones or more fall on both "
        "grounds."
    )
    vertical = " The vertical motion is that of the record." if results.with_vertical else ""
    over = {site.rock.velocity_m_s for name in names if (site := site_of(results.study, name)) is not None}
    return (
        "The records are taken for rock, over which the soil lies (half-space of "
        f"{' and '.join(f'{v:g}' for v in sorted(over))} m/s); "
        "some of them were taken on soil themselves, so this is what a layer changes and not what happened there. "
        "Strong motion "
        "on soft clay takes an equivalent-linear computation to strains where it is no longer "
        f"trusted.{vertical}{rates}"
    )
