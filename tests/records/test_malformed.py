"""A corpus of malformed files, made from well-formed ones of every format.

Each is either refused with an error that names the file and what to do, or read to the very samples of the well-formed
file. Nothing else: no other exception, and never other numbers.
"""

import random as dice
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from overturning.errors import OverturningError, RecordError
from overturning.records.assembly import assemble_record
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.files import read_components
from overturning.records.read import read_record_without_processing
from overturning.records.record import Record
from overturning.records.source import SourceFile
from tests.bounds import limited_time_and_memory
from tests.expect import expect_error
from tests.records.malformed_corpus import (
    SAMPLES_IN_COUNTS,
    UNDETECTABLE_MUTATIONS,
    VALID_FILES_AND_HEADER_LINE_COUNTS,
    named_mutations_of_first_file_of_format,
)
from tests.records.seed_writers import write_mseed, write_sac, write_stationxml_of_channels

DECLARED_UNIT_GAL = DeclaredFileProperties(unit="gal")

TEXT_FILE_MUTATION_FUNCTIONS_BY_FORMAT = {
    form: dict(named_mutations_of_first_file_of_format(form)) for form in VALID_FILES_AND_HEADER_LINE_COUNTS
}


HARMLESS_MUTATIONS = ("BOM", "CRLF", "CR CRLF", "CR", "UTF-16", "DOS end of file", "zeros behind", "blank lines behind")


def test_at_least_2126_text_mutations_and_19_byte_mutations_exist():
    assert sum(map(len, TEXT_FILE_MUTATION_FUNCTIONS_BY_FORMAT.values())) >= 2126
    assert len(BINARY_FILE_MUTATIONS) >= 19


def is_same_motion(record: Record, good: Record) -> bool:
    """True if two records have the same samples, sampling interval and axes."""
    return (
        record.sampling_interval == good.sampling_interval
        and np.array_equal(record.north, good.north)
        and np.array_equal(record.east, good.east)
        and (record.up is None) == (good.up is None)
        and record.component_azimuths_deg == good.component_azimuths_deg
    )


def write_valid_files(folder: Path, form: str) -> list[Path]:
    """Write the undamaged files of a format and return their paths."""
    paths = [folder / name for name in VALID_FILES_AND_HEADER_LINE_COUNTS[form][0]]
    for path, text in zip(paths, VALID_FILES_AND_HEADER_LINE_COUNTS[form][0].values(), strict=True):
        path.write_bytes(text.encode())
    return paths


def replace_file(path: Path, content: bytes) -> None:
    """Replace a file by a new one; some file systems write an overwritten file to disk at once."""
    path.unlink()
    path.write_bytes(content)


def describe_fault_in_reading_mutated_files(paths: list[Path], good: Record, newlines: int = 1) -> str:
    """Read damaged files and describe what is wrong with the result or the error; empty if nothing is.

    Right is an error that names a file, the samples of the undamaged record, or a note of what was left out.
    """
    try:
        with limited_time_and_memory():
            record = read_record_without_processing(paths, DECLARED_UNIT_GAL)
    except OverturningError as problem:
        message = str(problem)
        if not any(path.name in message for path in paths):
            return f"refused without the file's name: {message}"
        return "" if len(message) < 600 and message.count("\n") <= newlines else f"refused at length: {message}"
    except Exception as other:  # whatever it is, a user must never meet it
        return f"ends in {type(other).__name__}: {other}"
    told = any("left out" in note for note in record.extra.get("notes", ()))
    return "" if told or is_same_motion(record, good) else "read without a word, but not the numbers of the whole file"


@pytest.mark.parametrize("form", TEXT_FILE_MUTATION_FUNCTIONS_BY_FORMAT)
def test_a_mutated_text_file_is_refused_by_name_or_read_correctly(tmp_path, form):
    paths = write_valid_files(tmp_path, form)
    good, whole = (
        read_record_without_processing(paths, DECLARED_UNIT_GAL),
        VALID_FILES_AND_HEADER_LINE_COUNTS[form][0][paths[0].name],
    )
    objections: dict[str, str] = {}
    read: dict[bytes, str] = {}  # Mutations may make the same file, as of the digits in a line without digits.
    for name, change in TEXT_FILE_MUTATION_FUNCTIONS_BY_FORMAT[form].items():
        if (
            name in UNDETECTABLE_MUTATIONS.get(form, ()) or name in HARMLESS_MUTATIONS
        ):  # The latter are all read right: see below.
            continue
        content = change(whole)
        if content not in read:
            replace_file(paths[0], content)
            read[content] = describe_fault_in_reading_mutated_files(paths, good)
        objections[name] = read[content]
    assert {name: what for name, what in objections.items() if what} == {}


