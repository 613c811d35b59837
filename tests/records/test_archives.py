"""Malicious archives are refused in bounded time and memory, and nothing is written."""

import bz2
import gzip
import io
import tarfile
import zipfile
from collections.abc import Sequence

import numpy as np
import pytest

from overturning.errors import RecordError
from overturning.records.check import check_records_in_files
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.read import read_record_without_processing
from overturning.records.source import SourceFile, unpack_archive
from tests.bounds import limited_time_and_memory
from tests.records.record_writers import csmip_text, knet_text
from tests.records.test_command import exit_status_of_overturning_command
from tests.records.written import TEXT_FORMATS_WITH_WRITERS

SAMPLES_IN_COUNTS = np.arange(-100, 100) * 1000
NS, EW = knet_text(SAMPLES_IN_COUNTS).encode(), knet_text(SAMPLES_IN_COUNTS[::-1], direction="E-W").encode()


def tar_archive(members: dict[str, bytes], mode: str = "w:gz", extra: Sequence[tarfile.TarInfo] = ()) -> bytes:
    """Return the bytes of a tar archive of the members, and of `extra` entries without content."""
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode=mode) as archive:
        for name, data in members.items():
            info = tarfile.TarInfo(name)
            info.size = len(data)
            archive.addfile(info, io.BytesIO(data))
        for info in extra:
            archive.addfile(info)
    return buffer.getvalue()


