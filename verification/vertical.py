"""`python -m verification.vertical`: what the vertical component changes; the figures of the tutorial.

The grid of a study is computed with and without the vertical component of its processed records, without ensemble.
"""

import sys
from pathlib import Path

import numpy as np

from overturning.records.processing import process
from overturning.records.read import read_record
from overturning.records.record import Record
from overturning.records.store import rounded
from overturning.study.grid import grid_of
from overturning.study.load import entries_of, load_study
from overturning.study.scenes import NOMINAL, motion_of, numerics_of
from overturning.study.schema import Study
from overturning.study.sweep import simulate_variant

DEFAULT = Path("config/waiau.yaml")


def outcomes(study: Study, record: Record, vertical: bool) -> np.ndarray:
    """Outcomes of the study's grid, +1, −1, 0, NaN where unknown; shape (azimuth, height, B/H, friction)."""
    settings = study.simulation.model_copy(update={"vertical": vertical})
    chosen = study.model_copy(update={"simulation": settings})
    arrays = simulate_variant(
        chosen, NOMINAL, motion_of(chosen, record), grid_of(study), numerics_of(chosen, threads=2)
    )
    return np.asarray(arrays["overturned"], dtype=np.float64)


def compared(study: Study, record: Record) -> list[str]:
    """What the vertical component of a record changes, in lines."""
    with_up, without = outcomes(study, record, True), outcomes(study, record, False)
    known = (np.abs(with_up) <= 1) & (np.abs(without) <= 1)
    falls, fell = (np.abs(values[known]) for values in (with_up, without))
    both = (falls == 1) & (fell == 1)
    sides = (with_up[known] != without[known])[both]
    up = 0.0 if record.up is None else np.abs(record.up).max() / 9.80665
    lines = [
        f"{record.record_id}: {known.sum()} cases, vertical peak {up:.2f} g",
        f"  overturn: {falls.mean():.1%} with the vertical component, {fell.mean():.1%} without",
        f"  another flag: {(falls != fell).mean():.1%} of the cases ({((falls == 1) & (fell == 0)).sum()} fall only "
        f"with, {((falls == 0) & (fell == 1)).sum()} only without); another side: {sides.mean():.1%} of those that "
        "fall in both",
    ]
    for index, ratio in enumerate(study.b_over_h):
        shares = [np.abs(values[:, :, index]).mean() for values in (with_up, without)]
        lines.append(f"  B/H {ratio:g}: {shares[0]:.0%} with, {shares[1]:.0%} without")
    return lines


def main(path: Path = DEFAULT) -> None:
    """Print the comparison for every record of a study that has a vertical component."""
    study = load_study(path)
    for entry in entries_of(study, str(path)).values():
        record = rounded(process(read_record(entry, Path(study.records.folder)), study.processing))
        if record.up is not None:
            print("\n".join(compared(study, record)))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
