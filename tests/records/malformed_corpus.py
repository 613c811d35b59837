"""Valid files of every text format, and mutations that make them invalid."""

import re
from collections.abc import Callable, Iterator

import numpy as np

from tests.records.written import TEXT_FORMATS_WITH_WRITERS

random = np.random.default_rng(5)
SAMPLES_IN_COUNTS = [random.integers(-400_000, 400_000, 200) for _ in range(2)]
SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION = [np.round(random.normal(0, 500, 203)) for _ in range(2)]
VALID_FILES_AND_HEADER_LINE_COUNTS = {
    form: (written.file_texts_by_name(*SAMPLES_AS_MULTIPLES_OF_FORMAT_RESOLUTION), written.header_line_count)
    for form, written in TEXT_FORMATS_WITH_WRITERS.items()
}
"""Files of one record (name, content) and the number of header lines of the first, which is mutated."""


UNDETECTABLE_MUTATIONS = {
    "jma": ("last line missing", "a line of samples missing", "a line of samples twice", "cut at 90 %")
}
"""Mutations by format without a sample count in the header, after which the file still looks complete."""


def text_mutation_from_change_of_lines(change: Callable[[list[str]], list[str]]) -> Callable[[str], bytes]:
    """Return a mutation, from text to damaged bytes, that applies a change to the list of the text's lines."""
    return lambda text: "".join(change(text.splitlines(keepends=True))).encode()


def line_change_replacing_first_number(index: int, word: str) -> Callable[[list[str]], list[str]]:
    """Return a change that replaces the first number of a line by a word of the same width."""

    def replace_first_number_in_line_by_word(lines: list[str]) -> list[str]:
        found = re.search(r"[+-]?\d*\.?\d+(E[+-]?\d+)?", lines[index])
        assert found
        width = max(found.end() - found.start(), 1)
        spoilt = lines[index][: found.start()] + word[:width].rjust(width) + lines[index][found.end() :]
        return [*lines[:index], spoilt, *lines[index + 1 :]]

    return replace_first_number_in_line_by_word


