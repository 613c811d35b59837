"""`make bench`: how fast the kernel is, as ratios measured in one run; writes a CSV per machine and the figures in the docs.

Every time is the smallest of several runs after a warm-up, in the process itself.
"""

import argparse
import csv
import os
import platform
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from tests.dem.second_opinion import scalar_outcomes

from benchmarks import leave_out
from benchmarks.agreement import agreeing_neighbours
from benchmarks.peers import available
from benchmarks.study_records import ROOT, half_grid, near_fault
from overturning.dem import columns
from overturning.dem.cases import Cases
from overturning.dem.centred import advance_centred
from overturning.dem.cundall import advance_cundall
from overturning.dem.run import run_cases
from overturning.dem.simulate import simulate_arrays
from overturning.motion.motion import Motion
from overturning.reference.rocking import rocking_outcome

Row = tuple[str, float, str, str]

IN_README = {
    "time per case, default",
    "agreement with the rocking solution",
    "pymunk: time per case",
    "pymunk: agreement with the rocking solution",
    "default study: flags, mirrored half included",
    "default study: processor time, both threads together",
    "default study: wrong flags where the neighbours agree",
    "default study: wrong flags of all cells, against an eighth of the step",
}


def fastest(run: Callable[[], Any], repeats: int = 3) -> float:
    """Smallest processor time of several runs after one to warm up, s; a shared machine disturbs it less than the clock."""
    run()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return min(times)


@njit
def _independent_multiply_adds(rounds: int) -> float:
    values = np.ones(256)
    for _ in range(rounds):
        for j in range(256):
            v = values[j]
            for _q in range(8):
                v = v * 0.999 + 0.1
            values[j] = v
    return values.sum()


def peak_operations() -> float:
    """Floating-point operations per second of independent multiply–adds without contraction."""
    rounds = 200_000
    return rounds * 256 * 16 / fastest(lambda: _independent_multiply_adds(rounds))


def operations_per_step(advance: Any) -> int:
    """Additions, multiplications, divisions, minima and maxima of one block step, counted in the machine code.

    Each operation stands there once in vector form; what is left over of the columns is done in scalar form, not counted.
    """
    assembly = next(iter(advance.inspect_asm().values()))
    return len(re.findall(r"\bv?(?:add|sub|mul|div|min|max)pd", assembly))


def standing_motion() -> Motion:
    """Twenty seconds that rock no block of the throughput benchmark over."""
    t = np.arange(2000) * 0.01
    return Motion(2.0 * np.sin(2 * np.pi * t / 0.7), 0 * t, sampling_interval=0.01)


def throughput() -> list[Row]:
    """Block steps per second and core, those done again included, nothing left out; against the scalar kernel and the limit."""
    rows: list[Row] = []
    motion, peak = standing_motion(), peak_operations()
    many = Cases(0.0, 0.6, 0.4, np.linspace(0.3, 1.0, 512))
    few = Cases(0.0, 0.6, 0.4, np.linspace(0.3, 1.0, 8))
    state = np.zeros(columns.ROWS * columns.COLUMNS)
    advance_centred(state, 8, 1, 9.8, None, True)
    advance_cundall(state, 8, 1, 9.8, None)
    for scheme, advance in (("centred", advance_centred), ("cundall", advance_cundall)):
        wide = run_cases(motion, many, scheme=scheme, leave_out=False).block_steps.sum()
        narrow = scalar_outcomes(motion, few, scheme=scheme)[:, 3].sum()
        # Interleaved, so that both see the same neighbours on the machine.
        ratios, speeds = [], []
        for _ in range(3):
            speed = wide / fastest(lambda s=scheme: run_cases(motion, many, scheme=s, leave_out=False), 1)
            plain = narrow / fastest(lambda s=scheme: scalar_outcomes(motion, few, scheme=s), 1)
            ratios.append(speed / plain)
            speeds.append(speed)
        operations = operations_per_step(advance)
        rows += [
            (f"block steps per second and core, {scheme}", max(speeds) / 1e6, "million/s", ""),
            (f"against the scalar kernel, {scheme}", float(np.median(ratios)), "x", ">= 15"),
            (f"operations per block step, {scheme}", operations, "", ""),
            (f"share of the floating-point limit, {scheme}", max(speeds) * operations / peak, "", ">= 0.6"),
        ]
    return [("floating-point limit", peak / 1e9, "10^9/s", ""), *rows]


