"""How long reading and measuring a record takes: a 300-s, 100-Hz, three-component KiK-net set, on one core.

Usage: python benchmarks/records.py [--output FILE.csv] [--peers]

Each figure is the least of three runs after a first one that loads the libraries. With --peers the RotD spectrum is also computed
by pyrotd, in the same run, so that the ratio of the two does not depend on the machine.
"""

import argparse
import csv
import importlib.metadata
import sys
import tempfile
import time
import types
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "records"))
from record_writers import write_knet_set

from overturning.motion.intensity import measures_by_azimuth
from overturning.motion.jma_intensity import instrumental_intensity
from overturning.motion.motion import Motion
from overturning.motion.spectra import rotd
from overturning.records.processing import process
from overturning.records.read import read_path
from overturning.records.record import Record

RUNS = 3
PERIODS = np.geomspace(0.01, 10.0, 100)


def least(action: Callable[[], object]) -> float:
    """Least time of several runs after a warm-up, s."""
    action()
    times = []
    for _ in range(RUNS):
        began = time.perf_counter()
        action()
        times.append(time.perf_counter() - began)
    return min(times)


def shaken(seed: int) -> list[np.ndarray]:
    """Counts of three components: noise under an envelope, 300 s at 100 Hz."""
    random = np.random.default_rng(seed)
    clock = np.arange(30_000) * 0.01
    envelope = np.exp(-(((clock - 60) / 25) ** 2))
    return [np.round(random.normal(0, scale, clock.size) * envelope).astype(int) + 1000 for scale in (9e5, 3e5, 2e5)]


def peer(motion: Motion) -> float:
    """Time of pyrotd for the same spectrum, s."""
    stub = types.ModuleType("pkg_resources")  # pyrotd asks it for its version; newer setuptools no longer bring it
    stub.get_distribution = lambda name: types.SimpleNamespace(version=importlib.metadata.version(name))  # type: ignore[attr-defined]
    sys.modules.setdefault("pkg_resources", stub)
    import pyrotd

    pyrotd.processes = 1
    began = time.perf_counter()
    pyrotd.calc_rotated_spec_accels(
        motion.sampling_interval, motion.north, motion.east, 1 / PERIODS, 0.05, percentiles=[0, 50, 100]
    )
    return time.perf_counter() - began


def main() -> None:
    """Measure, print, and write CSV where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, help="CSV file to write")
    parser.add_argument("--peers", action="store_true", help="time pyrotd too")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        paths = write_knet_set(Path(folder), "TST0010102031305", *shaken(1), kik=2)

        def read() -> Record:
            return process(read_path(paths), None)

        motion = Motion.of(read())
        rows = [
            ("read and process a 300 s, 100 Hz, three-component set", 1.0, least(read)),
            ("all measures along 360 azimuths", 2.0, least(lambda: measures_by_azimuth(motion, np.arange(360)))),
            ("RotD spectra, 100 periods, 180 azimuths", 3.0, least(lambda: rotd(motion, PERIODS))),
            ("JMA instrumental intensity", None, least(lambda: instrumental_intensity(motion))),
        ]
        if arguments.peers:
            rows.append(("the same RotD spectra by pyrotd", None, peer(motion)))
    for what, target, seconds in rows:
        bound = f" (target {target:g} s)" if target else ""
        print(f"{seconds:8.3f} s  {what}{bound}")
    if arguments.output:
        with arguments.output.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["what", "target_s", "seconds"])
            writer.writerows(rows)


if __name__ == "__main__":
    main()