@pytest.mark.parametrize("form", VALID_FILES_AND_HEADER_LINE_COUNTS)
def test_other_encodings_and_line_ends_do_not_change_a_record(tmp_path, form):
    paths = write_valid_files(tmp_path, form)
    good, whole = (
        read_record_without_processing(paths, DECLARED_UNIT_GAL),
        VALID_FILES_AND_HEADER_LINE_COUNTS[form][0][paths[0].name],
    )
    for name in HARMLESS_MUTATIONS:
        replace_file(paths[0], TEXT_FILE_MUTATION_FUNCTIONS_BY_FORMAT[form][name](whole))
        with limited_time_and_memory():
            record = read_record_without_processing(paths, DECLARED_UNIT_GAL)
        assert is_same_motion(record, good), name


@pytest.mark.parametrize("form", VALID_FILES_AND_HEADER_LINE_COUNTS)
def test_a_randomly_damaged_file_gives_a_named_error_or_a_record(form):
    """Random changes, losses, additions and moves of bytes cause only the documented exceptions."""
    throw = dice.Random(form)
    letters = b"0123456789 .-+EeNaf*\n\r\t,:/()=|#\x00\xff\x80ABCD"
    texts = {name: text.encode() for name, text in VALID_FILES_AND_HEADER_LINE_COUNTS[form][0].items()}
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
            with limited_time_and_memory():
                assemble_record(read_components(sources, DECLARED_UNIT_GAL), "x")
        except OverturningError as problem:
            message = str(problem)
            if not any(name in message for name in texts):
                pytest.fail(message)


def write_binary_file_and_its_companion(folder: Path, form: str) -> tuple[Path, Path]:
    """Write a binary file to mutate and the file that belongs to it, such as the metadata of waveforms."""
    if form == "miniseed":
        other = write_stationxml_of_channels(folder / "s.xml", {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0)})
        counts = [np.repeat(c, 10) for c in SAMPLES_IN_COUNTS]
        return write_mseed(folder / "x.mseed", {"HNN": counts[0], "HNE": counts[1]}), other
    if form == "stationxml":
        other = write_mseed(folder / "x.mseed", {"HNN": SAMPLES_IN_COUNTS[0], "HNE": SAMPLES_IN_COUNTS[1]})
        return write_stationxml_of_channels(folder / "s.xml", {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0)}), other
    other = write_sac(folder / "b.sac", SAMPLES_IN_COUNTS[1] / 1e3, "HNE", 90.0, 90.0)
    return write_sac(folder / "a.sac", SAMPLES_IN_COUNTS[0] / 1e3, "HNN", 0.0, 90.0), other


BINARY_FILE_MUTATIONS: dict[str, Callable[[bytes], bytes]] = {
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


@pytest.mark.parametrize("form", ["miniseed", "stationxml", "sac"])
@pytest.mark.filterwarnings("ignore::UserWarning", "ignore::obspy.io.mseed.InternalMSEEDWarning")
def test_a_mutated_binary_file_is_refused_by_name_or_read_correctly(tmp_path, form):
    path, other = write_binary_file_and_its_companion(tmp_path, form)
    good, whole = read_record_without_processing([path, other], DECLARED_UNIT_GAL), path.read_bytes()
    objections = {}
    for name, change in BINARY_FILE_MUTATIONS.items():
        replace_file(path, change(whole))
        objections[name] = describe_fault_in_reading_mutated_files([path, other], good, newlines=2)  # ObsPy's own words
    assert {name: what for name, what in objections.items() if what} == {}


def test_a_folder_or_missing_file_in_place_of_a_record_is_refused(tmp_path):
    with pytest.raises(RecordError, match="folder"):
        read_record_without_processing(tmp_path)
    with pytest.raises(OverturningError, match="no such file"):
        read_record_without_processing(tmp_path / "none.V2A")
    with pytest.raises(RecordError, match=r"x\.V2A: cannot be read \(.+\); check its name and permissions"):
        read_record_without_processing(tmp_path / f"{'x' * 300}.V2A")


def test_reading_without_permission_gives_record_error(tmp_path, monkeypatch):
    path = tmp_path / "x.V2A"
    path.write_text("x")

    def raise_permission_denied(_self: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", raise_permission_denied)
    with pytest.raises(RecordError, match="Permission denied"):
        read_record_without_processing(path)


def test_stationxml_alone_and_empty_archives_are_refused_by_name(tmp_path):
    """Regression: StationXML without waveforms and archives without files ended in an IndexError."""
    alone = write_stationxml_of_channels(tmp_path / "s.xml", {"HNN": (0.0, 0.0)})
    with expect_error(RecordError, "s.xml: StationXML alone; name the file of a record, too"):
        read_record_without_processing(alone)
    path = tmp_path / "x.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("x/", b"")
        archive.writestr(".DS_Store", b"\0\0\0\1Bud1")
    for paths in (path, [path, path]):
        with expect_error(RecordError, "x.zip", "an archive without files; name the file of a record, too"):
            read_record_without_processing(paths)
