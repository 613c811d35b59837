"""Input of the readers: files and members of archives in memory, within limits."""

import bz2
import codecs
import gzip
import hashlib
import io
import re
import struct
import tarfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path, PurePath, PurePosixPath
from typing import Final, NamedTuple

from overturning.errors import MissingDataError, RecordError

MAX_FILE_OR_ARCHIVE_BYTES: Final = 200_000_000
"""Largest size of a file, or of all members of an archive, bytes; a day at 200 Hz in text has half of it."""

MAX_ARCHIVE_MEMBERS: Final = 20_000
"""Largest number of members of an archive."""

NON_RECORD_EXTENSIONS: Final = frozenset(
    ("geojson", "htm", "jpeg", "jpg", "json", "kml", "md", "pdf", "png", "py", "svg", "toml", "yaml", "yml")
) | {"db", "eps", "gif", "ini", "kmz", "ods", "odt", "pptx", "ps", "rtf", "tif", "tiff"}
"""Extensions of files that are no records: they are skipped in folders, in archives, and among several files."""

ZIPPED_DOCUMENT_EXTENSIONS: Final = frozenset(("docx", "kmz", "ods", "odt", "pptx", "xlsx"))
"""Extensions of documents that are zip files but no archives of records."""

UNSUPPORTED_ARCHIVE_BY_FIRST_BYTES: Final = {
    b"\xfd7zXZ\x00": "xz", b"7z\xbc\xaf\x27\x1c": "7z", b"Rar!\x1a\x07": "rar", b"\x1f\x9d": "compress (.Z)",
}  # fmt: skip
"""Kinds of archives and compressed files that are not read, by their first bytes."""

IGNORED_LEADING_BYTES: Final = b"\xef\xbb\xbf \r\n\t"
"""Bytes that may precede the first letter of a text: byte-order mark and white space."""

_JAPANESE_TEXT_PATTERN: Final = re.compile(r"[\u3000-\u30ff\u4e00-\u9fff]{2}|[\uff66-\uff9f]{3}")
"""Japanese text: two full-width or three half-width letters in a row."""

_ARCHIVE_ERRORS: Final = (
    *(tarfile.TarError, zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError),
    # Errors of the standard library for wrong sizes and offsets in an archive's directory.
    *(ValueError, LookupError, OverflowError, struct.error),
)


