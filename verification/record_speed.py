"""How long reading and measuring a record takes: a 300-s, 100-Hz, three-component KiK-net set, on one core.

Run it with ``python -m verification.record_speed [--peers]``. Each figure is the least of three runs after a first one
that loads the libraries. With --peers the RotD spectrum is also computed by pyrotd, in the same run, so that the ratio
of the two does not depend on the machine.
"""

import importlib.metadata
import sys
import tempfile
import types
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import typer

from overturning.motion.intensity import measures_by_azimuth
from overturning.motion.jma_intensity import instrumental_intensity
from overturning.motion.motion import Motion
from overturning.motion.spectra import rotd
from overturning.records.processing import process
from overturning.records.read import read_path
from verification.tables import Figure, figures_table, write_figures
from verification.timing import fastest

PERIODS: Final = np.geomspace(0.01, 10.0, 100)


def shaken(seed: int) -> list[np.ndarray]:
    """Counts of three components: noise under an envelope, 300 s at 100 Hz."""
    random = np.random.default_rng(seed)
    clock = np.arange(30_000) * 0.01
    envelope = np.exp(-(((clock - 60) / 25) ** 2))
    return [np.round(random.normal(0, scale, clock.size) * envelope).astype(int) + 1000 for scale in (9e5, 3e5, 2e5)]


def write_set(folder: Path) -> list[Path]:
    """A made-up KiK-net surface set: directions 4, 5 and 6 of one station, with counts of 2000/8388608 Gal."""
    header = {
        "Origin Time": "2001/02/03 13:05:01", "Lat.": "35.275", "Long.": "133.348", "Depth. (km)": "11", "Mag.": "6.1",
        "Station Code": "TST001", "Station Lat.": "35.2289", "Station Long.": "133.3904", "Station Height(m)": "420",
        "Record Time": "2001/02/03 13:05:21", "Sampling Freq(Hz)": "100Hz", "Duration Time(s)": "300",
    }  # fmt: skip
    paths = []
    for direction, extension, counts in zip("456", ("NS2", "EW2", "UD2"), shaken(1), strict=True):
        peak = np.abs(counts - counts.mean()).max() * 2000 / 8388608
        own = {
            "Dir.": direction, "Scale Factor": "2000(gal)/8388608", "Max. Acc. (gal)": f"{peak:.3f}",
            "Last Correction": header["Record Time"], "Memo.": "",
        }  # fmt: skip
        lines = [f"{key:<18}{value}" for key, value in (header | own).items()]
        lines += ["".join(f"{count:>9d}" for count in counts[row : row + 8]) for row in range(0, counts.size, 8)]
        paths.append(folder / f"TST0010102031305.{extension}")
        paths[-1].write_text("\n".join([*lines, ""]), encoding="ascii")
    return paths


def peer(motion: Motion) -> None:
    """The same spectrum by pyrotd."""
    stub: Any = types.ModuleType("pkg_resources")  # pyrotd asks it for its version; newer setuptools bring none
    stub.get_distribution = lambda name: types.SimpleNamespace(version=importlib.metadata.version(name))
    sys.modules.setdefault("pkg_resources", stub)
    import pyrotd

    pyrotd.processes = 1
    waves = motion.north, motion.east
    pyrotd.calc_rotated_spec_accels(motion.sampling_interval, *waves, 1 / PERIODS, 0.05, percentiles=[0, 50, 100])


def main(
    output: Annotated[Path | None, typer.Option(help="CSV file to write")] = None,
    peers: Annotated[bool, typer.Option(help="time pyrotd too")] = False,
) -> None:
    """Measure, print, and write CSV where asked."""
    with tempfile.TemporaryDirectory() as folder:
        paths = write_set(Path(folder))
        motion = Motion.of(process(read_path(paths), None))
        azimuths = np.arange(360)
        rows = [
            Figure("read and process a set", fastest(lambda: process(read_path(paths), None)), "s"),
            Figure("all measures along 360 azimuths", fastest(lambda: measures_by_azimuth(motion, azimuths)), "s"),
            Figure("RotD spectra, 100 periods, 180 azimuths", fastest(lambda: rotd(motion, PERIODS)), "s"),
            Figure("JMA instrumental intensity", fastest(lambda: instrumental_intensity(motion)), "s"),
        ]
        if peers:
            rows.append(Figure("the same RotD spectra by pyrotd", fastest(lambda: peer(motion), 1), "s"))
    print(figures_table(rows))
    if output:
        write_figures(rows, output)


if __name__ == "__main__":
    typer.run(main)
