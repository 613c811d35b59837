"""How a stacked grave falls in other engines: answers that the tests compare the general kernel with.

Usage: python -m benchmarks.scene_peers

Needs pymunk and Box2D (dependency group `peers`), which the tests do not; so their answers are kept in a table. Both run at
1/960 s and 30 iterations (at 1/240 s one in ten of their answers is another), for a sample of slendernesses, frictions and azimuths under five of the default records.
"""

import csv
import sys
from pathlib import Path

import numpy as np

from benchmarks.scenes import ROOT, available, record
from overturning.dem.polygon.geometry import native_size, place
from overturning.dem.scene import load_scene

TABLE = ROOT / "tests" / "dem" / "three_tier_peers.csv"
RECORDS = (6, 7, 8, 9, 10)
EACH = 24
STEP = 1.0 / 960.0
Case = tuple[int, float, float, float]


def sample() -> list[Case]:
    """Record, azimuth (degrees), B/H of the shaft and µ of each case."""
    generator = np.random.Generator(np.random.PCG64(3))
    return [
        (
            number,
            float(generator.integers(0, 360)),
            float(generator.choice([0.2, 0.25, 0.3, 0.35])),
            float(generator.choice([0.5, 0.7, 1.0])),
        )
        for number in RECORDS
        for _ in range(EACH)
    ]


def answers(cases: list[Case]) -> dict[str, list[int]]:
    """Side to which the shaft falls, by engine that is installed."""
    scene = load_scene("three-tier", ROOT)
    height, _ = native_size(scene)
    found: dict[str, list[int]] = {}
    for name, run in available().items():
        found[name] = []
        for number, azimuth, ratio, friction in cases:
            motion = record(number)
            placed = place(scene, height, ratio)[1:]
            found[name].append(run(placed, motion.along(azimuth), motion.sampling_interval, friction, STEP)[2])
    return found


def main(table: Path = TABLE) -> int:
    """Write the table."""
    cases = sample()
    found = answers(cases)
    if len(found) < 2:
        print("error: both engines are needed: pip install 'overturning[peers]'", file=sys.stderr)
        return 1
    with table.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("record", "azimuth_deg", "b_over_h", "friction", *(name.lower() for name in found)))
        rows.writerows((*case, *sides) for case, *sides in zip(cases, *found.values(), strict=True))
    return 0


if __name__ == "__main__":
    sys.exit(main())
