"""K-NET and KiK-net ASCII of NIED, one component per file.

The format: seventeen header lines (key in columns 1 to 18, value after them), then counts, eight to a line;
acceleration in Gal is count times scale factor. obspy reads the file; because it takes a cut header, ``99.5Hz`` or a
fractional scale factor without a word, the header is read strictly here first and obspy gets it in canonical form.
"""

import io
import re
from datetime import UTC, datetime, timedelta
from typing import Final

import numpy as np

from overturning.errors import RecordError
from overturning.records.component import Component, Sensor, StatedPeak
from overturning.records.formats.lines import Lines, resolution, stated_time
from overturning.records.source import SourceFile
from overturning.units import GAL

KEYS: Final = (
    "Origin Time",
    "Lat.",
    "Long.",
    "Depth. (km)",
    "Mag.",
    "Station Code",
    "Station Lat.",
    "Station Long.",
    "Station Height(m)",
    "Record Time",
    "Sampling Freq(Hz)",
    "Duration Time(s)",
    "Dir.",
    "Scale Factor",
    "Max. Acc. (gal)",
    "Last Correction",
    "Memo.",
)
"""Of the header's lines, in their order."""

_SENSORS: Final[tuple[tuple[tuple[str, ...], str, Sensor], ...]] = (
    (("N-S", "E-W", "U-D"), "", "surface"),
    (("1", "2", "3"), "1", "borehole"),
    (("4", "5", "6"), "2", "surface"),
)
AXES: Final[dict[str, tuple[str, float | None, int, Sensor]]] = {
    code: (f"{axis}{number}", azimuth, vertical, sensor)
    for codes, number, sensor in _SENSORS
    for code, (axis, azimuth, vertical) in zip(codes, (("NS", 0.0, 0), ("EW", 90.0, 0), ("UD", None, 1)), strict=True)
}
"""Direction code: extension of the file's name, azimuth, vertical sense, sensor."""

JAPAN: Final = timedelta(hours=9)


def detect(source: SourceFile) -> bool:
    """Whether a file begins like K-NET ASCII."""
    return source.data[:32].lstrip(b"\xef\xbb\xbf").startswith(b"Origin Time")


def read(source: SourceFile) -> list[Component]:
    """Read one component: counts times gain in m/s², offset still in; a RecordError names a wrong header line."""
    header = _header(source)
    rate = header.number("Sampling Freq(Hz)", header["Sampling Freq(Hz)"].removesuffix("Hz"))
    if not 1.0 <= rate <= 100_000.0:
        raise header.error("Sampling Freq(Hz)", f"sampling frequency {rate:g} Hz; correct it")
    gain = _gain(header)
    direction = header["Dir."]
    if direction not in AXES:
        raise header.error("Dir.", f"direction {direction!r}; known are {', '.join(AXES)}: correct it")
    extension, azimuth, vertical, sensor = AXES[direction]
    if source.suffix.upper() != extension and source.suffix.upper() in [known for known, *_ in AXES.values()]:
        raise header.error(
            "Dir.",
            f"direction {direction!r} in a file named .{source.suffix.upper()}; components are swapped: give the file "
            "its right name",
        )
    recorded = _time(header, "Record Time")
    counts = _counts(source)
    expected = round(header.number("Duration Time(s)") * rate)
    if counts.size != expected:
        raise RecordError(
            f"{source.name}: {counts.size} samples, header promises {expected} ({header['Duration Time(s)']} s at "
            f"{rate:g} Hz); the file is cut or holds more than one record: get it again"
        )
    trace = _through_obspy(source, header, counts)
    return [
        Component.of(
            source,
            extension,
            (azimuth, vertical),
            np.asarray(trace, dtype=np.float64) * gain,
            1.0 / rate,
            # The logger writes the time at which it triggered, 15 s into the file.
            start=recorded - timedelta(seconds=15) - JAPAN,
            station=header["Station Code"],
            event=header["Origin Time"] + " JST",
            origin=stated_time(header["Origin Time"], "%Y/%m/%d %H:%M:%S", JAPAN),
            latitude=header.number("Station Lat."),
            longitude=header.number("Station Long."),
            peak=StatedPeak(
                header.number("Max. Acc. (gal)") * GAL,
                resolution(header["Max. Acc. (gal)"]) * GAL,
                after_mean=True,
                line=KEYS.index("Max. Acc. (gal)") + 1,
            ),
            sensor=sensor,
            extra=_event(header),
        )
    ]