def zip_archive(members: dict[str, bytes]) -> bytes:
    """Return the bytes of a zip archive of the members."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return buffer.getvalue()


def test_raw_volumes_and_spectra_in_an_archive_are_skipped_with_notes(tmp_path):
    """Regression: archives with several volumes (CESMD) or velocities (PEER, ESM) were refused."""
    steps = np.random.default_rng(3).integers(-999, 999, (3, 210))
    (second,) = TEXT_FORMATS_WITH_WRITERS["csmip2"].file_texts_by_name(*steps).values()
    (first,) = TEXT_FORMATS_WITH_WRITERS["csmip1"].file_texts_by_name(*steps).values()
    first = first.replace("Rcrd of", "Record of")
    third = "RESPONSE AND FOURIER AMPLITUDE SPECTRA\n" + "1.0\n" * 50
    path = tmp_path / "ce.zip"
    path.write_bytes(zip_archive({"CE1.V3": third.encode(), "CE1.V2": second.encode(), "read.pdf": b"%PDF"}))
    record = read_record_without_processing(path)
    north, east = TEXT_FORMATS_WITH_WRITERS["csmip2"].expected_north_east(*steps[:2])
    np.testing.assert_allclose([record.north, record.east], [north, east], atol=1e-9)
    assert record.notes == ["CE1.V3 left out: it holds no acceleration"]
    path.write_bytes(zip_archive({"CE1.V1": first.encode(), "CE1.V2": second.encode(), "CE1.V3": third.encode()}))
    record = read_record_without_processing(path)
    np.testing.assert_allclose(record.north, north, atol=1e-9)
    assert record.extra["processed"] is True
    assert record.notes == [
        "CE1.V1 left out: the same is there processed",
        "CE1.V3 left out: it holds no acceleration",
    ]
    assert [finding.unprocessed_record is not None for finding in check_records_in_files([path])] == [True]
    path.write_bytes(zip_archive({"CE1.V1": first.encode(), "CE1.V3": third.encode()}))
    assert read_record_without_processing(path).extra["processed"] is False
    path.write_bytes(zip_archive({"CE1.V3": third.encode()}))
    with pytest.raises(RecordError, match=r"CE1\.V3: none of the archive's members is an accelerogram"):
        read_record_without_processing(path)
    (tmp_path / "CE1.V3").write_text(third)
    with pytest.raises(RecordError, match="volume 3"):
        read_record_without_processing(tmp_path / "CE1.V3")


@pytest.mark.parametrize(
    ("form", "old", "new"),
    [
        ("peer", "ACCELERATION TIME SERIES IN UNITS OF G", "VELOCITY TIME SERIES IN UNITS OF CM/S"),
        ("esm", "DATA_TYPE: ACCELERATION", "DATA_TYPE: DISPLACEMENT"),
        ("smc", "2 CORRECTED ACCELEROGRAM", "3 VELOCITY"),
    ],
)
def test_velocities_in_an_archive_of_accelerations_are_skipped(tmp_path, form, old, new):
    steps = np.random.default_rng(3).integers(-999, 999, (3, 210))
    files = {name: text.encode() for name, text in TEXT_FORMATS_WITH_WRITERS[form].file_texts_by_name(*steps).items()}
    others = {name.replace(".", "_other."): data.replace(old.encode(), new.encode()) for name, data in files.items()}
    assert all(data not in files.values() for data in others.values())
    path = tmp_path / "x.zip"
    path.write_bytes(zip_archive(others | files))
    record = read_record_without_processing(path)
    np.testing.assert_allclose(
        [record.north, record.east], TEXT_FORMATS_WITH_WRITERS[form].expected_north_east(*steps[:2]), atol=1e-8
    )
    assert [n for n in record.notes if "left" in n] == [f"{name} left out: it holds no acceleration" for name in others]


@pytest.mark.parametrize("pack", [zip_archive, tar_archive])
def test_extra_files_do_not_make_an_archive_unreadable(tmp_path, pack):
    """System files of macOS and Windows, plots, and documents (which may be zip files) are ignored without a note."""
    wave = 100.0 * np.sin(np.arange(1000) / 10)
    text = csmip_text({"360 Deg": (360, wave), "90 Deg": (90, 0.5 * wave)}, 100, volume=2).encode()
    resource = b"\0\5\x16\7\0\2\0\0Mac OS X        " + bytes(60)
    beside = {"__MACOSX/._x.V2": resource, "._x.V2": resource, ".DS_Store": b"\0\0\0\1Bud1", "Thumbs.db": b"\xd0\xcf"}
    beside |= {
        "x.ps.gz": gzip.compress(b"%!PS-Adobe"),
        "x.ps": b"%!PS-Adobe",
        "map.kmz": zip_archive({"doc.kml": b"<kml/>"}),
    }
    path = tmp_path / "x.zip"
    path.write_bytes(pack(beside | {"CE1/x.V2": text}))
    record = read_record_without_processing(path)
    np.testing.assert_allclose(record.north, wave / 100, atol=1e-6)
    assert [note for note in record.notes if "left out" in note] == []


def test_checking_a_folder_skips_spectra_and_velocities_next_to_accelerations(tmp_path, capsys, monkeypatch):
    """Regression: CESMD's V3 was reported as refused next to the V2 that was read, with exit status 1."""
    steps = np.random.default_rng(3).integers(-999, 999, (3, 210))
    (second,) = TEXT_FORMATS_WITH_WRITERS["csmip2"].file_texts_by_name(*steps).values()
    spectra, folder = "RESPONSE AND FOURIER AMPLITUDE SPECTRA\n" + "1.0\n" * 50, tmp_path / "ce"
    folder.mkdir()
    (folder / "CE1.V3").write_text(spectra)
    assert exit_status_of_overturning_command("records", "check", folder) == 1
    assert "CE1.V3\n  refused: " in capsys.readouterr().out
    (folder / "CE1.V2").write_text(second)
    (folder / "_SearchResults.csv").write_text(SEARCH_RESULTS)
    assert exit_status_of_overturning_command("records", "check", folder) == 0
    out = capsys.readouterr().out
    assert "CE1.V3\n  skipped: it holds no acceleration\n" in out
    assert "_SearchResults.csv\n  skipped: it holds no acceleration\n" in out
    assert "1 read, 0 refused" in out
    assert "CE1.V2\n  csmip" in out
    pages = []
    save = "overturning.figures.write.save_figure_files"
    monkeypatch.setattr(save, lambda _figure, path: pages.append(path.name))  # only the exit status is examined
    assert exit_status_of_overturning_command("records", "plot", folder, "-o", tmp_path / "pages") == 0
    assert pages == ["CE1.V2.svg"]
    (folder / "CE1.V2").write_text(second[:-2000])
    assert exit_status_of_overturning_command("records", "check", folder) == 1
    assert "0 read, 1 refused" in capsys.readouterr().out


SEARCH_RESULTS = """PEER Ground Motion Database
 -- Summary of Metadata of Selected Records --
 Result ID, Spectral Ordinate, Record Sequence Number, Horizontal-1 Acc. Filename
 1, SRSS, 1, x_228.AT2
"""


