"""The curve from which the default scheme and step were read: error and cost over the step, on the default study.

33,264 cases of 28 real records (every tenth azimuth of half a turn, all B/H, heights and frictions) against the centred
scheme at 1/32 of its longest step. Run it with ``python -m benchmarks.default_step``; it takes some minutes.
"""

import csv
import time
from typing import Any

import numpy as np

from benchmarks.agreement import agreeing_neighbours
from benchmarks.bench import insert
from benchmarks.study_records import ROOT, half_grid, near_fault
from overturning.dem.results import Results
from overturning.dem.run import run_cases

AZIMUTHS = 18
THREADS = 2
REFERENCE = ("centred", 0.03125)
DEFAULT = ("centred", 1.0)
RUNS = [("centred", fraction) for fraction in (0.0625, 0.125, 0.25, 0.5, 0.75, 1.0)]
RUNS += [("cundall", fraction) for fraction in (0.12, 0.25, 0.5, 0.9)]
EQUAL = {
    "median_error_of_peak_rotation": "median error of peak rotation",
    "mean_shift_of_boundary_percent": "shift of the boundary",
    "wrong_flags_percent": "wrong flags",
    "wrong_sides_percent": "wrong sides",
}


def boundary(flags: np.ndarray, ratios: np.ndarray) -> np.ndarray:
    """B/H below which the block falls, from the number of falling cells along B/H."""
    return ratios[0] + (flags != 0).sum(axis=2) * (ratios[1] - ratios[0])


def equal_error(rows: list[dict[str, Any]]) -> str:
    """What the default costs over what Cundall's scheme costs at the same error, by log-log interpolation, as a table."""
    default = next(row for row in rows if (row["scheme"], row["fraction_of_stable_step"]) == DEFAULT)
    yardstick = [row for row in rows if row["scheme"] == "cundall"]
    lines = ["| at the same | of the default | share of Cundall's processor time |", "|---|---|---|"]
    for key, text in EQUAL.items():
        errors = np.log([max(row[key], 1e-12) for row in yardstick])
        costs = np.log([row["processor_seconds"] for row in yardstick])
        order = np.argsort(errors)
        error = np.log(max(default[key], 1e-12))
        share = default["processor_seconds"] / np.exp(np.interp(error, errors[order], costs[order]))
        # Beyond the curve's ends the nearest end is taken, which understates the advantage at a smaller error.
        where = ", at most" if error < errors.min() else ", at least" if error > errors.max() else ""
        lines.append(f"| {text} | {default[key]:.3g} | 1/{1 / share:.1f}{where} |")
    return "\n".join(lines)


def main() -> None:
    """Measure, print and write benchmarks/results/default-step.csv."""
    cases, motions = half_grid(AZIMUTHS), near_fault()
    ratios = np.unique(cases.b_over_h)
    shape = (AZIMUTHS, 2, ratios.size, 3)

    def run(scheme: str, fraction: float) -> tuple[dict[str, Results], float]:
        start = time.process_time()
        found = {
            name: run_cases(motion, cases, scheme=scheme, time_step=f"{fraction} stable", threads=THREADS)
            for name, motion in motions.items()
        }
        return found, time.process_time() - start

    reference, _ = run(*REFERENCE)
    rows = []
    for scheme, fraction in RUNS:
        found, seconds = run(scheme, fraction)
        cells = flags = sides = firm_cells = firm_flags = firm_sides = marked = steps = 0
        rotation, shift, energy = [], [], []
        for name, fine in reference.items():
            coarse = found[name]
            known = (coarse.overturned > -128) & (fine.overturned > -128)
            wrong_flag = ((coarse.overturned != 0) != (fine.overturned != 0)) & known
            wrong_side = (coarse.overturned != fine.overturned) & known
            firm = agreeing_neighbours(fine.overturned.reshape(shape)).ravel() & known
            cells, flags, sides = cells + known.sum(), flags + wrong_flag.sum(), sides + wrong_side.sum()
            firm_cells, firm_flags = firm_cells + firm.sum(), firm_flags + (wrong_flag & firm).sum()
            firm_sides += (wrong_side & firm).sum()
            marked += (coarse.status > 1).sum()
            steps += coarse.block_steps.sum()
            stands = known & (coarse.overturned == 0) & (fine.overturned == 0) & (fine.peak_rotation > 0.05)
            rotation.append(np.abs(coarse.peak_rotation - fine.peak_rotation)[stands])
            edges = [boundary(r.overturned.reshape(shape), ratios) for r in (coarse, fine)]
            moving = edges[1] > ratios[0]
            shift.append((np.abs(edges[0] - edges[1]) / edges[1])[moving])
            energy.append(coarse.energy_error[coarse.status == 0])
        error = np.concatenate(rotation)
        rows.append(
            {
                "scheme": scheme,
                "fraction_of_stable_step": fraction,
                "cases": int(cells),
                "processor_seconds": round(seconds, 2),
                "million_block_steps": round(steps / 1e6, 1),
                "wrong_flags_percent": round(100 * flags / cells, 3),
                "wrong_sides_percent": round(100 * sides / cells, 3),
                "wrong_flags_where_neighbours_agree_percent": round(100 * firm_flags / firm_cells, 3),
                "wrong_sides_where_neighbours_agree_percent": round(100 * firm_sides / firm_cells, 3),
                "median_error_of_peak_rotation": float(f"{np.median(error):.3g}"),
                "90th_percentile": float(f"{np.quantile(error, 0.9):.3g}"),
                "mean_shift_of_boundary_percent": round(100 * float(np.concatenate(shift).mean()), 3),
                "marked": int(marked),
                "largest_energy_error": float(f"{max(e.max() for e in energy):.3g}"),
            }
        )
        print(rows[-1], flush=True)
    path = ROOT / "benchmarks" / "results" / "default-step.csv"
    path.parent.mkdir(exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    shown = {
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
    lines = ["| " + " | ".join(shown.values()) + " |", "|---" * len(shown) + "|"]
    lines += ["| " + " | ".join(str(row[key]) for key in shown) + " |" for row in rows]
    insert(ROOT / "docs" / "method.md", "default-step", "\n".join(lines))
    insert(ROOT / "docs" / "method.md", "equal-error", equal_error(rows))


if __name__ == "__main__":
    main()