def named_mutations_of_any_text_format(header_line_count: int) -> Iterator[tuple[str, Callable[[str], bytes]]]:
    """Yield (name, mutation) for a text file of any format; a mutation turns text into damaged bytes."""
    for percent in (1, 5, 10, 20, 30, 40, 50, 60, 70, 80, 90, 95, 99):
        yield f"cut at {percent} %", lambda t, p=percent: t[: len(t) * p // 100].encode()
    for characters in (1, 2, 3, 5, 8, 13, 40, 100):
        yield f"last {characters} characters cut", lambda t, n=characters: t.rstrip("\n")[:-n].encode()
    yield "last line missing", text_mutation_from_change_of_lines(lambda ls: ls[:-1])
    yield (
        "a line of samples missing",
        text_mutation_from_change_of_lines(lambda ls: ls[: header_line_count + 3] + ls[header_line_count + 4 :]),
    )
    yield (
        "a line of samples twice",
        text_mutation_from_change_of_lines(lambda ls: ls[: header_line_count + 3] + ls[header_line_count + 2 :]),
    )
    yield "no samples", text_mutation_from_change_of_lines(lambda ls: ls[:header_line_count])
    yield "only the first line", text_mutation_from_change_of_lines(lambda ls: ls[:1])
    yield "header missing", text_mutation_from_change_of_lines(lambda ls: ls[header_line_count:])
    yield "two records in one", lambda t: (t + t).encode()
    yield "empty", lambda _t: b""
    yield "blanks only", lambda _t: b"  \n \n"
    yield "BOM", lambda t: b"\xef\xbb\xbf" + t.encode()
    yield "CRLF", lambda t: t.replace("\n", "\r\n").encode()
    yield "CR CRLF", lambda t: t.replace("\n", "\r\r\n").encode()
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
    joined = text_mutation_from_change_of_lines(
        lambda ls: [*ls[:header_line_count], re.sub(r"(\d) +(-\d)", r"\1\2", "".join(ls[header_line_count:]), count=1)]
    )
    yield "columns that touch", joined
    for word in ("NaN", "inf", "******", "1.2.3", "--5", "0x1F", "1_0", "", "1,5", "abc", "1E", "٣"):
        yield (
            f"sample is {word!r}",
            text_mutation_from_change_of_lines(line_change_replacing_first_number(header_line_count + 5, word)),
        )
    for line in range(header_line_count):
        for digit in "* ":
            starred = text_mutation_from_change_of_lines(
                lambda ls, i=line, d=digit: [*ls[:i], re.sub(r"\d", d, ls[i]), *ls[i + 1 :]]
            )
            yield f"header line {line + 1} with {digit!r} for its digits", starred
        yield (
            f"header line {line + 1} missing",
            text_mutation_from_change_of_lines(lambda ls, i=line: ls[:i] + ls[i + 1 :]),
        )
    yield "Shift-JIS in the first text", lambda t: t.replace("\n", "\n地震 ", 1).encode("shift_jis")


TEXT_REPLACEMENTS_BY_FORMAT: dict[str, list[tuple[str, ...]]] = {
    "knet": [
        ("100Hz", "0Hz", "99.5Hz", "-100Hz", "1e9Hz"),
        ("Mag.              6.1", "Mag.              "),
        ("2000(gal)", "0(gal)", "-2000(gal)"),
        ("/8388608", "/0"),
        ("N-S", "E-W", "H1"),
        ("Duration Time(s)  2", "Duration Time(s)  3"),
        ("TST001", "TST001XYZ", ""),
        ("Record Time       2001/02", "Record Time       2001/13"),
    ],
    "geonet": [
        ("Component N28W", "Component S62W", "Component H1  "),
        ("mm/s/s at", "g      at"),
        ("at 0.020 sec", "at 0.010 sec"),
        ("points  203", "points  202"),
    ],
    "csmip1": [
        ("Uncorrected Accelerogram", "RESPONSE AND FOURIER AMPLITUDE SPECTRA"),
        ("Chan  1: 90 Deg", "Chan  1: 360 Deg", "Chan  1: H1"),
        ("in units of g.", "in units of counts."),
        ("points at 100 pts/sec", "points at 0 pts/sec", "points at 200 pts/sec"),
    ],
    "csmip-pairs": [
        ("SEC AND G/10", "SEC AND VOLT"),
        ("NO. OF POINTS = 203", "NO. OF POINTS = 999", "NO. OF POINTS = 190"),
        ("  0.200", "  0.207"),
    ],
    "cosmos": [
        ("1: 340 deg", "1: 70 deg"),
        ("cm/sec2(04)", "counts(50)", "g(02)"),
        ("acceleration pts", "velocity pts"),
        ("    203  acceleration", "    999  acceleration", "    195  acceleration", "999999999999  acceleration"),
        ("Format=(8F10.5)", "Format=(0F00.0)"),
    ],
    "smc": [
        ("component=    360", "component=    270"),
        ("2 CORRECTED ACCELEROGRAM", "3 VELOCITY"),
        ("2.0000000E+02", "0.0000000E+00", "2.0000000E+32"),
        ("       203", "       999", "       100"),
    ],
    "peer": [
        ("NPTS=    203", "NPTS=    999", "NPTS=    195"),
        ("DT=   0.0100", "DT=   0.0000", "DT=   86400."),
        ("IN UNITS OF G", "IN UNITS OF CM/S/S", "IN UNITS OF G/10"),
        (", 228", ", H1", ", 318"),
    ],
    "cosmos0": [
        ("     1.250000", "  -999.000000"),
        ("  2000.000000", "     0.000000"),
        ("counts(50)", "cm/sec2(04)"),
    ],
    "renadic": [
        ("SEC AND G/10", "SEC AND VOLT"),
        ("NO. OF POINTS =    203", "NO. OF POINTS =    999", "NO. OF POINTS =    190"),
        ("  0.050", "  0.053"),
        ("/&", "  "),
    ],
    "cwa": [
        ("gal. DC", "counts DC"),
        ("Time U(+); N(+); E(+)", "Time N(+); U(+); E(+)"),
        ("N(+)", "H1(+)", "N"),
        ("SampleRate(Hz): 100", "SampleRate(Hz): 0", "SampleRate(Hz): 200"),
        ("RecordLength(sec): 2.03", "RecordLength(sec): 4.06"),
        ("     0.050", "     0.055"),
    ],
    "nsmn": [
        ("NUMBER OF DATA\t:\t203", "NUMBER OF DATA\t:\t999"),
        ("(sec)\t:\t0.010000", "(sec)\t:\t0.000000"),
        ("RAW PGA VALUES (gal)", "RAW PGA VALUES (g)"),
        ("N-S          E-W", "E-W          N-S"),
        ("17/08/1999 00:01:47", "37/08/1999 00:01:47"),
        ("40.84370N-31.14888E", "40.84370N"),
    ],
    "csmnc": [
        ("UNIT: CM/SEC/SEC", "UNIT: CM/SEC", "UNIT: G"),
        ("CORRECTED ACCELERATION", "CORRECTED VELOCITY"),
        ("POINTS:  203", "POINTS:  999", "POINTS:  203.5"),
        ("OF:  0.01", "OF:  0", "OF:  0.02"),
        ("COMP. NS", "COMP. H1", "COMP. EW"),
        ("2024-01-1 12", "2024-13-1 12"),
    ],
    "jma": [
        ("gal(cm/s/s)", "g", "cm/s"),
        ("RATE= 100Hz", "RATE= 0Hz", "RATE= Hz"),
        ("NS,EW,UD", "NS,NS,UD", "X,Y,Z", "NS,EW"),
        ("2024 01 01", "2024 13 01"),
    ],
    "cismid": [
        ("cm/s2", "g", "cm/s"),
        (":   50", ":    0", ":  100"),
        (":       203", ":       999"),
        ("EW              NS              UD", "EW              EW              UD", "X  Y  Z"),
        ("0.0600", "0.0650"),
    ],
    "bhrc": [
        ("SECONDS AND G/10", "SECONDS AND G"),
        ("NO. OF POINTS =    203", "NO. OF POINTS =    999", "NO. OF POINTS =    190"),
        ("* VOL1DS", "* VOL2DS"),
        ("\nL\n", "\nX\n"),
        ("COMP L1", "COMP T1"),
        ("/&", "  "),
    ],
    "unam": [
        (": Gal (cm/s/s)", ": g"),
        (": /203/203/", ": /999/999/"),
        (": /0.01/0.01/", ": /0.0/0.0/"),
        (": /N00E/N90W/", ": /N00E/", ": /H1/N90W/"),
        ("1995/09/14", "1995/19/14"),
    ],
    "usc": [
        ("SEC AND G/10", "SEC AND G"),
        ("COMP N28W", "COMP S62W", "COMP H1  "),
        ("NO. OF POINTS =    203", "NO. OF POINTS =    999", "NO. OF POINTS =    190"),
        ("DURATION =   1.010", "DURATION =   2.010"),
        ("     0.100", "     1.000"),
        ("  0.200", "  0.190", "  0.900"),
        ("OF VOLUME I:", "OF VOLUME II:"),
        (" 1994 1230", " 1994 2530"),
    ],
    "esm": [
        ("UNITS: cm/s^2", "UNITS: cm"),
        ("NDATA: 203", "NDATA: 999"),
        ("INTERVAL_S: 0.010000", "INTERVAL_S: 0.000000"),
        ("DATA_TYPE: ACCELERATION", "DATA_TYPE: VELOCITY"),
        ("STREAM: HNE", "STREAM: HN1"),
    ],
}
"""Replacements in the first file, as (old text, new text), by format."""

JOINT_TEXT_REPLACEMENTS_BY_FORMAT = {
    "csmip1": (("/&", "  "), ("End of Data", "")),
    "cosmos": (("1: 340 deg", "1: H1"), ("     340", "     700")),
    "geonet": (("at 0.020 sec", "at 0.000 sec"), ("  0.0200", "  0.0000")),
}
"""Pairs of replacements that are wrong only together: no end mark, an unstated axis, an interval of zero."""

PEAK_PATTERNS_BY_FORMAT = {
    "knet": r"(Max\. Acc\. \(gal\)\s+)([\d.]+)",
    "geonet": r"(peak +)(-?[\d.]+)(?= mm/s/s)",
    "csmip1": r"(Max  = +-?)([\d.]+)",
    "csmip2": r"(Peak acceleration = +-?)([\d.]+)",
    "renadic": r"(MAX  = *-?)([\d.]+)",
    "nsmn": r"(\(N-S\) )([\d.]+)",
    "unam": r"(ACEL\. MAX\.\(Gal\), C1-C6 +: /)([\d.-]+)",
    "csmnc": r"(PEAK VALUE: +-?)([\d.]+)",
    "cismid": r"(MAXIMUM ACCELERATION +: +-?)([\d.]+)",
    "esm": r"(PGA_CM/S\^2: )(\S+)",
}
"""Text in front of the first stated peak, by format."""


def named_mutations_of_first_file_of_format(form: str) -> Iterator[tuple[str, Callable[[str], bytes]]]:
    """Yield (name, mutation) for the first valid file of a format; a mutation turns text into damaged bytes."""
    first = next(iter(VALID_FILES_AND_HEADER_LINE_COUNTS[form][0].values()))

    def mutation_with_replacements(*changes: tuple[str, str]) -> Callable[[str], bytes]:
        spoilt = first
        for old, new in changes:
            assert old in spoilt, f"{old!r} is not in the file"
            spoilt = spoilt.replace(old, new, -1 if len(changes) > 1 else 1)
        return lambda _text: spoilt.encode()

    yield from named_mutations_of_any_text_format(VALID_FILES_AND_HEADER_LINE_COUNTS[form][1])
    for old, *others in TEXT_REPLACEMENTS_BY_FORMAT.get(form, []):
        for new in others:
            yield f"{old!r} became {new!r}", mutation_with_replacements((old, new))
    if form in JOINT_TEXT_REPLACEMENTS_BY_FORMAT:
        yield (
            f"{JOINT_TEXT_REPLACEMENTS_BY_FORMAT[form]}",
            mutation_with_replacements(*JOINT_TEXT_REPLACEMENTS_BY_FORMAT[form]),
        )
    if form in PEAK_PATTERNS_BY_FORMAT:
        off = re.sub(
            PEAK_PATTERNS_BY_FORMAT[form], lambda match: f"{match[1]}{1.02 * float(match[2]):.4f}", first, count=1
        )
        assert off != first
        yield "peak 2 % off", lambda _text: off.encode()
