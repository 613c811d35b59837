"""Print hashes of the outcomes of a small grid under a real motion; run in a separate process per target processor.

One hash covers 3-D outcomes, one the cube file that the workflow's sweep and gather write. If
``OVERTURNING_EVERY_TARGET`` is set, two more cover 2-D blocks with every variant of their kernel, and scenes: compiling
these takes three times as long.
"""

import hashlib
import json
import os
import sys
from pathlib import Path

import numpy as np

from overturning.dem.block.rigid import simulate_rigid_rocking
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.dem.simulate import simulate_as_arrays
from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.records.store import read_record_from_motion_file
from overturning.study.gather import merge_outcome_files_into_cube
from overturning.study.load import load_study_from_file_or_json
from overturning.study.scenes import numerical_options_of_study
from overturning.study.sweep import simulate_and_write_cases_of_record
from tests.dem.polygon_scenes import load_shipped_scene
from tests.dem.test_polygon_identity import RESULT_FIELDS, noisy_motion, random_cases_of_scene

SMALL_STUDY = {
    "name": "bits",
    "question": "Are they the same?",
    "azimuth": {"step": 30},
    "b_over_h": [0.2, 0.4],
    "height": [0.6],
    "friction": [0.33, 1.0],
}


def planar_outcome_hash(stored: Path, threads: int) -> str:
    """Return the SHA-256 of 2-D outcomes: two schemes and the rigid rocking block, with and without vertical motion."""
    digest = hashlib.sha256()
    motion = np.load(stored)
    for up in (None, 0.5 * motion["east"]):
        shaken = Motion(motion["north"], motion["east"], up, sampling_interval=float(motion["interval"]))
        cases = Cases(*(row.ravel() for row in np.meshgrid(np.arange(0, 360, 30.0), 0.6, [0.15, 0.3, 0.45], 1.0)))
        digest.update(
            b"".join(np.ascontiguousarray(found).tobytes() for found in simulate_rigid_rocking(shaken, cases))
        )
        for scheme in ("centred", "cundall"):
            found = simulate_as_arrays(
                shaken,
                azimuth_deg=np.arange(0, 360, 30.0), height=[0.6], b_over_h=[0.15, 0.3, 0.45], friction=[0.33, 1.0],
                scheme=scheme, threads=threads,
            )  # fmt: skip
            for name in sorted(found):
                digest.update(np.ascontiguousarray(found[name]).tobytes())
    return digest.hexdigest()


def scene_outcome_hash(threads: int) -> str:
    """Return the SHA-256 of the outcomes of random cases of two scenes."""
    digest = hashlib.sha256()
    for name in ("three-tier", "boulder"):
        made = load_shipped_scene(name)
        found = simulate_cases(made, noisy_motion(), random_cases_of_scene(made), NumericalOptions(threads=threads))
        for field in RESULT_FIELDS:
            digest.update(np.ascontiguousarray(getattr(found, field)).tobytes())
    return digest.hexdigest()


def body_outcome_hash(stored: Path, threads: int) -> str:
    """Return the SHA-256 of all outcomes of a 3-D block, with the default scheme and vertical motion."""
    motion = np.load(stored)
    found = simulate_as_arrays(
        Motion(motion["north"], motion["east"], 0.5 * motion["east"], sampling_interval=float(motion["interval"])),
        "rectangle",
        orientation_deg=np.arange(0.0, 90.0, 10.0),
        height=[0.6],
        b_over_h=[0.15, 0.3, 0.45],
        friction=[0.33, 1.0],
        threads=threads,
    )
    assert len(np.unique(found["overturned"])) == 2, "some fall and some stand"
    return hashlib.sha256(b"".join(np.ascontiguousarray(found[name]).tobytes() for name in sorted(found))).hexdigest()


def cube_file_hash(stored: Path, folder: Path, threads: int) -> str:
    """Return the SHA-256 of the cube file (NetCDF file of all outcomes) of a small study of one stored motion."""
    record = read_record_from_motion_file(stored)
    study = load_study_from_file_or_json(json.dumps(SMALL_STUDY | {"records": {"use": [record.record_id]}}))
    folder.mkdir(parents=True)
    simulate_and_write_cases_of_record(
        study, record, folder / "part.nc", numerics=numerical_options_of_study(study, threads)
    )
    merge_outcome_files_into_cube(study, [record], [folder / "part.nc"], folder / "cube.nc")
    return hashlib.sha256((folder / "cube.nc").read_bytes()).hexdigest()


if __name__ == "__main__":
    if "OVERTURNING_EVERY_TARGET" in os.environ:
        print(planar_outcome_hash(Path(sys.argv[1]), int(sys.argv[3])))
        print(scene_outcome_hash(int(sys.argv[3])))
    print(body_outcome_hash(Path(sys.argv[1]), int(sys.argv[3])))
    print(cube_file_hash(Path(sys.argv[2]), Path(sys.argv[4]), int(sys.argv[3])))
