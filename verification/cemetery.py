"""`python -m verification.cemetery`: the default study's fall rates beside published ones, and the field's criteria.

Needs `results/near-fault` and `results/in-space`, from `make run`; writes its parts of docs/surveys.md and
docs/criteria.md, and how good planes are in space.
"""

import shutil
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import xarray as xr

from overturning.arrays import FloatArray
from overturning.dem.run import run_cases
from overturning.figures.style import FALLS, INK, SERIES, caption, grid, labels, style
from overturning.figures.write import save
from overturning.model.cases import Cases
from overturning.records.store import read_motion
from overturning.report.blocks import Paragraph, Report, Table, each_block
from overturning.report.results import Results, open_results
from overturning.report.sections.causes import criteria
from overturning.report.sections.population import population
from overturning.statistics.space import plane_agreement, plane_counts
from overturning.study.cube import open_cube
from overturning.study.load import load_study
from overturning.study.scenes import NOMINAL, motion_of
from overturning.study.sweep import scaled
from overturning.surveys.population import draw_stones
from verification.tables import RESULTS, ROOT, Figure, lines_of, markdown, publish, wrapped, write_figures

STUDY: Final = ROOT / "results" / "near-fault"
PUBLISHED: Final = ROOT / "surveys" / "published.csv"


def published(path: Path = PUBLISHED) -> pd.DataFrame:
    """The published statements."""
    return pd.read_csv(path)


def as_recorded(found: xr.Dataset) -> FloatArray:
    """Fall rate under each record as it was recorded, percent."""
    return np.asarray(100 * found["fall_rate"].sel(amplitude=1.0).to_numpy())


def verdict(low: float, high: float, rates: FloatArray) -> str:
    """Whether the middle half of the computed rates overlaps with what was stated, of which an end may be missing."""
    least, most = np.quantile(rates, [0.25, 0.75])
    if high < least:
        return "below the middle half"
    if low > most:
        return "above the middle half"
    return "overlaps"


def stated(low: float, high: float) -> str:
    """A stated rate as text."""
    if np.isnan(low):
        return f"at most {high:g} %"
    if np.isnan(high):
        return f"more than {low:g} %"
    return f"{low:g} %" if low == high else f"{low:g} to {high:g} %"


def table(rows: pd.DataFrame, rates: FloatArray) -> str:
    """Near-field statements beside the computed rates."""
    lines = []
    for row in lines_of(rows[rows["near_field"] == "yes"]):
        low, high = row.rate_low_percent, row.rate_high_percent
        ends = (0.0 if np.isnan(low) else low, 100.0 if np.isnan(high) else high)
        lines.append((row.event, row.where, stated(low, high), verdict(*ends, rates), row.source))
    return markdown(("earthquake", "where", "stated", "beside the computed rates", "source"), lines)


def sentence(rates: FloatArray, found: xr.Dataset) -> str:
    """The computed rates in words."""
    low, middle, high = np.quantile(rates, [0.25, 0.5, 0.75])
    events = len(set(found["event"].to_numpy().astype(str)))
    none, most = int((rates < 1).sum()), int((rates > 99).sum())
    return wrapped(
        f"Computed for the {rates.size} near-field records of {events} earthquakes as recorded: median {middle:.0f} %, "
        f"the middle half {low:.0f} to {high:.0f} %, all {rates.min():.0f} to {rates.max():.0f} %; under {none} "
        f"records less than 1 % fall, under {most} more than 99 %."
    )


def draw(rows: pd.DataFrame, rates: FloatArray, path: Path) -> None:
    """Draw stated rates as bars above the computed ones as points."""
    near = list(lines_of(rows[rows["near_field"] == "yes"]))
    with style():
        figure, panels = grid(1, 1, 8.0, 0.32 * len(near) + 1.8)
        axes: Any = panels[0, 0]
        for place, row in enumerate(near[::-1], 1):
            low = 0.0 if np.isnan(row.rate_low_percent) else row.rate_low_percent
            high = 100.0 if np.isnan(row.rate_high_percent) else row.rate_high_percent
            axes.plot([low, high], [place, place], color=SERIES[0], linewidth=6, solid_capstyle="butt")
            if low == high:
                axes.plot(low, place, "o", color=SERIES[0])
        axes.plot(rates, np.zeros(rates.size), "|", color=FALLS, markersize=13)
        axes.plot(np.median(rates), 0, "D", color=INK, markersize=5)
        names = [f"{row.event}: {row.where}" for row in near[::-1]]
        axes.set_yticks(range(len(near) + 1), ["computed, each near-field record (median)", *names])
        axes.set_xlim(-2, 102)
        axes.grid(True, axis="x")
        labels(axes, "fall rate, %", "")
        caption(figure, "Published fall rates of the near field, and computed ones")
        save(figure, path)