class _Header(dict[str, str]):
    """Texts of the header by key, and the lines that they stand in."""

    def __init__(self, lines: Lines) -> None:
        super().__init__()
        self.lines = lines

    def error(self, key: str, why: str) -> RecordError:
        return self.lines.error(KEYS.index(key), why)

    def number(self, key: str, text: str | None = None) -> float:
        """Number of a key, or in a part of its text."""
        return self.lines.number(self[key] if text is None else text, KEYS.index(key), key)


def _header(source: SourceFile) -> _Header:
    header = _Header(Lines.of(source))
    for index, key in enumerate(KEYS):
        if index >= len(source.lines):
            raise header.error(key, "the file ends in the header; get it again")
        line = source.lines[index]
        if not line.startswith(key):
            raise header.error(key, f"{line[:40]!r} where {key!r} belongs; get the file again")
        header[key] = line[len(key) :].strip()
    if not re.fullmatch(r"[A-Z0-9]{3,7}", header["Station Code"]):
        raise header.error("Station Code", f"station code {header['Station Code']!r}; correct it")
    return header


def _gain(header: _Header) -> float:
    """m/s² per count of a scale factor such as ``7845(gal)/8223790``."""
    text = header["Scale Factor"]
    match = re.fullmatch(r"([\d.]+)\s*\(gal\)\s*/\s*([\d.]+)", text)
    if match is None:
        raise header.error("Scale Factor", f"scale factor {text!r}; it reads like 7845(gal)/8223790")
    above, below = (header.number("Scale Factor", part) for part in match.groups())
    if above <= 0 or below <= 0:
        raise header.error("Scale Factor", f"scale factor {text!r}; both numbers must be positive")
    return above / below * GAL


def _time(header: _Header, key: str) -> datetime:
    try:
        return datetime.strptime(header[key], "%Y/%m/%d %H:%M:%S").replace(tzinfo=UTC)
    except ValueError as problem:
        raise header.error(key, f"{key} {header[key]!r} is no time like 2000/10/06 13:30:00; correct it") from problem


def _counts(source: SourceFile) -> np.ndarray:
    lines = Lines(source.name, source.lines[len(KEYS) :], len(KEYS))
    try:
        if re.search(r"[^ \t0-9+-]", "".join(lines.lines)):
            raise ValueError
        counts = np.array(" ".join(lines.lines).split(), dtype=np.int64)
    except (ValueError, OverflowError):
        for index, line in enumerate(lines.lines):
            for word in line.split():
                if not re.fullmatch(r"[+-]?[0-9]{1,15}", word):
                    raise lines.error(index, f"sample {word!r} is not a whole number; get the file again") from None
        raise
    _check_alignment(source, lines)
    return counts


def _check_alignment(source: SourceFile, lines: Lines) -> None:
    """Counts are set flush right: the last one of a cut file ends before its column does."""
    full = [line.rstrip() for line in lines.lines if line.strip()]
    if len(full) < 2 or source.text[-1:] in "\r\n":
        return
    ends, last = ([word.end() for word in re.finditer(r"\S+", line)] for line in full[-2:])
    if last != ends[: len(last)]:
        raise lines.error(len(lines.lines) - 1, "the last sample is cut; get the file again")


def _through_obspy(source: SourceFile, header: dict[str, str], counts: np.ndarray) -> np.ndarray:
    """The samples as obspy reads them from the canonical form of the file (whole rate, no memo), in counts.

    Rate and gain stay ours: obspy keeps the whole part of both numbers.
    """
    import obspy

    plain = dict.fromkeys(KEYS, "0") | {key: header[key] for key in ("Station Code", "Record Time", "Dir.")}
    plain |= {"Sampling Freq(Hz)": "100Hz", "Scale Factor": "1(gal)/1", "Memo.": ""}
    plain |= dict.fromkeys(("Origin Time", "Last Correction"), header["Record Time"])
    text = "\n".join(f"{key:<18}{plain[key]}" for key in KEYS) + "\n"
    text += "\n".join(source.lines[len(KEYS) :]) + "\n"
    trace = obspy.read(io.BytesIO(text.encode("ascii")), format="KNET")[0]
    if not np.array_equal(trace.data, counts):
        raise RecordError(f"{source.name}: two readings of the samples differ; report this file")
    return np.asarray(trace.data)


def _event(header: dict[str, str]) -> dict[str, float | str]:
    """What the header says about the earthquake; blank where it does not know (a magnitude may be)."""
    names = {"Mag.": "magnitude", "Depth. (km)": "depth_km", "Lat.": "event_latitude", "Long.": "event_longitude"}
    return {
        name: float(header[key]) for key, name in names.items() if re.fullmatch(r"[+-]?\d+(\.\d+)?", header[key] or "")
    }