@dataclass(frozen=True)
class SourceFile:
    """Name and content of a record file, read into memory."""

    name: str  # file name without folder, for error messages
    data: bytes

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the content of the file, as hexadecimal digits."""
        return hashlib.sha256(self.data).hexdigest()

    @cached_property
    def text(self) -> str:
        """Content of the file as text, decoded as UTF-8, else Shift-JIS (Japanese loggers), else Latin-1.

        A file that begins with the byte-order mark of UTF-16 is decoded as UTF-16. Accented letters in Latin-1 can also
        be valid Shift-JIS, so a file counts as Shift-JIS only if it has two or three Japanese letters in a row.
        """
        if self.data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
            return self.data.decode("utf-16", errors="replace")
        for encoding in ("utf-8-sig", "shift_jis"):
            try:
                text = self.data.decode(encoding)
            except UnicodeDecodeError:
                continue
            if encoding != "shift_jis" or _JAPANESE_TEXT_PATTERN.search(text):
                return text
        return self.data.decode("latin-1")

    @cached_property
    def lines(self) -> list[str]:
        """Lines of the file, without line ends and without an end-of-file mark or zero bytes at the end of the file."""
        text = self.text.rstrip("\x1a\x00")
        while "\r\r\n" in text:  # Transfers in text mode may double the carriage return.
            text = text.replace("\r\r\n", "\r\n")
        # Not str.splitlines, which also breaks at form feeds and other marks that a text field may hold.
        return text.replace("\r\n", "\n").replace("\r", "\n").removesuffix("\n").split("\n")

    @property
    def first_bytes_for_format_detection(self) -> bytes:
        """Beginning of the file, from which its format is recognised; UTF-16 is converted to UTF-8."""
        begin = self.data[:4000]
        if begin.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
            return begin.decode("utf-16", errors="ignore").encode()
        return begin[:2000].removeprefix(codecs.BOM_UTF8)

    @property
    def extension(self) -> str:
        """Last extension of the file name in lower case, without the dot."""
        return PurePosixPath(self.name).suffix.lower().lstrip(".")


def is_archive(file_bytes: bytes) -> bool:
    """Return True if the bytes of a file begin like those of a zip, tar, gzip or bzip2 file."""
    compressed = file_bytes[:2] == b"\x1f\x8b" or (file_bytes[:3] == b"BZh" and file_bytes[4:8] == b"1AY&")
    return file_bytes[:4] == b"PK\x03\x04" or compressed or file_bytes[257:262] == b"ustar"


def is_web_page(file_bytes: bytes) -> bool:
    """Return True if bytes begin like an HTML page, which servers may send instead of a file."""
    return file_bytes[:400].lstrip(IGNORED_LEADING_BYTES).lower().startswith((b"<!doctype html", b"<html"))


def read_source_file(path: Path) -> SourceFile:
    """Read a whole file into memory.

    Raises a MissingDataError if it does not exist, a RecordError if it is a folder, empty, unreadable or above 200 MB.
    """
    try:
        if not path.exists():
            raise MissingDataError(f"{path}: no such file; check the name, or the data folder in the config")
        if not path.is_file():
            raise RecordError(f"{path}: this is a folder or a device; name the files in it")
        if (size := path.stat().st_size) > MAX_FILE_OR_ARCHIVE_BYTES:
            raise RecordError(
                f"{path}: {size} bytes; record files larger than {MAX_FILE_OR_ARCHIVE_BYTES} bytes are not read: cut it"
            )
        data = path.read_bytes()
    except MissingDataError:  # an OSError, too
        raise
    except OSError as problem:
        raise RecordError(f"{path}: cannot be read ({problem.strerror}); check its name and permissions") from problem
    if not data:
        raise RecordError(f"{path}: the file is empty; get it again")
    return SourceFile(path.name, data)


def unpack_archive(
    archive_file: SourceFile, *, _nesting_depth: int = 0, _remaining_byte_and_member_counts: list[int] | None = None
) -> Iterator[SourceFile]:
    """Yield the files in a .zip or tar archive and in archives inside it, or the single file in a .gz or .bz2 file.

    Members are unpacked in memory only. Raises a RecordError if the archive is damaged, if a member is a link or a
    device or its name points out of the archive, if archives are nested more than twice, or if all members together
    exceed 200 MB or `MAX_ARCHIVE_MEMBERS`. Sizes are counted while unpacking, because the archive's directory may
    state wrong ones.
    """
    remaining = (
        _remaining_byte_and_member_counts
        if _remaining_byte_and_member_counts is not None
        else [MAX_FILE_OR_ARCHIVE_BYTES, MAX_ARCHIVE_MEMBERS]
    )
    if _nesting_depth > 2:
        raise RecordError(f"{archive_file.name}: archives nested more than twice; unpack it first")
    try:
        for member in _archive_members(archive_file, remaining):
            if is_archive(member.data) and member.extension not in ZIPPED_DOCUMENT_EXTENSIONS:
                yield from unpack_archive(
                    member, _nesting_depth=_nesting_depth + 1, _remaining_byte_and_member_counts=remaining
                )
            else:
                yield member
    except RecordError:
        raise
    except _ARCHIVE_ERRORS as problem:
        raise RecordError(f"{archive_file.name}: the archive is damaged ({problem}); download it again") from problem
    except RuntimeError as problem:  # zipfile raises it for an encrypted member.
        raise RecordError(f"{archive_file.name}: {problem}; unpack it first") from problem


def _archive_members(archive_file: SourceFile, remaining_byte_and_member_counts: list[int]) -> Iterator[SourceFile]:
    """Yield the files in an archive; an archive inside it is yielded as a file.

    ``remaining_byte_and_member_counts`` holds the numbers of bytes and members that are still allowed.
    """
    for member in (_zip_members if archive_file.data[:2] == b"PK" else _tar_members)(archive_file):
        name = member.name
        pure = PurePosixPath(name.replace("\\", "/"))
        if pure.is_absolute() or ".." in pure.parts or (pure.parts and ":" in pure.parts[0]):
            why = f"member {name!r} points out of the archive; unpack by hand what you trust"
            raise RecordError(f"{archive_file.name}: {why}")
        if member.is_folder or is_system_file_or_compressed_plot(pure):
            continue
        if not member.is_plain_file:
            raise RecordError(f"{archive_file.name}: member {name!r} is a link or a device; put the file itself there")
        remaining_byte_and_member_counts[1] -= 1
        if remaining_byte_and_member_counts[1] < 0:
            raise RecordError(
                f"{archive_file.name}: more than {MAX_ARCHIVE_MEMBERS} members; unpack by hand the ones you need"
            )
        content = member.read_first_bytes(remaining_byte_and_member_counts[0] + 1)
        remaining_byte_and_member_counts[0] -= len(content)
        if remaining_byte_and_member_counts[0] < 0:
            why = f"unpacks to more than {MAX_FILE_OR_ARCHIVE_BYTES} bytes; unpack by hand the files you need"
            raise RecordError(f"{archive_file.name}: {why}")
        yield SourceFile(pure.name, content)


def is_system_file_or_compressed_plot(path: PurePath) -> bool:
    """Return True if the path is that of a system file (``.DS_Store``) or a compressed plot (``x.ps.gz``)."""
    packed = path.suffix.lower() == ".gz" and PurePath(path.stem).suffix.lower().lstrip(".") in NON_RECORD_EXTENSIONS
    return path.name.startswith(".") or "__MACOSX" in path.parts or packed


def has_non_record_name(path: PurePath) -> bool:
    """Return True if a file is hidden, or has an extension that no record format uses, such as that of a picture."""
    return path.suffix.lower().lstrip(".") in NON_RECORD_EXTENSIONS or is_system_file_or_compressed_plot(path)


class _ArchiveMember(NamedTuple):
    """Member of a zip or tar archive, which is not unpacked yet."""

    name: str  # path in the archive
    is_plain_file: bool  # False for a folder, link or device
    is_folder: bool
    read_first_bytes: Callable[[int], bytes]  # unpacks up to the given number of bytes


def _zip_members(archive_file: SourceFile) -> Iterator[_ArchiveMember]:
    """Yield the members of a zip file, without unpacking them."""
    with zipfile.ZipFile(io.BytesIO(archive_file.data)) as archive:
        for info in archive.infolist():

            def read_zip_member(max_bytes: int, member_info: zipfile.ZipInfo = info) -> bytes:
                """Unpack up to ``max_bytes`` bytes of one member of the zip file."""
                with archive.open(member_info) as stream:
                    return stream.read(max_bytes)

            is_plain_file = not info.is_dir() and (info.external_attr >> 16) & 0o170000 != 0o120000
            yield _ArchiveMember(info.filename, is_plain_file, info.is_dir(), read_zip_member)


def _is_single_compressed_file(archive_file: SourceFile) -> bool:
    """Return True if a compressed file (.gz, .bz2) holds a single file and not a tar archive."""
    try:
        tarfile.open(fileobj=io.BytesIO(archive_file.data), mode="r|*").close()
    except tarfile.ReadError:
        return archive_file.data[257:262] != b"ustar"
    return False


def _tar_members(archive_file: SourceFile) -> Iterator[_ArchiveMember]:
    """Yield the members of a tar file, without unpacking them.

    If the file is a single compressed file, its content is the only member, named without ``.gz`` or ``.bz2``.
    """
    if _is_single_compressed_file(archive_file):
        decompress = bz2.open if archive_file.data[:2] == b"BZ" else gzip.open
        with decompress(io.BytesIO(archive_file.data)) as content:
            yield _ArchiveMember(PurePosixPath(archive_file.name).stem, True, False, content.read)
        return
    with tarfile.open(fileobj=io.BytesIO(archive_file.data), mode="r|*") as archive:
        for info in archive:
            stream = archive.extractfile(info) if info.isreg() else None
            yield _ArchiveMember(info.name, stream is not None, info.isdir(), stream.read if stream else bytes)
