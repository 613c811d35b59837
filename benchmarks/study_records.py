"""The records and the grid of the default study, for benchmarks and verification."""

from functools import cache
from pathlib import Path

import numpy as np

from overturning.dem.cases import Cases
from overturning.motion.motion import Motion
from overturning.records.catalogue import read_catalogue
from overturning.records.read import read_record
from overturning.study.load import load_study

ROOT = Path(__file__).parents[1]


@cache
def near_fault() -> dict[str, Motion]:
    """Motions of the default study's records by id."""
    catalogue = read_catalogue(ROOT / "config" / "records.tsv")
    study = load_study(ROOT / "config" / "near-fault.yaml")
    return {name: Motion.of(read_record(catalogue[name], ROOT)) for name in study.records.use}


def half_grid(azimuths: int = 36) -> Cases:
    """The default study's cases of one record, without the mirrored half."""
    study = load_study(ROOT / "config" / "near-fault.yaml")
    axes = (np.arange(azimuths) * 180.0 / azimuths, study.height, study.b_over_h, study.friction)
    return Cases(*(values.ravel() for values in np.meshgrid(*axes, indexing="ij")))
