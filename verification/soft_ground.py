"""`python -m verification.soft_ground`: the default records on rock and through soft soil; needs the group `soil`.

Fall rates of the default population and directions of its falls, through 10, 20 and 40 m of soft clay, equivalent-linear.
"""

from typing import Final

import numpy as np
import pandas as pd

from overturning.arrays import FloatArray
from overturning.motion.motion import Motion
from overturning.motion.soil import Soil, fundamental_period, through_soil
from overturning.statistics.circular import resultant
from overturning.study.population import Population
from overturning.surveys.population import OUTCOMES, UNKNOWN, Stones, draw_stones, stone_outcomes
from verification.inputs import near_fault
from verification.tables import RESULTS, lines_of, markdown, publish, wrapped, write_csv

CURVE: Final = "Vucetic & Dobry (91), PI=30"
VELOCITY: Final = 150.0
ROCK: Final = Soil(0, 760, 2200, 0.01)
THICKNESSES: Final = (10, 20, 40)
FACTORS: Final = np.array([1.0, 1.5])
"""On the records: as recorded hardly a stone of the default population falls on rock."""


def on_soil(motion: Motion, layers: list[Soil]) -> tuple[Motion, list[str]]:
    """A motion at the surface, and which of its components did not converge."""
    passed = {name: through_soil(getattr(motion, name), motion.sampling_interval, layers) for name in ("north", "east")}
    failed = [f"{name} ({100 * one.change:.0f} %)" for name, one in passed.items() if not one.converged]
    return Motion(passed["north"].samples, passed["east"].samples, sampling_interval=motion.sampling_interval), failed


def row(name: str, soil: str, motion: Motion, stones: Stones, failed: list[str]) -> list[dict[str, object]]:
    """Fall rate and axis of one record on one ground, for each factor."""
    outcome, azimuth = stone_outcomes(motion, stones, FACTORS)
    made: list[dict[str, object]] = []
    for factor, what, towards in zip(FACTORS, outcome, azimuth, strict=True):
        fell = what == OUTCOMES.index("fell")
        axis = resultant(towards[fell], axial=True) if fell.any() else (float("nan"), float("nan"))
        made.append({
            "record": name, "ground": soil, "factor": factor, "fall_rate": fell.sum() / (what != UNKNOWN).sum(),
            "axis_deg": axis[0], "axis_resultant": axis[1], "pga": float(np.hypot(motion.north, motion.east).max()),
            "not_converged": ", ".join(failed),
        })  # fmt: skip
    return made


def measure() -> pd.DataFrame:
    """All records on all grounds."""
    stones, rows = draw_stones(Population()), []
    for name, motion in near_fault().items():
        rock = Motion(motion.north, motion.east, sampling_interval=motion.sampling_interval)
        rows += row(name, "rock", rock, stones, [])
        for thickness in THICKNESSES:
            layers = [Soil(thickness, VELOCITY, 1800, 0.03, CURVE), ROCK]
            rows += row(name, f"{thickness} m", *_with(on_soil(motion, layers), stones))
    return pd.DataFrame(rows)


def _with(found: tuple[Motion, list[str]], stones: Stones) -> tuple[Motion, Stones, list[str]]:
    return found[0], stones, found[1]


def turned(rows: pd.DataFrame, ground: str, factor: float) -> FloatArray:
    """Angles, degrees, by which the fall axis of each record on a ground differs from that on rock, where both have one."""
    own = rows[rows["factor"] == factor].pivot_table(index="record", columns="ground", values="axis_deg")
    if ground not in own or "rock" not in own:
        return np.empty(0)
    apart = (own[ground] - own["rock"]).dropna().to_numpy()
    return np.asarray(np.abs((apart + 90) % 180 - 90))


def bodies(rows: pd.DataFrame) -> dict[str, str]:
    """Table and sentence."""
    lines, said = [], []
    for factor in FACTORS:
        for ground in ("rock", *(f"{one} m" for one in THICKNESSES)):
            own = rows[(rows["factor"] == factor) & (rows["ground"] == ground)]
            rate, angle = 100 * own["fall_rate"], turned(rows, ground, factor)
            shift = f"{np.median(angle):.0f}° ({angle.size})" if ground != "rock" and angle.size else "–"
            unfinished = int((own["not_converged"] != "").sum())
            lines.append((
                f"{factor:g}", ground, f"{own['pga'].median() / 9.80665:.2f}", f"{rate.mean():.0f} %",
                f"{rate.median():.0f} %", int((rate >= 50).sum()), shift, unfinished,
            ))  # fmt: skip
            said.append((factor, ground, rate.mean(), angle))
    heads = (
        "factor", "ground", "PGA, g, median", "fall rate, mean", "median", "records with half or more",
        "axis turned, median (records)", "not converged",
    )  # fmt: skip
    strong = {ground: (rate, angle) for factor, ground, rate, angle in said if factor == FACTORS[-1]}
    parts = [f"{strong[f'{one} m'][0]:.0f} % through {one} m" for one in THICKNESSES]
    angles = np.concatenate([strong[f"{one} m"][1] for one in THICKNESSES])
    sentence = (
        f"Under the records times {FACTORS[-1]:g} the mean fall rate is {strong['rock'][0]:.0f} % on rock, {', '.join(parts)}; the "
        f"axis of falls of a record turns by {np.median(angles):.0f}° in the median."
    )
    failed = sorted({f"{one.record}, {one.ground}: {one.not_converged}" for one in lines_of(rows) if one.not_converged})
    told = "Not converged: " + "; ".join(failed) + "." if failed else "Every run converged."
    periods = ", ".join(f"{fundamental_period([Soil(one, VELOCITY, 1800, 0.03), ROCK]):.2f} s" for one in THICKNESSES)
    return {
        "soft-ground": markdown(heads, lines),
        "soft-ground-answer": wrapped(sentence),
        "soft-ground-convergence": wrapped(f"{told} Fundamental periods at small strain: {periods}."),
    }


def main() -> None:
    """Measure, write verification/results/soft-ground.csv and the page."""
    rows = measure()
    write_csv(rows, RESULTS / "soft-ground.csv")
    publish(bodies(rows))


if __name__ == "__main__":
    main()
