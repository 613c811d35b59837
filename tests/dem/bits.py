"""Prints a hash of every outcome of a small real grid; run in a process of its own for each target processor."""

import hashlib
import sys
from pathlib import Path

import numpy as np

from overturning.dem.simulate import simulate_arrays
from overturning.motion.motion import Motion


def outcome_hash(stored: Path, threads: int) -> str:
    """Hash over all cells, both schemes, with and without vertical motion."""
    digest = hashlib.sha256()
    motion = np.load(stored)
    for up in (None, 0.5 * motion["east"]):
        for scheme in ("centred", "cundall"):
            found = simulate_arrays(
                Motion(motion["north"], motion["east"], up, sampling_interval=float(motion["interval"])),
                azimuth_deg=np.arange(0, 360, 30.0), height=[0.6], b_over_h=[0.15, 0.3, 0.45], friction=[0.33, 1.0],
                scheme=scheme, threads=threads,
            )  # fmt: skip
            for name in sorted(found):
                digest.update(np.ascontiguousarray(found[name]).tobytes())
    return digest.hexdigest()


if __name__ == "__main__":
    print(outcome_hash(Path(sys.argv[1]), int(sys.argv[2])))
