"""`python -m verification.backwards_coverage [ruin] [coverage]`: how often `overturning backwards` holds the truth.

``ruin`` is the answer to the example ruin of docs/surveys.md; ``coverage`` the rest, all where neither is named.

Each survey is simulated under a record of an earthquake whose records are all taken out of the library, at a peak
velocity between the levels, each stone by itself in the kernel, with a friction, scatter, lapses and restitution of the
survey's own. The earthquakes are parted in two halves. On surveys of the one the power of the directions' likelihood is
chosen: the largest of `POWERS` with which each of the three intervals covers at least `AIM`. What is reported is of
surveys of the other half, with that power. Then the halves change places. The shipped power is to be the smaller of the
two.
"""

from dataclasses import dataclass
from typing import Annotated, Final

import numpy as np
import pandas as pd
import typer

from overturning.arrays import FloatArray
from overturning.dem.run import run
from overturning.model.cases import Cases
from overturning.model.shapes import Circle, Rectangle
from overturning.report.sections.surveys import backwards_sentences, cautions, draw_posterior
from overturning.statistics.bootstrap import Interval, bootstrap, unanimous_share_interval
from overturning.surveys.inversion import MIN_FIT_P_VALUE, POWER, Inversion
from overturning.surveys.library import CandidateMotion, candidates
from overturning.surveys.posterior import Posterior
from overturning.surveys.responses import LEVELS, Responses, StoneKind
from overturning.surveys.stones import Stone, read_survey
from verification.tables import RESULTS, ROOT, markdown, parts_of, publish, wrapped, write_csv

PARTS: Final = ("ruin", "coverage")
RUIN: Final = ROOT / "surveys" / "example-ruin.csv"
SURVEYS: Final = 392
SEED: Final = 26
POWERS: Final = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.7, 1.0)
AIM: Final = 0.9
CHECKED: Final = 16
"""One survey in so many is also checked for fit."""

HOLDS: Final = ["pgv_holds", "pga_holds", "axis_holds"]
"""Whether each interval holds the truth."""


@dataclass(frozen=True)
class Truth:
    """A survey and the motion under which it was simulated."""

    motion: CandidateMotion
    level: float
    axis: float
    stones: list[Stone]


def spread(generator: np.random.Generator, low: float, high: float, count: int) -> FloatArray:
    """Draws that are even in the logarithm."""
    return np.asarray(np.exp(generator.uniform(np.log(low), np.log(high), count)))


def survey(motion: CandidateMotion, generator: np.random.Generator) -> Truth:
    """Simulate a survey of 12 to 60 stones of all sizes: columns, or in one survey of three prisms of square plan."""
    draw, count = generator, int(generator.integers(12, 61))
    level, turn = float(spread(draw, LEVELS[0], LEVELS[-1], 1)[0]), draw.uniform(0, 360)
    # What differs between the stones of this survey, over its site, and by who measured.
    alike, site, lapses = draw.uniform(0, 0.12), draw.uniform(0, 0.15), draw.uniform(0, 0.06)
    friction = draw.uniform(0.45, 0.95) + draw.uniform(-0.05, 0.05, count)
    damping = np.exp(draw.uniform(-np.log(2), np.log(2)))
    columns = draw.random() < 2 / 3
    if columns:
        height, shape = spread(draw, 0.6, 3.6, count), spread(draw, 0.1, 0.6, count)
        face = np.full(count, np.nan)
    else:
        height = draw.uniform(0.6, 1.0, count)
        shape = spread(draw, 0.15, 0.6, count)
        face = draw.uniform(0, 360) + draw.uniform(-10, 10, count)
    turned = turn + draw.normal(0, 5, count)
    cases = Cases(
        np.nan_to_num(face) - turned,
        height,
        shape * np.exp(draw.normal(0, alike, count)),
        friction,
        level / motion.pgv * np.exp(draw.normal(0, site, count)),
        damping,
    )
    result = run(Circle() if columns else Rectangle(), motion.motion, cases)
    azimuth = result.fall_azimuth + turned + draw.normal(0, 8, count)
    fell = result.overturned == 1
    lapse = draw.random(count) < lapses
    fell, azimuth = (
        np.where(lapse, draw.random(count) < 0.5, fell),
        np.where(lapse, draw.uniform(0, 360, count), azimuth),
    )
    stones = [
        Stone(bool(fell[i]), float(azimuth[i] % 360) if fell[i] else np.nan, False, b_over_h=float(shape[i]),
              face_azimuth_deg=float(face[i]), height=float(height[i]), round=columns)
        for i in range(count) if lapse[i] or result.overturned[i] in (0, 1)
    ]  # fmt: skip
    return Truth(motion, level, (motion.axis + turn) % 180, stones)


