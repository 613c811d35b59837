"""How fast and how exact bodies in space are: compiling, order, energy, step and contact, chaos, other engines."""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from functools import partial
from typing import Annotated, Any, Final

import numpy as np
import typer

from overturning.dem.body.simulate import simulate_in_space_arrays
from overturning.model.contact import VertexContact
from overturning.motion.motion import Motion
from verification.inputs import near_fault, strong_part
from verification.reference import body_cundall
from verification.space_engines import Prism, fall_azimuth, installed
from verification.space_order import orders
from verification.space_study import study
from verification.tables import RESULTS, Figure, figures_table, publish, write_figures
from verification.timing import measured

GRID: Final[dict[str, Any]] = {"height": [0.6], "b_over_h": [0.2, 0.3, 0.4], "friction": [0.58]}
TURNED: Final = np.arange(0.0, 90.0, 15.0)
PEER_STEP: Final = 2e-4
"""Step of the other engines, s: a smaller one changes their flags by no more than they differ."""


def shaken(samples: int = 2000) -> Motion:
    """Twenty seconds that rock bodies and throw none."""
    t = np.arange(samples) * 0.01
    return Motion(1.5 * np.sin(9.0 * t), 1.2 * np.cos(12.0 * t), 0.5 * np.sin(9.0 * t), sampling_interval=0.01)


def apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angle between azimuths, degrees."""
    return np.abs((a - b + 180.0) % 360.0 - 180.0)


def throughput() -> Iterator[Figure]:
    """Block steps per second and core, with vertices and on a rim, and the time to compile the kernel."""
    for scheme, body, name, target in (
        ("cundall", "rectangle", "cundall, four vertices", "≥ 25"),
        ("cundall", "circle", "cundall, rim", ""),
        ("centred", "rectangle", "centred, four vertices", ""),
        ("centred", "circle", "centred, rim", ""),
    ):

        def run(scheme: str = scheme, body: Any = body) -> dict[str, np.ndarray]:
            return simulate_in_space_arrays(
                shaken(), orientation_deg=TURNED, height=[0.6], b_over_h=np.linspace(0.4, 0.5, 16), friction=[0.6],
                body=body, leave_out=False, scheme=scheme,
            )  # fmt: skip

        found, seconds = measured(run, 2)
        rate = found["block_steps"].sum() / seconds / 1e6
        yield Figure(f"space: block steps per second and core, {name}", rate, "million", target)
    with tempfile.TemporaryDirectory() as folder:
        command = (
            "import verification.space as s; "
            "s.simulate_in_space_arrays(s.shaken(), orientation_deg=0, height=1, b_over_h=0.4, leave_out=False)"
        )
        begin = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", command], check=True, env=os.environ | {"NUMBA_CACHE_DIR": folder})
        end = resource.getrusage(resource.RUSAGE_CHILDREN)
    cold = (end.ru_utime + end.ru_stime) - (begin.ru_utime + begin.ru_stime)
    yield Figure("space: processor time of the first case with a cold cache, imports included", cold, "s", "≤ 15")


def memory() -> Iterator[Figure]:
    """How the peak of memory grows with the number of cases, each size in a process of its own."""
    command = (
        "import resource, sys, numpy as np, verification.space as s; s.simulate_in_space_arrays(s.shaken(100), "
        "orientation_deg=0, height=1, b_over_h=np.linspace(0.4, 0.5, int(sys.argv[1])), leave_out=False);"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
    )
    counts = (1000, 1000, 21000)
    _, few, many = (
        int(subprocess.run([sys.executable, "-c", command, str(n)], check=True, capture_output=True, text=True).stdout)
        for n in counts
    )
    yield Figure("space: memory of 1000 cases", few / 1024, "MB")
    yield Figure("space: memory of each further 1000", (many - few) / 1024 / 20, "MB")


def motions(count: int) -> list[Motion]:
    """Strong parts of records of the default study."""
    return [strong_part(motion) for motion in list(near_fault().values())[:: max(28 // count, 1)][:count]]


def run_all(chosen: list[Motion], factor: float = 1.0, **options: Any) -> dict[str, np.ndarray]:
    """Outcomes of the grid under some motions."""
    found = []
    for motion in chosen:
        scaled = Motion(factor * motion.north, factor * motion.east, sampling_interval=motion.sampling_interval)
        found.append(simulate_in_space_arrays(scaled, orientation_deg=TURNED, threads=2, **GRID, **options))
    return {name: np.stack([one[name] for one in found]) for name in found[0]}


def exactness(chosen: list[Motion]) -> Iterator[Figure]:
    """Energy, and what 1 % of amplitude, half the step and other contacts change."""
    nominal, seconds = measured(lambda: run_all(chosen), 1, lambda: run_all(chosen[:1]))
    fell = nominal["overturned"] == 1
    yield Figure("space: cases", fell.size)
    yield Figure("space: processor time per case", 1e3 * seconds / fell.size, "ms")
    yield Figure("space: largest energy error", float(nominal["energy_error"].max()), "", "≤ 0.01")
    yield Figure("space: largest angular-momentum error", float(nominal["angular_momentum_error"].max()))
    others = [run_all(chosen, factor) for factor in (0.99, 1.01)]
    firm = np.all([(one["overturned"] == nominal["overturned"]) & (~fell | (apart(one["fall_azimuth"],
    nominal["fall_azimuth"]) < 15.0))
                   for one in others], axis=0)  # fmt: skip
    keep = np.all([one["overturned"] == nominal["overturned"] for one in others], axis=0)
    yield Figure("space: cases that keep the flag under ±1 % of amplitude", 100.0 * keep.mean(), "%")
    yield Figure(
        "space: falls whose azimuth moves by more than 15° under ±1 % of amplitude",
        100.0 * (~firm)[fell & keep].mean(),
        "%",
    )
    for name, options in (
        ("half the step", {"time_step": "0.5 stable"}),
        ("quarter of the step", {"time_step": "0.25 stable"}),
        ("cundall", {"scheme": "cundall"}),
        ("cundall, half the step", {"scheme": "cundall", "time_step": "0.25 stable"}),
        ("δ/B 2e-5", {"contact": VertexContact(2e-5)}),
        ("δ/B 2e-7", {"contact": VertexContact(2e-7)}),
    ):
        other, seconds = measured(partial(run_all, chosen, **options), 1, lambda: None)
        same = other["overturned"] == nominal["overturned"]
        moved = apart(other["fall_azimuth"], nominal["fall_azimuth"])[firm & fell & same]
        yield Figure(f"space, {name}: other flags, of firm cases", 100.0 * (~same)[firm].mean(), "%")
        yield Figure(f"space, {name}: azimuths more than 15° off, of firm falls", 100.0 * (moved > 15.0).mean(), "%")
        yield Figure(f"space, {name}: median change of azimuth, of firm falls", float(np.median(moved)), "°")
        yield Figure(f"space, {name}: processor time per case", 1e3 * seconds / fell.size, "ms")


def convergence() -> Iterator[Figure]:
    """Slope of the error over the step, of stones that stand and that fall."""
    for scheme in ("centred", "cundall"):
        for name, (slope, errors) in orders(scheme).items():
            yield Figure(f"space, {scheme}: order of convergence, {name}", slope)
            yield Figure(f"space, {scheme}: median error at its step, {name}", float(np.degrees(errors[0])), "°")


def against_peers(chosen: list[Motion], count: int) -> Iterator[Figure]:
    """Flags and azimuths of other engines on some of the cases."""
    ours, seconds = measured(lambda: run_all(chosen), 1, lambda: run_all(chosen[:1]))
    mine, fine = seconds / ours["status"].size, run_all(chosen, time_step="0.25 stable", contact=VertexContact(2e-7))
    rng = np.random.default_rng(1)
    cells = np.stack(
        np.unravel_index(rng.permutation(ours["overturned"].size)[:count], ours["overturned"].shape), axis=1
    )
    flags, azimuths = {}, {}
    for name, engine in installed().items():
        begin = time.process_time()
        azimuths[name] = np.array([
            fall_azimuth(engine, chosen[m], TURNED[o], Prism(0.3 * GRID["b_over_h"][b], 0.3 * GRID["b_over_h"][b], 0.3,
            0.58), PEER_STEP)
            for m, o, _, b, _, _ in cells.tolist()
        ])  # fmt: skip
        theirs = (time.process_time() - begin) / len(cells)
        yield Figure(f"{name} in space: processor time per case", theirs, "s")
        yield Figure(f"{name} in space: its time per case over ours", theirs / mine, "", "≥ 50")
        flags[name] = np.isfinite(azimuths[name])
    yield Figure("space: cases that all engines run", len(cells))
    chosen_cells = tuple(cells.T)
    flags["ours"], azimuths["ours"] = ours["overturned"][chosen_cells] == 1, ours["fall_azimuth"][chosen_cells]
    best = fine["overturned"][chosen_cells] == 1
    for name in flags:
        yield Figure(
            f"space: flags other than the finest reference's, {name}", 100.0 * (flags[name] != best).mean(), "%"
        )
    names, between = list(flags), dict[str, float]()
    for i, a in enumerate(names):
        for b in names[i + 1 :]:
            both = flags[a] & flags[b]
            differ = 100.0 * float((flags[a] != flags[b]).mean())
            between.setdefault("theirs", differ)
            target = f"≤ {between['theirs']:.3g}" if "ours" in (a, b) else ""
            yield Figure(f"space: flags that differ, {a} and {b}", differ, "%", target)
            near = apart(azimuths[a], azimuths[b])[both] <= 20.0
            yield Figure(f"space: azimuths within 20° where both fall, {a} and {b}", 100.0 * near.mean(), "%")


PARTS: Final = {"throughput": throughput, "memory": memory, "convergence": convergence, "study": study}
"""Those that need no motions handed to them."""


def main(
    records: Annotated[int, typer.Option(min=1, help="records of the default study")] = 28,
    peer_cases: Annotated[int, typer.Option(min=0, help="cases that the other engines run")] = 200,
    only: Annotated[list[str] | None, typer.Option(help="part to measure again; the figures of others stay")] = None,
) -> None:
    """Measure bodies in space."""
    chosen, figures = motions(records), []
    parts = PARTS | {"exactness": partial(exactness, chosen), "peers": partial(against_peers, chosen, peer_cases)}
    with body_cundall.in_use():
        for name in only or [name for name in parts if peer_cases or name != "peers"]:
            for figure in parts[name]():
                figures.append(figure)
                print(*figure, sep=" | ", flush=True)
    publish({"space": figures_table(write_figures(figures, RESULTS / "space.csv", keep=only is not None))})


if __name__ == "__main__":
    typer.run(main)
