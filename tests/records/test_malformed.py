"""A corpus of malformed files, made from well-formed ones of every format.

Each is either refused with an error that names the file and what to do, or read to the very samples of the well-formed file.
Nothing else: no other exception, and never other numbers.
"""

import random as dice
import re
import resource
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from record_writers import cosmos_text, csmip_text, esm_text, geonet_text, knet_text, peer_text, smc_text
from seed_writers import write_inventory, write_mseed, write_sac

from overturning.errors import OverturningError, RecordError
from overturning.records.assembly import assemble
from overturning.records.options import ReadOptions
from overturning.records.read import read_files, read_path
from overturning.records.record import Record
from overturning.records.source import SourceFile

random = np.random.default_rng(5)
A, B = (np.round(random.normal(0, 50, 203), 1) for _ in range(2))
COUNTS = [random.integers(-400_000, 400_000, 200) for _ in range(2)]
OPTIONS = ReadOptions(unit="gal")

# Per format: names and contents of the files of one record (the first is the one that is spoilt), and the number of header
# lines before the samples of the first component.
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

CORPUS = [
    pytest.param(form, change, id=f"{form}: {name}")
    for form, (_, header) in WHOLE.items()
    for name, change in (*generic(header), *SPECIAL.get(form, {}).items())
]


@pytest.fixture(autouse=True)
def bounded() -> Iterator[None]:
    """No file may take more than 10 s or 1 GB: an alarm and a limit on the address space stand guard where the system has them."""
    if not hasattr(signal, "SIGALRM") or not Path("/proc/self/statm").exists():
        yield
        return

    def ring(_signal: int, _frame: object) -> None:
        raise AssertionError("ten seconds for one file")

    now = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(10)
    resource.setrlimit(resource.RLIMIT_AS, (now + 1_000_000_000, hard))
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def test_the_corpus_is_large_enough():
    assert len(CORPUS) + len(BINARY) >= 200


def same_motion(record: Record, good: Record) -> bool:
    return (
        record.sampling_interval == good.sampling_interval
        and np.array_equal(record.north, good.north)
        and np.array_equal(record.east, good.east)
        and (record.up is None) == (good.up is None)
        and record.component_azimuths_deg == good.component_azimuths_deg
    )


def write(folder: Path, form: str, change: Callable[[str], bytes] | None = None) -> list[Path]:
    folder.mkdir()
    paths = []
    for index, (name, text) in enumerate(WHOLE[form][0].items()):
        path = folder / name
        path.write_bytes(change(text) if change and not index else text.encode())
        paths.append(path)
    return paths


@pytest.mark.parametrize(("form", "change"), CORPUS)
def test_text_is_refused_by_name_or_read_right(tmp_path, form, change):
    good = read_path(write(tmp_path / "good", form), options=OPTIONS)
    paths = write(tmp_path / "bad", form, change)
    record, refusal = attempt(paths)
    if record is None:
        assert paths[0].name in refusal or paths[-1].name in refusal, refusal
        assert len(refusal) < 600, refusal
        assert refusal.count("\n") < 2, refusal
    else:
        assert same_motion(record, good), "read without a word, but not the numbers of the whole file"


def attempt(paths: list[Path]) -> tuple[Record | None, str]:
    """The record, or the refusal; any other exception is a failure of the test."""
    try:
        return read_path(paths, options=OPTIONS), ""
    except OverturningError as problem:
        return None, str(problem)


@pytest.mark.parametrize("form", WHOLE)
def test_random_damage_ends_in_a_named_error_or_a_record(form):
    """Bytes changed, lost, added and moved: whatever comes, no other exception."""
    throw = dice.Random(form)
    letters = b"0123456789 .-+EeNaf*\n\r\t,:/()=|#\x00\xff\x80ABCD"
    texts = {name: text.encode() for name, text in WHOLE[form][0].items()}
    spoilt = next(iter(texts))
    for _ in range(60):
        data = bytearray(texts[spoilt])
        for _ in range(throw.choice([1, 1, 2, 5, 20])):
            at = throw.randrange(min(len(data), throw.choice([3500, len(data)])))
            match throw.randrange(4):
                case 0:
                    data[at] = throw.choice(letters)
                case 1:
                    del data[at : at + throw.choice([1, 3, 10, 80])]
                case 2:
                    data[at:at] = bytes(throw.choice(letters) for _ in range(throw.choice([1, 2, 8])))
                case _:
                    start = throw.randrange(len(data))
                    data[at:at] = data[start : start + throw.choice([10, 80, 400])]
        sources = [SourceFile(name, bytes(data) if name == spoilt else text) for name, text in texts.items()]
        try:
            assemble(read_files(sources, None, OPTIONS), record_id="x")
        except OverturningError as problem:
            message = str(problem)
            if not any(name in message for name in texts):
                pytest.fail(message)


def binary_files(folder: Path, form: str) -> tuple[Path, Path]:
    """The file to spoil and the one that goes with it."""
    if form == "miniseed":
        other = write_inventory(folder / "s.xml", {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0)})
        counts = [np.repeat(c, 10) for c in COUNTS]
        return write_mseed(folder / "x.mseed", {"HNN": counts[0], "HNE": counts[1]}), other
    if form == "stationxml":
        other = write_mseed(folder / "x.mseed", {"HNN": COUNTS[0], "HNE": COUNTS[1]})
        return write_inventory(folder / "s.xml", {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0)}), other
    other = write_sac(folder / "b.sac", COUNTS[1], "HNE", 90.0, 90.0)
    return write_sac(folder / "a.sac", COUNTS[0], "HNN", 0.0, 90.0), other


BYTES: dict[str, Callable[[bytes], bytes]] = {
    **{f"cut at {p} %": (lambda d, p=p: d[: len(d) * p // 100]) for p in (1, 5, 10, 25, 50, 75, 90, 95, 99)},
    "one byte cut": lambda d: d[:-1],
    "one byte more": lambda d: d + b"\0",
    "twice": lambda d: d + d,
    "empty": lambda _d: b"",
    "zeros": lambda d: b"\0" * len(d),
    "zeros behind": lambda d: d + b"\0" * 512,
    "header zeroed": lambda d: b"\0" * 64 + d[64:],
    "text": lambda d: b"hello " * (len(d) // 6),
    "page": lambda _d: b"<html>Please sign in</html>",
    "header doubled": lambda d: d[:48] + d,
}
BINARY = [
    pytest.param(form, change, id=f"{form}: {name}")
    for form in ("miniseed", "stationxml", "sac")
    for name, change in BYTES.items()
]


@pytest.mark.parametrize(("form", "change"), BINARY)
@pytest.mark.filterwarnings("ignore::UserWarning", "ignore::obspy.io.mseed.InternalMSEEDWarning")
def test_binary_is_refused_by_name_or_read_right(tmp_path, form, change):
    path, other = binary_files(tmp_path, form)
    good = read_path([path, other], options=OPTIONS)
    path.write_bytes(change(path.read_bytes()))
    record, refusal = attempt([path, other])
    if record is None:
        assert path.name in refusal or other.name in refusal
    else:
        assert same_motion(record, good)


def test_a_folder_and_a_missing_file(tmp_path):
    with pytest.raises(RecordError, match="folder"):
        read_path(tmp_path)
    with pytest.raises(OverturningError, match="no such file"):
        read_path(tmp_path / "none.V2A")


def test_an_unreadable_file(tmp_path, monkeypatch):
    path = tmp_path / "x.V2A"
    path.write_text("x")

    def refuse(_self: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(RecordError, match="Permission denied"):
        read_path(path)
