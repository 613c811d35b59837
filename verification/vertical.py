"""`python -m verification.vertical [STUDY]`: what the vertical component changes; the figures of the tutorial.

The grid of a study is computed with and without the vertical component of its processed records, without ensemble.
"""

import sys
from pathlib import Path

import numpy as np
import xarray as xr
import yaml

from overturning.records.processing import process
from overturning.records.read import read_record
from overturning.study.load import entries_of, load_study
from overturning.study.small import run_study
from overturning.units import STANDARD_GRAVITY
from verification.tables import ROOT

DEFAULT = ROOT / "config" / "waiau.yaml"


def compared(with_up: xr.DataArray, without: xr.DataArray) -> list[str]:
    """What the vertical component changes in the flags under a record, in lines."""
    known = (with_up.notnull() & without.notnull()).to_numpy()
    falls, fell = (np.abs(flags.to_numpy()[known]) == 1 for flags in (with_up, without))
    sides = (with_up.to_numpy() != without.to_numpy())[known][falls & fell]
    lines = [
        f"  overturn: {falls.mean():.1%} with the vertical component, {fell.mean():.1%} without",
        f"  another flag: {(falls != fell).mean():.1%} of the cases ({(falls & ~fell).sum()} fall only with, "
        f"{(~falls & fell).sum()} only without); another side: {sides.mean():.1%} of those that fall in both",
    ]
    for ratio in with_up["b_over_h"].to_numpy():
        shares = [float(np.abs(flags.sel(b_over_h=ratio)).mean()) for flags in (with_up, without)]
        lines.append(f"  B/H {ratio:g}: {shares[0]:.0%} with, {shares[1]:.0%} without")
    return lines


def main(path: Path = DEFAULT) -> None:
    """Print the comparison for every record of a study that has a vertical component."""
    study, keys = load_study(path), yaml.safe_load(path.read_text(encoding="utf-8"))
    keys |= {"ensemble": {"members": 0}, "verification": "none"}
    simulation, names = keys.pop("simulation", {}), keys.pop("records")["use"]
    cubes = [run_study(names, 2, **keys, simulation=simulation | {"vertical": up}) for up in (True, False)]
    for place, entry in enumerate(entries_of(study, str(path)).values()):
        up = process(read_record(entry, Path(study.records.folder)), study.processing).up
        if up is not None:
            flags = [cube["overturned"][place] for cube in cubes]
            peak = np.abs(up).max() / STANDARD_GRAVITY
            print(f"{entry.id}: {flags[0].size} cases, vertical peak {peak:.2f} g", *compared(*flags), sep="\n")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
