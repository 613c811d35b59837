"""Small files in the formats of further networks, written from numbers; see record_writers."""

import numpy as np

from tests.records.record_writers import (
    cosmos_text,
    fixed_width_columns,
    format_header_filled_from_template,
    list_of_header_numbers_with_known_values,
    time_acceleration_pairs_text,
)


def cwa_text(north, east, up, rate: int = 100, sequence: str = "Time U(+); N(+); E(+)") -> str:
    """Return the text of a CWA file (Taiwan) with samples in Gal; ``sequence`` states the order of the columns."""
    named = {"N": np.asarray(north, float), "E": np.asarray(east, float), "U": np.asarray(up, float)}
    count = named["N"].size
    columns = [named[word[0]] for word in sequence.removeprefix("Time").split(";") for word in [word.strip()]]
    peaks = {axis: (samples.max(), samples.min()) for axis, samples in named.items()}
    rows = np.column_stack([np.arange(count) / rate, *columns])
    stated = format_header_filled_from_template("cwa", named["N"], 1 / rate, rate=rate, sequence=sequence, **peaks)
    return stated + "".join("".join(f"{v:10.3f}" for v in row) + "\n" for row in rows)


def nsmn_text(north, east, up, interval: float = 0.01) -> str:
    """Return the text of an NSMN file (Türkiye) with samples in Gal."""
    columns = [np.asarray(x, float) for x in (north, east, up)]
    peaks = " ".join(f"({a}) {np.abs(x).max():.6f}" for a, x in zip(("N-S", "E-W", "U-D"), columns, strict=True))
    rows = zip(*columns, strict=True)
    stated = format_header_filled_from_template("nsmn", columns[0], interval, peaks=peaks)
    return stated + "".join("".join(f"{v:13.6f}" for v in row) + "\n" for row in rows)


def bhrc_text(components: dict, rate: float = 200.0, azimuths: tuple[int, int] = (324, 54)) -> str:
    """Return the text of a BHRC file (Iran); ``components`` maps L, V and T to samples in g/10."""
    text = ""
    for number, (axis, samples) in enumerate(components.items(), 1):
        samples = np.asarray(samples, float)
        real = [0.0193424, 0.64, samples.size / rate, 0.0, 0.1, rate, *[0.0] * 26]
        text += format_header_filled_from_template(
            "bhrc", samples, 1 / rate, axis=axis, number=number, azimuths=azimuths
        )
        text += fixed_width_columns(list_of_header_numbers_with_known_values(88, 0, {25: (samples.size,)}), 5, 0, 14)
        reals = [f"{v:13.6E}" for v in real]
        text += "".join("".join(reals[i : i + 5]) + "   .00\n" for i in range(0, 30, 5)) + "".join(reals[30:32]) + "\n"
        text += fixed_width_columns(samples, 13, 6, 10, form="E") + "/&\n"
    return text


def unam_text(channels: dict, interval: float = 0.01, first: str = "07:19:20.50") -> str:
    """Return the text of a UNAM file (Mexico, ASA 2.0); ``channels`` maps axis (N00E, V, N90W) to samples in Gal."""
    columns = [np.asarray(x, float) for x in channels.values()]
    stated = {
        "axes": channels,
        "intervals": [interval] * len(columns),
        "lengths": [round(x.size * interval, 3) for x in columns],
        "counts": [x.size for x in columns],
        "peaks": [f"{x[np.abs(x).argmax()]:.2f}" for x in columns],
    }
    listed = {name: f"/{'/'.join(map(str, each))}/" for name, each in stated.items()}
    rows = zip(*columns, strict=True)
    return format_header_filled_from_template("unam", columns[0], interval, first=first, **listed) + "".join(
        "".join(f"{v:12.2f}" for v in row) + "\n" for row in rows
    )


def renadic_text(
    channels: dict, interval: float = 0.005, *, first: str = "02/27/2010 6:34:50",
    trigger: str = "2/27/2010 6:35:10.600", recorder: str = "ETNA",
) -> str:  # fmt: skip
    """Return the text of a RENADIC file (Chile); ``channels`` maps L, T and V to samples in g/10."""
    coded = {axis: (0, samples) for axis, samples in channels.items()}
    return time_acceleration_pairs_text(coded, interval, "renadic", first=first, trigger=trigger, recorder=recorder)