def judged(one: Posterior, truth: Truth) -> dict[str, float]:
    """Which intervals hold the truth, and how wide they are."""
    found: dict[str, float] = {}
    pga = one.pga[:, None] * one.pgv
    true_pga = truth.level * truth.motion.pga / truth.motion.pgv
    for name, values, true in (("pgv", one.pgv, truth.level), ("pga", pga, true_pga)):
        (low, high), (least, most) = one.interval(values), one.interval(values, prior=True)
        found[f"{name}_holds"] = low <= true <= high
        # Where an end is missing, that of the prior stands for it.
        found[f"{name}_ratio"] = (most if high == np.inf else high) / (low or least)
        found[f"{name}_before"] = most / least
    weakest, strongest = one.interval(pga)
    middle, width = one.axis_arc(everything_fell=all(stone.fell for stone in truth.stones))
    found["axis_holds"] = abs((truth.axis - middle + 90) % 180 - 90) <= width / 2
    return found | {"axis_width": width, "no_upper": strongest == np.inf, "no_lower": weakest == 0}


def measured(surveys: int, threads: int) -> pd.DataFrame:
    """Every survey with every power, a line each; the records of the true earthquake are out of the library."""
    library = candidates()
    true = [one for one in library if one.event]
    events = sorted({one.event for one in true})
    truths = [survey(true[k % len(true)], np.random.default_rng([SEED, k])) for k in range(surveys)]
    kinds = [StoneKind.of(stone) for truth in truths for stone in truth.stones]
    inversion, rows = Inversion(Responses(library, kinds, threads=threads)), []
    for number, truth in enumerate(truths):
        prior = np.array([float(one.event != truth.motion.event) for one in library])[:, None, None]
        logs = inversion.log_likelihood(truth.stones)
        for power in POWERS:
            one = inversion.posterior(logs, prior=prior, power=power)
            checked = power == POWER and number % CHECKED == 0
            about = {
                "half": events.index(truth.motion.event) % 2, "power": power, "event": truth.motion.event,
                "record": truth.motion.name,
                "stones": len(truth.stones), "fell": np.mean([stone.fell for stone in truth.stones]),
                "round": truth.stones[0].round,
                "fit": inversion.fit(truth.stones, one) if checked else np.nan,
            }  # fmt: skip
            rows.append(about | judged(one, truth))
    return pd.DataFrame(rows)


def chosen(rows: pd.DataFrame) -> float:
    """The largest power with which each interval covers `AIM` of these surveys; the smallest where none does."""
    covered = rows.groupby("power")[HOLDS].mean().min(axis=1)
    good = covered.index[covered >= AIM]
    return float(good.max()) if good.size else POWERS[0]


def reported(rows: pd.DataFrame) -> pd.DataFrame:
    """The surveys of each half with the power that was chosen on the other."""
    halves = [(half, chosen(rows[rows["half"] != half])) for half in (0, 1)]
    return pd.concat([rows[(rows["half"] == half) & (rows["power"] == power)] for half, power in halves])


def share_interval(rows: pd.DataFrame, name: str) -> Interval:
    """Compute the 95 % interval of the share of surveys for which a column is true, by earthquake.

    Surveys under one earthquake share its motions, so earthquakes are drawn (`bootstrap`), each with all its surveys;
    there is none of fewer than eight. Where all surveys agree the bound is exact: n of n earthquakes hold with pⁿ.
    """
    of_event = rows.groupby("event")[name].agg(["sum", "size"]).to_numpy(np.float64)
    exact = unanimous_share_interval(of_event[:, 0] / of_event[:, 1])
    if exact is not None:
        return exact

    def of_sample(drawn: FloatArray) -> FloatArray:
        held, surveys = drawn.sum(axis=1).T
        return np.asarray(held / surveys)

    return bootstrap(of_sample, of_event)


def percent(rows: pd.DataFrame, name: str) -> str:
    """Share of surveys for which a column is true, with its interval where there is one."""
    low, high = share_interval(rows, name)
    bounds = "" if np.isnan(low) else f" ({100 * low:.0f} to {100 * high:.0f})"
    return f"{100 * rows[name].mean():.0f} %{bounds}"


