"""Whole files of every text format, and the ways in which they are spoilt."""

import re
from collections.abc import Callable, Iterator

import numpy as np

from tests.records.record_writers import cosmos_text, csmip_text, esm_text, geonet_text, knet_text, peer_text, smc_text
from tests.records.world_writers import bhrc_text, counts_text, cwa_text, nsmn_text, renadic_text, unam_text

random = np.random.default_rng(5)
A, B = (np.round(random.normal(0, 50, 203), 1) for _ in range(2))
COUNTS = [random.integers(-400_000, 400_000, 200) for _ in range(2)]
# Per format: names and contents of the files of one record (the first is the one that is spoilt), and the number of
# header lines before the samples of the first component.
WHOLE: dict[str, tuple[dict[str, str], int]] = {
    "knet": ({"T.NS": knet_text(COUNTS[0]), "T.EW": knet_text(COUNTS[1], direction="E-W")}, 17),
    "geonet": ({"x.V2A": geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02)}, 26),
    "geonet-raw": ({"x.V1A": geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02, corrected=False)}, 26),
    "csmip1": ({"x.v1": csmip_text({"90 Deg": (90, A / 1000), "360 Deg": (360, B / 1000)}, 100)}, 28),
    "csmip2": ({"x.v2": csmip_text({"90 Deg": (90, A), "360 Deg": (360, B)}, 100, volume=2)}, 46),
    "cosmos": ({"x.v2c": cosmos_text({"340 deg": (340, A), "70 deg": (70, B)}, 0.01)}, 45),
    "smc": ({"0a.smc": smc_text(A, 200.0, "360"), "0b.smc": smc_text(B, 200.0, "270")}, 29),
    "peer": ({"x1.AT2": peer_text(A / 1000, 0.01, "228"), "x2.AT2": peer_text(B / 1000, 0.01, "318")}, 4),
    "peer-old": (
        {"x1.AT2": peer_text(A / 1000, 0.01, "228", header="oldest"), "x2.AT2": peer_text(B / 1000, 0.01, "318")},
        4,
    ),
    "cosmos0": ({"x.V0": counts_text(np.round(2 * A), np.round(2 * B))}, 45),
    "renadic": ({"x.v1": renadic_text({"NS": np.round(A / 100, 3), "EW": np.round(B / 100, 3)})}, 27),
    "cwa": ({"x.dat": cwa_text(A, B, A)}, 22),
    "nsmn": ({"x.txt": nsmn_text(A, B, A)}, 18),
    "bhrc": ({"x.V1": bhrc_text({"L": A / 100, "T": B / 100})}, 27),
    "unam": ({"x.asa": unam_text({"N00E": A, "N90W": B})}, 23),
    "esm": ({"x.HNE.ASC": esm_text(A, 0.01, "HNE"), "x.HNN.ASC": esm_text(B, 0.01, "HNN")}, 23),
}


def on_lines(change: Callable[[list[str]], list[str]]) -> Callable[[str], bytes]:
    return lambda text: "".join(change(text.splitlines(keepends=True))).encode()


def sample_replaced(index: int, word: str) -> Callable[[list[str]], list[str]]:
    """Put a word of the same width where the first number of a line is."""

    def change(lines: list[str]) -> list[str]:
        found = re.search(r"[+-]?\d*\.?\d+(E[+-]?\d+)?", lines[index])
        assert found
        width = max(found.end() - found.start(), 1)
        spoilt = lines[index][: found.start()] + word[:width].rjust(width) + lines[index][found.end() :]
        return [*lines[:index], spoilt, *lines[index + 1 :]]

    return change