def test_a_peer_archive_is_read_despite_its_search_results_table(tmp_path):
    """Regression: an archive of PEER was refused because its table of search results is not a record."""
    steps = np.random.default_rng(3).integers(-999, 999, (3, 210))
    files = {name: text.encode() for name, text in TEXT_FORMATS_WITH_WRITERS["peer"].file_texts_by_name(*steps).items()}
    path = tmp_path / "peer.zip"
    for table, why in (
        ("_SearchResults.csv", "it holds no acceleration"),
        ("ReadMe.txt", "its format is not recognised"),
    ):
        text = SEARCH_RESULTS if table.startswith("_") else "Dear user, cite the data."
        path.write_bytes(zip_archive({table: text.encode()} | files))
        for declared in (None, DeclaredFileProperties(format="peer-at2")):
            record = read_record_without_processing(path, declared)
            np.testing.assert_allclose(
                [record.north, record.east],
                TEXT_FORMATS_WITH_WRITERS["peer"].expected_north_east(*steps[:2]),
                atol=1e-8,
            )
            assert record.notes == [f"{table} left out: {why}"]


def test_an_archive_with_an_unreadable_file_named_like_its_records_is_refused(tmp_path):
    """A damaged vertical component must not be skipped like a table that comes with the records."""
    steps = np.random.default_rng(3).integers(-999, 999, (3, 210))
    files = [text.encode() for text in TEXT_FORMATS_WITH_WRITERS["peer"].file_texts_by_name(*steps).values()]
    path = tmp_path / "peer.zip"
    path.write_bytes(zip_archive({"a.txt": files[0], "b.txt": files[1], "c.txt": files[2][300:]}))
    with pytest.raises(RecordError, match=r"c\.txt: the format is not recognised"):
        read_record_without_processing(path)


@pytest.mark.parametrize("compress", [gzip.compress, bz2.compress])
@pytest.mark.parametrize("form", ["peer", "geonet", "csmip2"])
def test_compressed_files_are_read_like_their_content(tmp_path, form, compress):
    """Regression: a compressed file that is no tar archive was called damaged."""
    steps = np.random.default_rng(3).integers(-999, 999, (3, 210))
    packed = {
        f"{name}.gz": compress(text.encode())
        for name, text in TEXT_FORMATS_WITH_WRITERS[form].file_texts_by_name(*steps).items()
    }
    for name, data in packed.items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / "x.zip").write_bytes(zip_archive(packed))
    named = [tmp_path / name for name in packed]
    for paths in (named, named[0], tmp_path / "x.zip"):
        record = read_record_without_processing(paths)
        np.testing.assert_allclose(
            [record.north, record.east], TEXT_FORMATS_WITH_WRITERS[form].expected_north_east(*steps[:2]), atol=1e-8
        )
    (tmp_path / "x.ps.gz").write_bytes(gzip.compress(b"%!PS-Adobe"))
    assert [found.unprocessed_record is None for found in check_records_in_files([tmp_path])][:1] == [False]
    for path in named:
        path.write_bytes(path.read_bytes()[:-30])
    with pytest.raises(RecordError, match="damaged"):
        read_record_without_processing(named)


@pytest.mark.parametrize(
    ("begin", "kind"),
    [
        (b"\xfd7zXZ\x00", "xz"),
        (b"7z\xbc\xaf\x27\x1c", "7z"),
        (b"Rar!\x1a\x07", "rar"),
        (b"\x1f\x9d", r"compress \(\.Z\)"),
    ],
)
def test_the_error_names_a_compression_that_is_not_read(tmp_path, begin, kind):
    (tmp_path / "x.AT2").write_bytes(begin + bytes(range(200)))
    with pytest.raises(RecordError, match=rf"x\.AT2: packed by {kind}, which is not read; unpack it first"):
        read_record_without_processing(tmp_path / "x.AT2")


def tar_entry_of_link(kind: bytes, name: str = "T.NS", target: str = "/etc/passwd") -> tarfile.TarInfo:
    """Return a tar entry for a link in place of a record file."""
    info = tarfile.TarInfo(name)
    info.type, info.linkname = kind, target
    return info


def zip_with_link() -> bytes:
    """Return the bytes of a zip archive whose only member is a symbolic link."""
    info = zipfile.ZipInfo("T.NS")
    info.external_attr = 0o120777 << 16
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr(info, "/etc/passwd")
    return buffer.getvalue()


def encrypted_zip() -> bytes:
    """Return the bytes of a zip archive whose member is marked as encrypted."""
    data = bytearray(zip_archive({"T.NS": NS}))
    data[6] |= 1
    central = data.index(b"PK\x01\x02")
    data[central + 8] |= 1
    return bytes(data)


