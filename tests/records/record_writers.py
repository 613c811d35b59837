"""Small files in the formats that the readers know, written from numbers: the fixtures of the tests."""

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

KNET_EXTENSION = {
    "N-S": "NS",
    "E-W": "EW",
    "U-D": "UD",
    "1": "NS1",
    "2": "EW1",
    "3": "UD1",
    "4": "NS2",
    "5": "EW2",
    "6": "UD2",
}


def knet_text(
    counts,
    *,
    direction="N-S",
    rate="100Hz",
    station="TST001",
    scale=(2000, 8388608),
    start=datetime(2001, 2, 3, 4, 5, 6),
    magnitude="6.1",
    memo="",
) -> str:
    """K-NET ASCII; ``start`` is the first sample's time in UTC, counts carry their offset."""
    counts = np.asarray(counts, dtype=int)
    gain = float(scale[0]) / float(scale[1])
    recorded = start + timedelta(hours=9, seconds=15)
    peak = np.abs(counts - counts.mean()).max() * gain
    duration = counts.size / float(rate.removesuffix("Hz"))
    header = [
        ("Origin Time", f"{recorded - timedelta(seconds=20):%Y/%m/%d %H:%M:%S}"),
        ("Lat.", "35.275"),
        ("Long.", "133.348"),
        ("Depth. (km)", "11"),
        ("Mag.", magnitude),
        ("Station Code", station),
        ("Station Lat.", "35.2289"),
        ("Station Long.", "133.3904"),
        ("Station Height(m)", "420"),
        ("Record Time", f"{recorded:%Y/%m/%d %H:%M:%S}"),
        ("Sampling Freq(Hz)", rate),
        ("Duration Time(s)", f"{duration:g}"),
        ("Dir.", direction),
        ("Scale Factor", f"{scale[0]}(gal)/{scale[1]}"),
        ("Max. Acc. (gal)", f"{peak:.3f}"),
        ("Last Correction", f"{recorded:%Y/%m/%d %H:%M:%S}"),
        ("Memo.", memo),
    ]
    text = "".join(f"{key:<18}{value}\n" for key, value in header)
    for row in range(0, counts.size, 8):
        text += "".join(f"{value:>9d}" for value in counts[row : row + 8]) + "\n"
    return text


def write_knet_set(folder: Path, stem: str, north, east, up=None, *, kik: int | None = None, **header) -> list[Path]:
    """A set of component files of counts; ``kik`` 1 for the borehole sensor, 2 for the surface one."""
    codes = {None: ("N-S", "E-W", "U-D"), 1: ("1", "2", "3"), 2: ("4", "5", "6")}[kik]
    paths = []
    for code, counts in zip(codes, (north, east, up), strict=True):
        if counts is not None:
            path = folder / f"{stem}.{KNET_EXTENSION[code]}"
            path.write_text(knet_text(counts, direction=code, **header), encoding="ascii")
            paths.append(path)
    return paths