def line(name: str, rows: pd.DataFrame) -> tuple[str, ...]:
    """Coverage and widths of some surveys."""
    powers = " and ".join(f"{power:g}" for power in sorted(rows["power"].unique()))
    held = (percent(rows, each) for each in HOLDS)
    shares = (f"{100 * rows[each].mean():.0f} %" for each in ("no_upper", "no_lower"))
    widths = (f"{rows[each].median():.3g}" for each in ("pgv_ratio", "pga_ratio", "axis_width"))
    return (name, f"{len(rows)}", f"{rows['event'].nunique()}", powers, *held, *shares, *widths)


def bodies(rows: pd.DataFrame) -> dict[str, str]:
    """What is published, by its mark."""
    shown, shipped = reported(rows), rows[rows["power"] == POWER]
    few = shown["stones"] < 36
    parts = {
        "**reported: all**": shown,
        **{f"half {half + 1} of the earthquakes": shown[shown["half"] == half] for half in (0, 1)},
        "columns": shown[shown["round"]], "gravestones": shown[~shown["round"]],
        "less than a tenth fell": shown[shown["fell"] < 0.1],
        "a tenth to nine tenths fell": shown[shown["fell"].between(0.1, 0.9)],
        "more than nine tenths fell, not all": shown[(shown["fell"] > 0.9) & (shown["fell"] < 1.0)],
        "every stone fell": shown[shown["fell"] == 1.0],
        "12 to 35 stones": shown[few], "36 to 60 stones": shown[~few],
        **{f"all, power {power:g}": rows[rows["power"] == power] for power in POWERS},
    }  # fmt: skip
    head = (
        "surveys", "number", "earthquakes", "power", "PGV holds", "PGA holds", "axis holds", "no upper bound",
        "no lower bound", "PGV, upper/lower", "PGA, upper/lower", "axis, width",
    )  # fmt: skip
    held = [100 * shown[each].mean() for each in HOLDS]
    fits = shipped["fit"].dropna()
    said = (
        f"Each interval, meant to hold the truth in {100 * AIM:.0f} %, holds it in {min(held):.0f} to "
        f"{max(held):.0f} % of the reported surveys. In brackets 95 % intervals over earthquakes, by bootstrap, exact "
        "where all agree, none of fewer than eight. Where every stone fell no axis is told: its arc is that of an axis "
        "of which nothing is known. Widths are medians, of 90 % intervals, the end of the library "
        "standing for a missing bound; before a survey upper over lower end are "
        f"{rows['pgv_before'].median():.3g} for PGV and {rows['pga_before'].median():.3g} for PGA, and the axis takes "
        f"162 of 180°. With the power that the package has, {POWER:g}, {100 * (fits < MIN_FIT_P_VALUE).mean():.1f} % "
        f"of {fits.size} such surveys are said not to fit."
    )
    return {"backwards-coverage": f"{wrapped(said)}\n\n{markdown(head, [line(*part) for part in parts.items()])}"}


def ruin(threads: int) -> str:
    """What the invented ruin says of the motion, as a list; draws its figure."""
    stones = read_survey(RUIN)
    inversion = Inversion(Responses(candidates(), [StoneKind.of(stone) for stone in stones], threads=threads))
    result = inversion.answer(RUIN.name, stones)
    draw_posterior(result, ROOT / "docs" / "images" / "example-ruin.svg")
    fit = f"p of the check whether the motions fit the survey: {result.fit:.2g}."
    return "\n".join(wrapped(text, "- ") for text in (*backwards_sentences(result), *cautions(result), fit))


def main(
    parts: Annotated[list[str] | None, typer.Argument(help=f"{', '.join(PARTS)}; both where none is named")] = None,
    surveys: Annotated[int, typer.Option(min=20, help="number of surveys")] = SURVEYS,
    threads: Annotated[int, typer.Option(min=1, help="number of threads")] = 2,
) -> None:
    """Simulate surveys, ask them, publish."""
    named = parts_of(parts, PARTS)
    if "ruin" in named:
        publish({"example-ruin": ruin(threads)})
    if "coverage" not in named:
        return
    rows = measured(surveys, threads)
    write_csv(reported(rows), RESULTS / "backwards-coverage.csv")
    publish(bodies(rows))
    print(
        f"powers chosen on the other half: {chosen(rows[rows['half'] == 1])}, {chosen(rows[rows['half'] == 0])}; "
        f"shipped {POWER}"
    )


if __name__ == "__main__":
    typer.run(main)