VALID_MEMBERS = {"T.NS": NS, "T.EW": EW}
HARMFUL_ARCHIVES = {
    "tar out of the folder": (tar_archive({"../T.NS": NS, "T.EW": EW}), "points out"),
    "tar absolute": (tar_archive({"/tmp/T.NS": NS, "T.EW": EW}), "points out"),
    "zip out of the folder": (zip_archive({"a/../../T.NS": NS}), "points out"),
    "zip with backslashes": (zip_archive({"..\\T.NS": NS}), "points out"),
    "zip on a drive": (zip_archive({"C:\\T.NS": NS}), "points out"),
    "tar with a symbolic link": (tar_archive(VALID_MEMBERS, extra=[tar_entry_of_link(tarfile.SYMTYPE)]), "link"),
    "tar with a hard link": (
        tar_archive(VALID_MEMBERS, extra=[tar_entry_of_link(tarfile.LNKTYPE, "x", "T.NS")]),
        "link",
    ),
    "tar with a device": (tar_archive(VALID_MEMBERS, extra=[tar_entry_of_link(tarfile.CHRTYPE)]), "device"),
    "tar with a pipe": (tar_archive(VALID_MEMBERS, extra=[tar_entry_of_link(tarfile.FIFOTYPE)]), "device"),
    "zip with a link": (zip_with_link(), "link"),
    "encrypted zip": (encrypted_zip(), "encrypted"),
    "cut tar.gz": (tar_archive(VALID_MEMBERS)[:-200], "damaged"),
    "cut zip": (zip_archive(VALID_MEMBERS)[:-50], "damaged"),
    "gzip of rubbish": (b"\x1f\x8b\x08\x00" + b"rubbish" * 20, "damaged"),
    "zip of rubbish": (b"PK\x03\x04" + b"rubbish" * 20, "damaged"),
    "too deep": (
        tar_archive(
            {
                "a.tar": tar_archive(
                    {"b.tar": tar_archive({"c.tar": tar_archive(VALID_MEMBERS, mode="w")}, mode="w")}, mode="w"
                )
            }
        ),
        "nested",
    ),
    "empty tar": (tar_archive({}, mode="w"), "two horizontal|empty|components none"),
    "only a letter": (zip_archive({"readme.txt": b"Dear user,"}), "not recognised"),
}


@pytest.mark.parametrize("name", HARMFUL_ARCHIVES)
def test_harmful_archives_are_refused(tmp_path, name):
    data, word = HARMFUL_ARCHIVES[name]
    path = tmp_path / "in" / "archive.bin"
    path.parent.mkdir()
    path.write_bytes(data)
    with pytest.raises(RecordError, match=word):
        read_record_without_processing(path)
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["archive.bin", "in"]


def archive_bomb(kind: str) -> bytes:
    """Return an archive of a kind (zip, many, gz, bz2, tar) that unpacks to too many bytes or, for many, files."""
    zeros = b"\0" * 10_000_000
    buffer = io.BytesIO()
    if kind == "zip":
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("T.NS", "w") as member:
            for _ in range(60):
                member.write(zeros)
        return buffer.getvalue()
    if kind == "many":
        with zipfile.ZipFile(buffer, "w") as archive:
            for number in range(25_000):
                archive.writestr(f"{number}.NS", b"x")
        return buffer.getvalue()
    if kind in ("gz", "bz2"):
        return (gzip if kind == "gz" else bz2).compress(b"1" * 300_000_000)
    return tar_archive({"T.NS": b"\0" * 300_000_000})


@pytest.mark.long
@pytest.mark.parametrize("kind", ["zip", "tar", "many", "gz", "bz2"])
def test_archive_bombs_are_refused_within_1_gb_and_10_s(tmp_path, kind):
    path = tmp_path / "bomb.zip"
    path.write_bytes(archive_bomb(kind))
    with limited_time_and_memory(), pytest.raises(RecordError):
        read_record_without_processing(path)


def test_an_archive_member_larger_than_its_stated_size_is_refused():
    """A zip member with more bytes than the ten stated in the directory is refused."""
    data = bytearray(zip_archive({"T.NS": b"\0" * 1000}))
    central = data.index(b"PK\x01\x02")
    data[central + 24 : central + 28] = (10).to_bytes(4, "little")
    with pytest.raises(RecordError):
        list(unpack_archive(SourceFile("x.zip", bytes(data))))