def cosmos_counts_text(a, b, *, microvolts=2000.0, volts_per_g=1.25, gain=2.0):
    """Return a COSMOS volume 0 file of counts; its header states µV per count, sensitivity (V/g) and gain."""
    text = cosmos_text({"340 deg": (340, a), "70 deg": (70, b)}, 0.01, unit=50, kind="Raw")
    lines = text.splitlines(keepends=True)
    for at in [i for i, line in enumerate(lines) if "Real-header" in line]:
        real = [float(line[k : k + 13]) for line in lines[at + 1 : at + 18] for k in range(0, len(line) - 1, 13)]
        real[21], real[41], real[46] = microvolts, volts_per_g, gain
        lines[at + 1 : at + 18] = fixed_width_columns(real, 13, 6, 6).splitlines(keepends=True)
    return "".join(lines)


def usc_text(channels: dict, time=None, *, code: dict | None = None, narrow: bool = False) -> str:
    """Return the text of a USC volume 1; ``channels`` maps axis (N28W, UP) to samples in g/10, by default 5 ms apart.

    ``code`` maps an axis to its code in the integer header, in place of the usual one. ``narrow`` selects the variant
    with narrower integers and shorter lines.
    """
    codes = {"N28W": 332, "S62W": 242, "VERT": 400, "UP": 500, "DOWN": 600} | (code or {})
    per_line, width, pairs_per_line = (20, 4, 4) if narrow else (16, 5, 5)
    text = ""
    for axis, samples in channels.items():
        samples = np.asarray(samples, float)
        moments = np.arange(samples.size) * 0.005 if time is None else np.asarray(time, float)[: samples.size]
        places = (99, 34, 25, 9, 118, 25, 34, 34, 12, 48, 118, 32, 13)
        whole = list_of_header_numbers_with_known_values(
            100, 0, {8: places, 21: (1, 17, 1994, 1230, 4, codes[axis], samples.size)}
        )
        real = (0.039, 0.577, moments[-1], 0.638, 0.1, 1.86, 34.213, 118.537, 34.419, 118.426, 25.122, 6.7)
        text += format_header_filled_from_template(
            "usc", samples, 0.005, axis=axis, width=len(axis) + 5, end=moments[-1]
        )
        text += fixed_width_columns(whole, width, 0, per_line) + fixed_width_columns(
            list_of_header_numbers_with_known_values(50, 0.0, {0: real}), 10, 3, 8
        )
        data = fixed_width_columns(np.column_stack([moments, samples]).ravel(), 7, 3, 2 * pairs_per_line)
        text += "".join(f" {line}\n" for line in data.splitlines()) + ("END OF CHANNEL\n" if len(channels) > 1 else "")
    return text


def csmnc_text(samples, *, axis: str, interval: float = 0.01) -> str:
    """Return the text of a CSMNC file (China) with samples in Gal, eight to a line."""
    samples = np.asarray(samples, float)
    words = [f"{value:.6E}".replace("E+0", "E+").replace("E-0", "E-").rjust(13) for value in samples]
    lines = ("".join(words[i : i + 8]) + " \n" for i in range(0, len(words), 8))
    return format_header_filled_from_template("csmnc", samples, interval, axis=axis) + "".join(lines)


def jma_text(north, east, up, rate: int = 100) -> str:
    """Return the text of a JMA CSV file with samples in Gal."""
    rows = zip(*(np.asarray(x, float) for x in (north, east, up)), strict=True)
    stated = format_header_filled_from_template("jma", np.asarray(north, float), 1 / rate, rate=rate)
    return stated + "".join(",".join(f"{v:.3f}" for v in row) + "\n" for row in rows)


def cismid_text(north, east, up, rate: int = 50) -> str:
    """Return the text of a CISMID file (Peru) with times and samples in Gal."""
    east, north, up = (np.asarray(x, float) for x in (east, north, up))
    peaks = " ".join(f"{x[np.abs(x).argmax()]:9.2f}" for x in (east, north, up))
    rows = zip(np.arange(north.size) / rate, east, north, up, strict=True)
    stated = format_header_filled_from_template("cismid", north, 1 / rate, rate=rate, peaks=peaks)
    return stated + "".join("".join(f"{v:16.4f}" for v in row) + "\n" for row in rows)