def cemetery(results: Results) -> str:
    """What the report of the default study says of its population, as a list; takes its figure."""
    section = population(results)
    assert section is not None
    shutil.copy(results.drawings / "fall-rate.svg", ROOT / "docs" / "images" / "fall-rate.svg")
    return "\n".join(wrapped(block.text, "- ") for block in section.blocks if type(block) is Paragraph)


def criteria_tables(results: Results) -> dict[str, str]:
    """What the report says of the field's criteria, by mark; takes its figure."""
    section = criteria(results)
    assert section is not None
    shutil.copy(results.figures / "plane.svg", ROOT / "docs" / "images" / "criteria.svg")
    whole, blocks = (block for block in each_block(Report("", "", (section,))) if isinstance(block, Table))
    said = next(block.text for block in section.blocks if isinstance(block, Paragraph))
    return {
        "criteria": f"{wrapped(said)}\n\n{markdown(whole.heads, whole.rows)}",
        "criteria-blocks": markdown(blocks.heads, blocks.rows),
    }


def one_by_one(results: Results) -> str:
    """How far the rates are from those of the same stones, each run with its own height, B/H and µ."""
    found, population_ = results.populations[NOMINAL], results.study.population
    assert population_ is not None
    stones, rates = draw_stones(population_), []
    planes = np.concatenate([stones.face, stones.face + 90])
    cases = Cases(planes, np.tile(stones.height, 2), np.tile(stones.b_over_h, 2), np.tile(stones.friction, 2))
    for name in results.names:
        motion = motion_of(results.study, read_motion(STUDY / "motion" / f"{name.id}.nc"))
        for factor in found["amplitude"].to_numpy():
            flags = run_cases(scaled(motion, float(factor)), cases, threads=2).overturned
            rates.append(float((np.abs(flags) == 1).reshape(2, -1).any(axis=0).mean()))
    computed = found["fall_rate"].to_numpy().ravel()
    apart = 100 * np.abs(np.array(rates) - computed)
    return (
        f"The same stones, each run by itself under each of these motions ({apart.size} of them), fall at "
        f"{100 * np.mean(rates):.1f} % in the mean, those taken from the cube at {100 * computed.mean():.1f} %; the "
        f"rate of a motion differs by {apart.mean():.1f} percentage points in the mean, at most by {apart.max():.0f}."
    )


def planes() -> list[Figure]:
    """How well the planes of a stone's faces tell what it does in space."""
    with open_cube(ROOT / "results" / "in-space" / "cube.nc", chunks={"record": 1}) as cube:
        found = {name: float(one) for name, one in plane_agreement(plane_counts(cube)).items()}
    beside = 100 * found["flag_beside"]
    return [
        Figure("cases in space", int(found["cases"])),
        Figure("2-D model predicts correctly whether it falls", 100 * found["flag"], "%"),
        Figure("2-D model predicts correctly whether it falls, a neighbour in B/H has another flag", beside, "%"),
        Figure("2-D model predicts another edge than the one it falls over", 100 * (1 - found["face"]), "%"),
    ]


def main() -> None:
    """Compare, draw, publish."""
    write_figures(planes(), RESULTS / "in-space.csv")
    study = load_study(ROOT / "config" / "near-fault.yaml")
    with open_results(STUDY, study) as results:
        found = results.populations[NOMINAL]
        publish({"population": f"{cemetery(results)}\n{wrapped(one_by_one(results), '- ')}"})
        publish(criteria_tables(results))
        rows, rates = published(), as_recorded(found)
        draw(rows, rates, ROOT / "docs" / "images" / "published-surveys.svg")
        publish({"published-surveys": table(rows, rates), "published-surveys-computed": sentence(rates, found)})


if __name__ == "__main__":
    main()