def generic(header: int) -> Iterator[tuple[str, Callable[[str], bytes]]]:
    """Mutations that every text format can suffer."""
    for percent in (1, 5, 10, 20, 30, 40, 50, 60, 70, 80, 90, 95, 99):
        yield f"cut at {percent} %", lambda t, p=percent: t[: len(t) * p // 100].encode()
    for characters in (1, 2, 3, 5, 8, 13, 40, 100):
        yield f"last {characters} characters cut", lambda t, n=characters: t.rstrip("\n")[:-n].encode()
    yield "last line missing", on_lines(lambda ls: ls[:-1])
    yield "a line of samples missing", on_lines(lambda ls: ls[: header + 3] + ls[header + 4 :])
    yield "a line of samples twice", on_lines(lambda ls: ls[: header + 3] + ls[header + 2 :])
    yield "no samples", on_lines(lambda ls: ls[:header])
    yield "only the first line", on_lines(lambda ls: ls[:1])
    yield "header missing", on_lines(lambda ls: ls[header:])
    yield "two records in one", lambda t: (t + t).encode()
    yield "empty", lambda _t: b""
    yield "blanks only", lambda _t: b"  \n \n"
    yield "BOM", lambda t: b"\xef\xbb\xbf" + t.encode()
    yield "CRLF", lambda t: t.replace("\n", "\r\n").encode()
    yield "CR", lambda t: t.replace("\n", "\r").encode()
    yield "UTF-16", lambda t: t.encode("utf-16")
    yield "DOS end of file", lambda t: t.encode() + b"\x1a"
    yield "zeros behind", lambda t: t.encode() + b"\0" * 512
    yield "zeros inside", lambda t: t[: len(t) // 2].encode() + b"\0" * 64 + t[len(t) // 2 + 64 :].encode()
    yield "blank line before", lambda t: ("\n" + t).encode()
    yield "blank lines behind", lambda t: (t + "\n\n \n").encode()
    yield "a page instead", lambda _t: b"<!DOCTYPE html><html><body>Please sign in</body></html>"
    yield "binary", lambda t: bytes(range(256)) * (len(t) // 256)
    yield "text behind", lambda t: (t + "end of file, have a nice day\n").encode()
    for word in ("NaN", "inf", "******", "1.2.3", "--5", "0x1F", "1_0", "", "1,5", "abc", "1E", "٣"):
        yield f"sample is {word!r}", on_lines(sample_replaced(header + 5, word))
    for line in range(header):
        yield (
            f"header line {line + 1} starred",
            on_lines(lambda ls, i=line: [*ls[:i], re.sub(r"\d", "*", ls[i]), *ls[i + 1 :]]),
        )
        yield (
            f"header line {line + 1} without its numbers",
            on_lines(lambda ls, i=line: [*ls[:i], re.sub(r"\d", " ", ls[i]), *ls[i + 1 :]]),
        )
        yield f"header line {line + 1} missing", on_lines(lambda ls, i=line: ls[:i] + ls[i + 1 :])
    yield "Shift-JIS in the first text", on_lines_sjis(1)


def on_lines_sjis(index: int) -> Callable[[str], bytes]:
    def change(text: str) -> bytes:
        lines = text.splitlines(keepends=True)
        return "".join([*lines[:index], "地震 " + lines[index], *lines[index + 1 :]]).encode("shift_jis")

    return change


def replaced(old: str, new: str) -> Callable[[str], bytes]:
    def change(text: str) -> bytes:
        assert old in text, f"{old!r} is not in the file"
        return text.replace(old, new, 1).encode()

    return change


SPECIAL: dict[str, dict[str, Callable[[str], bytes]]] = {
    "knet": {
        "zero rate": replaced("100Hz", "0Hz"),
        "fractional rate": replaced("100Hz", "99.5Hz"),
        "negative rate": replaced("100Hz", "-100Hz"),
        "senseless rate": replaced("100Hz", "1e9Hz"),
        "blank magnitude": replaced("Mag.              6.1", "Mag.              "),
        "zero scale": replaced("2000(gal)", "0(gal)"),
        "scale over zero": replaced("/8388608", "/0"),
        "negative scale": replaced("2000(gal)", "-2000(gal)"),
        "swapped components": replaced("N-S", "E-W"),
        "unknown direction": replaced("N-S", "H1"),
        "peak 1 % off": lambda t: re.sub(
            r"(Max\. Acc\. \(gal\)\s+)([\d.]+)", lambda m: m[1] + f"{float(m[2]) * 1.01:.3f}", t
        ).encode(),
        "peak blank": lambda t: re.sub(r"(Max\. Acc\. \(gal\)\s+)([\d.]+)", r"\1", t).encode(),
        "wrong duration": replaced("Duration Time(s)  2", "Duration Time(s)  3"),
        "touching columns": lambda t: re.sub(r"(\d) +(-\d+ )", r"\1\2", t, count=1).encode(),
        "station of 9 letters": replaced("TST001", "TST001XYZ"),
        "no station": replaced("TST001", ""),
        "month 13": replaced("Record Time       2001/02", "Record Time       2001/13"),
    },
    "geonet": {
        "swapped components": replaced("Component N28W", "Component S62W"),
        "unknown axis": replaced("Component N28W", "Component H1  "),
        "another unit": replaced("mm/s/s at", "g      at"),
        "interval contradicts": replaced("at 0.020 sec", "at 0.010 sec"),
        "zero interval": lambda t: t.replace("at 0.020 sec", "at 0.000 sec").replace("  0.0200", "  0.0000").encode(),
        "count contradicts": replaced("points  203", "points  202"),
        "peak 1 % off": lambda t: re.sub(
            r"peak +(-?[\d.]+) mm/s/s", lambda m: f"peak {float(m[1]) * 1.01:.1f} mm/s/s", t, count=1
        ).encode(),
    },
    "csmip1": {
        "swapped components": replaced("Chan  1: 90 Deg", "Chan  1: 360 Deg"),
        "unknown axis": replaced("Chan  1: 90 Deg", "Chan  1: H1"),
        "counts": replaced("in units of g.", "in units of counts."),
        "zero rate": replaced("points at 100 pts/sec", "points at 0 pts/sec"),
        "another rate": replaced("points at 100 pts/sec", "points at 200 pts/sec"),
        "peak 1 % off": lambda t: re.sub(
            r"Max  = +([\d.]+) g", lambda m: f"Max  = {float(m[1]) * 1.02:.4f} g", t, count=1
        ).encode(),
        "no end mark": lambda t: t.replace("/&", "  ").replace("End of Data", "").encode(),
        "volume 3": lambda t: ("RESPONSE AND FOURIER AMPLITUDE SPECTRA\n" + t).encode(),
    },
    "cosmos": {
        "swapped components": replaced("1: 340 deg", "1: 70 deg"),
        "unknown axis": lambda t: t.replace("1: 340 deg", "1: H1", 1).replace("     340", "     700", 1).encode(),
        "counts": replaced("cm/sec2(04)", "counts(50)"),
        "velocity": replaced("acceleration pts", "velocity pts"),
        "unit contradicts": replaced("cm/sec2(04)", "g(02)"),
        "count too large": replaced("    203  acceleration", "    999  acceleration"),
        "count too small": replaced("    203  acceleration", "    195  acceleration"),
        "senseless format": replaced("Format=(8F10.5)", "Format=(0F00.0)"),
        "huge count": replaced("    203  acceleration", "999999999999  acceleration"),
    },
    "smc": {
        "swapped components": replaced("component=    360", "component=    270"),
        "velocity": replaced("2 CORRECTED ACCELEROGRAM", "3 VELOCITY"),
        "zero rate": replaced("2.0000000E+02", "0.0000000E+00"),
        "huge rate": replaced("2.0000000E+02", "2.0000000E+32"),
        "count too large": replaced("       203", "       999"),
        "count too small": replaced("       203", "       100"),
    },
    "peer": {
        "count too large": replaced("NPTS=    203", "NPTS=    999"),
        "count too small": replaced("NPTS=    203", "NPTS=    195"),
        "zero interval": replaced("DT=   0.0100", "DT=   0.0000"),
        "interval of a day": replaced("DT=   0.0100", "DT=   86400."),
        "another unit": replaced("IN UNITS OF G", "IN UNITS OF CM/S/S"),
        "unknown axis": replaced(", 228", ", H1"),
        "parallel axes": replaced(", 228", ", 318"),
    },
    "cosmos0": {
        "no sensitivity": lambda t: t.replace("     1.250000", "  -999.000000").encode(),
        "no step": lambda t: t.replace("  2000.000000", "     0.000000").encode(),
        "unit contradicts": replaced("counts(50)", "cm/sec2(04)"),
    },
    "renadic": {
        "another unit": replaced("SEC AND G/10", "SEC AND VOLT"),
        "count too large": replaced("NO. OF POINTS =    203", "NO. OF POINTS =    999"),
        "count too small": replaced("NO. OF POINTS =    203", "NO. OF POINTS =    190"),
        "uneven time": replaced("  0.050", "  0.053"),
        "peak 1 % off": lambda t: re.sub(
            r"MAX  = *([\d.]+) G", lambda m: f"MAX  ={float(m[1]) * 1.02:7.4f} G", t, count=1
        ).encode(),
        "no end mark": replaced("/&", "  "),
    },
    "cwa": {
        "another unit": replaced("gal. DC", "counts DC"),
        "swapped columns": replaced("Time U(+); N(+); E(+)", "Time N(+); U(+); E(+)"),
        "unknown column": replaced("N(+)", "H1(+)"),
        "no sign": replaced("N(+)", "N"),
        "zero rate": replaced("SampleRate(Hz): 100", "SampleRate(Hz): 0"),
        "another rate": replaced("SampleRate(Hz): 100", "SampleRate(Hz): 200"),
        "length too large": replaced("RecordLength(sec): 2.03", "RecordLength(sec): 4.06"),
        "touching columns": lambda t: re.sub(r"(\.\d{3}) +(-\d+\.\d{3}\n)", r"\1\2", t, count=1).encode(),
        "uneven time": replaced("     0.050", "     0.055"),
    },
    "nsmn": {
        "count too large": replaced("NUMBER OF DATA\t:\t203", "NUMBER OF DATA\t:\t999"),
        "zero interval": replaced("(sec)\t:\t0.010000", "(sec)\t:\t0.000000"),
        "another unit": replaced("RAW PGA VALUES (gal)", "RAW PGA VALUES (g)"),
        "columns swapped": replaced("N-S          E-W", "E-W          N-S"),
        "no such day": replaced("17/08/1999 00:01:47", "37/08/1999 00:01:47"),
        "half a place": replaced("40.84370N-31.14888E", "40.84370N"),
    },
    "bhrc": {
        "another unit": replaced("SECONDS AND G/10", "SECONDS AND G"),
        "count too large": replaced("NO. OF POINTS =    203", "NO. OF POINTS =    999"),
        "count too small": replaced("NO. OF POINTS =    203", "NO. OF POINTS =    190"),
        "volume 2": replaced("* VOL1DS", "* VOL2DS"),
        "unknown component": replaced("\nL\n", "\nX\n"),
        "component contradicts": replaced("COMP L1", "COMP T1"),
        "no end mark": replaced("/&", "  "),
    },
    "unam": {
        "another unit": replaced(": Gal (cm/s/s)", ": g"),
        "count too large": replaced(": /203/203/", ": /999/999/"),
        "zero interval": replaced(": /0.01/0.01/", ": /0.0/0.0/"),
        "an axis too few": replaced(": /N00E/N90W/", ": /N00E/"),
        "unknown axis": replaced("/N00E/", "/H1/"),
        "no such day": replaced("1995/09/14", "1995/19/14"),
    },
    "esm": {
        "another unit": replaced("UNITS: cm/s^2", "UNITS: cm"),
        "count too large": replaced("NDATA: 203", "NDATA: 999"),
        "zero interval": replaced("INTERVAL_S: 0.010000", "INTERVAL_S: 0.000000"),
        "velocity": replaced("DATA_TYPE: ACCELERATION", "DATA_TYPE: VELOCITY"),
        "unknown axis": replaced("STREAM: HNE", "STREAM: HN1"),
        "peak 1 % off": lambda t: re.sub(
            r"(PGA_CM/S\^2: )(\S+)", lambda m: m[1] + f"{float(m[2]) * 1.01:.6f}", t
        ).encode(),
    },
}