def against_peers(cases_of_peers: int) -> list[Row]:
    """Time per case in a sweep of more than 1000 20-s cases, and agreement with the rocking solution."""
    motion = near_fault()["rinaldi"]
    axes = np.meshgrid(np.arange(0.0, 360.0, 5.0), [0.6, 1.2], [0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4], indexing="ij")
    azimuth, height, ratio = (values.ravel() for values in axes)
    waves = {angle: motion.along(angle) for angle in np.unique(azimuth)}
    rigid = np.array(
        [
            [rocking_outcome(f * waves[a], motion.sampling_interval, h, r)[0] for f in (0.99, 1.0, 1.01)]
            for a, h, r in zip(azimuth, height, ratio, strict=True)
        ]
    )
    firm = (rigid == rigid[:, :1]).all(axis=1)
    cases = Cases(azimuth, height, ratio, 10.0)
    # As a user would: the grid, with its mirrored half left out in the second run.
    grid = {"azimuth_deg": np.unique(azimuth), "height": [0.6, 1.2], "b_over_h": np.unique(ratio), "friction": [10.0]}
    whole = fastest(lambda: run_cases(motion, cases, leave_out=False), 15) / cases.size
    default = fastest(lambda: simulate_arrays(motion, **grid), 15) / cases.size
    agreement = float((run_cases(motion, cases).overturned == rigid[:, 1])[firm].mean())
    rows: list[Row] = [
        ("cases of the sweep", cases.size, "", ">= 1000"),
        ("time per case, nothing left out", whole * 1e3, "ms", ""),
        ("time per case, default", default * 1e3, "ms", ""),
        ("agreement with the rocking solution", 100 * agreement, "%", ""),
    ]
    chosen = np.random.default_rng(1).choice(np.flatnonzero(firm), min(cases_of_peers, firm.sum()), replace=False)
    for name, run in available().items():
        start = time.process_time()
        sides = [run(waves[azimuth[i]], motion.sampling_interval, height[i], ratio[i], 10.0) for i in chosen]
        each = (time.process_time() - start) / chosen.size
        rows += [
            (f"{name}: time per case", each * 1e3, "ms", ""),
            (f"{name}: agreement with the rocking solution", 100 * float((sides == rigid[chosen, 1]).mean()), "%", ""),
            (f"faster than {name}, nothing left out", each / whole, "x", ">= 40"),
            (f"faster than {name}, default", each / default, "x", ">= 150"),
        ]
    return rows


def compilation() -> list[Row]:
    """A cold start into an empty cache folder, less a warm one."""
    program = (
        "import time, numpy as np; from overturning import Motion, Cases, run_cases\n"
        "w = np.sin(np.arange(50.0)); m = Motion(w, w, sampling_interval=0.01); t = time.process_time()\n"
        "run_cases(m, Cases(0, 0.6, 0.05, 1.0)); print(time.process_time() - t)"
    )
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
        cold, warm = (
            float(
                subprocess.run([sys.executable, "-c", program], env=environment, check=True, capture_output=True).stdout
            )
            for _ in range(2)
        )
    return [("compilation, cold", cold - warm, "s", "<= 10"), ("loading a compiled kernel", warm, "s", "")]


def default_study() -> list[Row]:
    """Kernel time of the default study's 133,056 flags on two threads, and its wrong flags."""
    cases, motions = half_grid(), near_fault()
    run_cases(next(iter(motions.values())), half_grid(2))
    start, busy = time.perf_counter(), time.process_time()
    found = {name: run_cases(motion, cases, threads=2) for name, motion in motions.items()}
    seconds, busy = time.perf_counter() - start, time.process_time() - busy
    wrong = sides = firm_cells = firm_wrong = firm_sides = 0
    shape = (36, 2, -1, 3)
    for name, motion in motions.items():
        fine = run_cases(motion, cases, threads=2, time_step="0.125 stable")
        flag = (fine.overturned != 0) != (found[name].overturned != 0)
        side = fine.overturned != found[name].overturned
        firm = agreeing_neighbours(fine.overturned.reshape(shape)).ravel()
        wrong, sides = wrong + int(flag.sum()), sides + int(side.sum())
        firm_cells += int(firm.sum())
        firm_wrong, firm_sides = firm_wrong + int((flag & firm).sum()), firm_sides + int((side & firm).sum())
    cells = cases.size * len(motions)
    return [
        ("default study: flags, mirrored half included", 2 * cells, "", ""),
        ("default study: kernel time on two threads", seconds, "s", "<= 20"),
        ("default study: processor time, both threads together", busy, "s", ""),
        ("default study: wrong flags where the neighbours agree", 100 * firm_wrong / firm_cells, "%", "<= 0.5"),
        ("default study: wrong sides where the neighbours agree", 100 * firm_sides / firm_cells, "%", "<= 0.5"),
        ("default study: wrong flags of all cells, against an eighth of the step", 100 * wrong / cells, "%", "<= 0.5"),
        ("default study: wrong sides of all cells, against an eighth of the step", 100 * sides / cells, "%", ""),
    ]


