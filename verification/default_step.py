"""The curve from which the default scheme and step were read: error and cost over the step, on the default study.

3696 cases of 28 real records (both axes of the sensor, all B/H, heights and frictions) against the centred
scheme at 1/32 of its longest step. Run it with ``python -m verification.default_step``; it takes some minutes.
"""

import time
from typing import Any

import numpy as np
import pandas as pd

from overturning.arrays import FloatArray
from overturning.dem.run import run_cases
from overturning.model.results import Results
from verification.inputs import half_grid, near_fault
from verification.measures import Flags, difference, percent, wrong_sides
from verification.tables import RESULTS, markdown, publish, write_csv

AZIMUTHS = 2
THREADS = 2
REFERENCE = ("centred", 0.03125)
DEFAULT = ("centred", 1.0)
RUNS = [("centred", fraction) for fraction in (0.0625, 0.125, 0.25, 0.5, 0.75, 1.0)]
RUNS += [("cundall", fraction) for fraction in (0.25, 0.5, 0.9)]
EQUAL = {
    "median_error_of_peak_rotation": "median error of peak rotation",
    "mean_shift_of_boundary_percent": "shift of the boundary",
    "wrong_flags_percent": "wrong flags",
    "wrong_sides_percent": "wrong sides",
}
SHOWN = {
    "scheme": "scheme",
    "fraction_of_stable_step": "step",
    "processor_seconds": "processor time, s",
    "wrong_flags_where_neighbours_agree_percent": "wrong flags, neighbours agree, %",
    "wrong_sides_where_neighbours_agree_percent": "wrong sides, neighbours agree, %",
    "wrong_flags_percent": "wrong flags, all, %",
    "wrong_sides_percent": "wrong sides, all, %",
    "median_error_of_peak_rotation": "median error of peak rotation",
    "mean_shift_of_boundary_percent": "shift of the boundary, %",
    "marked": "marked",
    "largest_energy_error": "largest energy error",
}


def boundary(flags: Flags, ratios: FloatArray) -> FloatArray:
    """B/H below which the block falls, from the number of falling cells along B/H."""
    return np.asarray(ratios[0] + (flags != 0).sum(axis=2) * (ratios[1] - ratios[0]))


def shift(coarse: Flags, fine: Flags, ratios: FloatArray) -> FloatArray:
    """Shift of each boundary that the grid holds, as a share of B/H."""
    edges = boundary(coarse, ratios), boundary(fine, ratios)
    return (np.abs(edges[0] - edges[1]) / edges[1])[edges[1] > ratios[0]]


def equal_error(rows: pd.DataFrame) -> str:
    """What the default costs over what Cundall's scheme does at the same error, by log-log interpolation."""
    default = rows[(rows["scheme"] == DEFAULT[0]) & (rows["fraction_of_stable_step"] == DEFAULT[1])].iloc[0]
    yardstick = rows[rows["scheme"] == "cundall"]
    lines = []
    for key, text in EQUAL.items():
        errors = np.log(yardstick[key].clip(lower=1e-12).to_numpy())
        costs = np.log(yardstick["processor_seconds"].to_numpy())
        order = np.argsort(errors)
        error = np.log(max(default[key], 1e-12))
        share = default["processor_seconds"] / np.exp(np.interp(error, errors[order], costs[order]))
        # Beyond the curve's ends the nearest end is taken, which understates the advantage at a smaller error.
        where = ", at most" if error < errors.min() else ", at least" if error > errors.max() else ""
        lines.append((text, f"{default[key]:.3g}", f"1/{1 / share:.1f}{where}"))
    return markdown(("at the same", "of the default", "share of Cundall's processor time"), lines)


def measure(azimuths: int = AZIMUTHS, every_record: int = 1) -> pd.DataFrame:
    """Error and cost of each scheme and step."""
    cases, motions = half_grid(azimuths), dict(list(near_fault().items())[::every_record])
    ratios = np.unique(cases.b_over_h)
    shape = (azimuths, np.unique(cases.height).size, ratios.size, np.unique(cases.friction).size)

    def run(scheme: str, fraction: float) -> dict[str, Results]:
        given: dict[str, Any] = {"scheme": scheme, "time_step": f"{fraction} stable", "threads": THREADS}
        return {name: run_cases(motion, cases, **given) for name, motion in motions.items()}

    exact = run(*REFERENCE)
    rows = []
    for scheme, fraction in RUNS:
        begin = time.process_time()
        found = run(scheme, fraction)
        seconds = time.process_time() - begin
        far = difference(found, exact, shape)
        shifts = [
            shift(found[name].overturned.reshape(shape), one.overturned.reshape(shape), ratios)
            for name, one in exact.items()
        ]
        rows.append({
            "scheme": scheme,
            "fraction_of_stable_step": fraction,
            "cases": far.counts.cases,
            "processor_seconds": round(seconds, 2),
            "million_block_steps": round(far.block_steps / 1e6, 1),
            "wrong_flags_percent": round(percent(far.counts.flags, far.counts.cases), 3),
            "wrong_sides_percent": round(percent(wrong_sides(far.counts), far.counts.cases), 3),
            "wrong_flags_where_neighbours_agree_percent": round(percent(far.firm.flags, far.firm.cases), 3),
            "wrong_sides_where_neighbours_agree_percent": round(percent(wrong_sides(far.firm), far.firm.cases), 3),
            "median_error_of_peak_rotation": float(f"{np.median(far.rotation):.3g}"),
            "90th_percentile": float(f"{np.quantile(far.rotation, 0.9):.3g}"),
            "mean_shift_of_boundary_percent": round(100 * float(np.concatenate(shifts).mean()), 3),
            "marked": far.marked,
            "largest_energy_error": float(f"{far.energy_error:.3g}"),
        })  # fmt: skip
        print(rows[-1], flush=True)
    return pd.DataFrame(rows)


def main() -> None:
    """Measure, write verification/results/default-step.csv and the tables."""
    rows = measure()
    write_csv(rows, RESULTS / "default-step.csv")
    curve = markdown(list(SHOWN.values()), rows[list(SHOWN)].to_numpy(dtype=object))
    publish({"default-step": curve, "equal-error": equal_error(rows)})


if __name__ == "__main__":
    main()