def growth() -> list[Row]:
    """Memory at a million cases, and how the time grows from ten thousand on."""
    t = np.arange(60) * 0.02
    motion = Motion(6.0 * np.sin(2 * np.pi * t / 0.5), 0 * t, sampling_interval=0.02)
    rng = np.random.default_rng(2)
    rows: list[Row] = []
    each = {}
    run_cases(motion, Cases(0.0, 0.6, 0.3, 0.5))  # loads the compiled kernel
    for count in (10_000, 100_000, 1_000_000):
        cases = Cases(0.0, 0.6, rng.choice(np.linspace(0.2, 0.5, 31), count), rng.choice([0.4, 0.7, 1.0], count))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        start = time.process_time()
        run_cases(motion, cases)
        each[count] = (time.process_time() - start) / count
        rows.append((f"time per case of {count} short cases", each[count] * 1e6, "us", ""))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    rows += [
        ("time per case at 10^6 over that at 10^4", each[1_000_000] / each[10_000], "x", "<= 1.1"),
        ("peak memory at 10^6 cases", peak / 2**20, "GiB", "<= 1"),
        ("of it added by the 10^6 cases", (peak - before) / 2**20, "GiB", ""),
    ]
    return rows


def table(rows: list[Row]) -> str:
    """The rows as a Markdown table."""
    lines = ["| | measured | target |", "|---|---|---|"]
    for name, value, unit, target in rows:
        number = f"{value:.4g}" if abs(value) < 1e4 else f"{value:,.0f}"
        lines.append(f"| {name} | {number} {unit} | {target} |".replace("  ", " "))
    return "\n".join(lines)


def insert(document: Path, name: str, text: str) -> None:
    """Replace what stands between the markers of a name in a document."""
    content = document.read_text(encoding="utf-8")
    begin, end = f"<!-- {name}:begin -->", f"<!-- {name}:end -->"
    if begin in content:
        head, rest = content.split(begin, 1)
        document.write_text(f"{head}{begin}\n{text}\n{end}{rest.split(end, 1)[1]}", encoding="utf-8")


def main() -> None:
    """Run the parts asked for, print the table, write CSV and documents."""
    parts: dict[str, Callable[[], list[Row]]] = {
        "growth": growth, "throughput": throughput, "peers": lambda: against_peers(150), "compilation": compilation,
        "study": default_study, "left-out": leave_out.counts,
    }  # fmt: skip
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", help="which parts; all where none is named")
    chosen = parser.parse_args().parts
    rows: list[Row] = []
    for name, part in parts.items():
        if not chosen or name in chosen:
            found = part()
            rows += found
            if name == "left-out":
                insert(ROOT / "docs" / "method.md", name, table(found))
    print(table(rows))
    machine = re.sub(r"[^a-z0-9]+", "-", f"{platform.machine()} {os.cpu_count()} cores".lower()).strip("-")
    path = ROOT / "benchmarks" / "results" / f"{machine}.csv"
    if chosen and path.is_file():
        # The parts that were not run keep their rows.
        with path.open(encoding="utf-8") as file:
            new = {row[0]: row for row in rows}
            rows = [
                new.pop(old["quantity"], (old["quantity"], float(old["value"]), old["unit"], old["target"]))
                for old in csv.DictReader(file)
            ] + list(new.values())
    path.parent.mkdir(exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["quantity", "value", "unit", "target"])
        writer.writerows(rows)
    insert(ROOT / "docs" / "method.md", "bench", table(rows))
    insert(ROOT / "README.md", "bench", table([row for row in rows if row[0] in IN_README]))


if __name__ == "__main__":
    main()
