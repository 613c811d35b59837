"""Input of the readers: files and members of archives in memory, within limits."""

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
from pathlib import Path, PurePosixPath
from typing import Final

from overturning.errors import MissingDataError, RecordError

MAXIMUM_BYTES: Final = 200_000_000
"""Largest size of a file, or of all members of an archive, bytes; a day at 200 Hz in text has half of it."""

MAXIMUM_MEMBERS: Final = 20_000
"""Largest number of members of an archive."""

NON_RECORD_EXTENSIONS: Final = frozenset(
    ("geojson", "htm", "jpeg", "jpg", "json", "kml", "md", "pdf", "png", "py", "svg", "toml", "yaml", "yml")
) | {"db", "eps", "gif", "ini", "kmz", "ods", "odt", "pptx", "ps", "rtf", "tif", "tiff"}
"""Extensions of files that are no records: they are skipped in folders, in archives, and among several files."""

DOCUMENTS: Final = frozenset(("docx", "kmz", "ods", "odt", "pptx", "xlsx"))
"""Extensions of documents that are zip files but no archives of records."""

LEADING_BYTES: Final = b"\xef\xbb\xbf \r\n\t"
"""Bytes that may precede the first letter of a text: byte-order mark and white space."""

_JAPANESE: Final = re.compile(r"[\u3000-\u30ff\u4e00-\u9fff]{2}|[\uff66-\uff9f]{3}")
"""Japanese text: two full-width or three half-width letters in a row."""

_ARCHIVE_ERRORS: Final = (
    *(tarfile.TarError, zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError),
    # Errors of the standard library for wrong sizes and offsets in an archive's directory.
    *(ValueError, LookupError, OverflowError, struct.error),
)


@dataclass(frozen=True)
class SourceFile:
    """A record file in memory."""

    name: str  # file name without folder, for error messages
    data: bytes

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the bytes."""
        return hashlib.sha256(self.data).hexdigest()

    @cached_property
    def text(self) -> str:
        """Text decoded as UTF-8 (without a byte-order mark), else Shift-JIS (Japanese loggers), else Latin-1.

        Single accented letters of Latin-1 are also valid Shift-JIS, so Shift-JIS needs several Japanese letters.
        """
        for encoding in ("utf-8-sig", "shift_jis"):
            try:
                text = self.data.decode(encoding)
            except UnicodeDecodeError:
                continue
            if encoding != "shift_jis" or _JAPANESE.search(text):
                return text
        return self.data.decode("latin-1")

    @cached_property
    def lines(self) -> list[str]:
        """Lines, for any line ends, without a DOS end-of-file mark or zero bytes at the end of the file."""
        text = self.text.rstrip("\x1a\x00")
        # Not str.splitlines, which also breaks at form feeds and other marks that a text field may hold.
        return text.replace("\r\n", "\n").replace("\r", "\n").removesuffix("\n").split("\n")

    @property
    def suffix(self) -> str:
        """Last extension in lower case, without the dot."""
        return PurePosixPath(self.name).suffix.lower().lstrip(".")


def is_archive(data: bytes) -> bool:
    """Return True if bytes begin like a zip, gzip or tar file."""
    return data[:4] == b"PK\x03\x04" or data[:2] == b"\x1f\x8b" or data[257:262] == b"ustar"


def is_web_page(data: bytes) -> bool:
    """Return True if bytes begin like an HTML page, which servers send in place of a file before login."""
    return data[:400].lstrip(LEADING_BYTES).lower().startswith((b"<!doctype html", b"<html"))


def read_source(path: Path) -> SourceFile:
    """Read a whole file.

    Raises a MissingDataError if it does not exist, a RecordError if it is a folder, empty, unreadable or above 200 MB.
    """
    if not path.exists():
        raise MissingDataError(f"{path}: no such file; check the name, or the data folder in the config")
    if not path.is_file():
        raise RecordError(f"{path}: this is a folder or a device; name the files in it")
    size = path.stat().st_size
    if size > MAXIMUM_BYTES:
        raise RecordError(f"{path}: {size} bytes; record files larger than {MAXIMUM_BYTES} bytes are not read: cut it")
    try:
        data = path.read_bytes()
    except OSError as problem:
        raise RecordError(f"{path}: cannot be read ({problem.strerror}); check its permissions") from problem
    if not data:
        raise RecordError(f"{path}: the file is empty; get it again")
    return SourceFile(path.name, data)


def open_archive(source: SourceFile, *, _depth: int = 0, _budget: list[int] | None = None) -> Iterator[SourceFile]:
    """Yield the members of a .tar, .tar.gz or .zip file, nested archives (as NIED delivers them) included.

    Members are unpacked in memory only. A RecordError refuses member names that point out of the archive, links,
    devices, damage, more than two levels, and more than 200 MB in all. Sizes are counted while unpacking, because the
    archive's directory may state wrong ones.
    """
    budget = _budget if _budget is not None else [MAXIMUM_BYTES, MAXIMUM_MEMBERS]
    if _depth > 2:
        raise RecordError(f"{source.name}: archives nested more than twice; unpack it first")
    try:
        for member in _archive_members(source, budget):
            if is_archive(member.data) and member.suffix not in DOCUMENTS:
                yield from open_archive(member, _depth=_depth + 1, _budget=budget)
            else:
                yield member
    except RecordError:
        raise
    except _ARCHIVE_ERRORS as problem:
        raise RecordError(f"{source.name}: the archive is damaged ({problem}); download it again") from problem
    except RuntimeError as problem:  # zipfile raises it for an encrypted member.
        raise RecordError(f"{source.name}: {problem}; unpack it first") from problem


def _archive_members(source: SourceFile, remaining_budget: list[int]) -> Iterator[SourceFile]:
    """Yield the files of one archive level; ``remaining_budget`` holds the bytes and members that are still allowed."""
    for name, plain, folder, data in (_zip_members if source.data[:2] == b"PK" else _tar_members)(source):
        pure = PurePosixPath(name.replace("\\", "/"))
        if pure.is_absolute() or ".." in pure.parts or (pure.parts and ":" in pure.parts[0]):
            why = f"member {name!r} points out of the archive; unpack by hand what you trust"
            raise RecordError(f"{source.name}: {why}")
        if folder or _is_system_file(pure):
            continue
        if not plain:
            raise RecordError(f"{source.name}: member {name!r} is a link or a device; put the file itself there")
        remaining_budget[1] -= 1
        if remaining_budget[1] < 0:
            raise RecordError(f"{source.name}: more than {MAXIMUM_MEMBERS} members; unpack by hand the ones you need")
        member = data(remaining_budget[0] + 1)
        remaining_budget[0] -= len(member)
        if remaining_budget[0] < 0:
            why = f"unpacks to more than {MAXIMUM_BYTES} bytes; unpack by hand the files you need"
            raise RecordError(f"{source.name}: {why}")
        yield SourceFile(pure.name, member)


def _is_system_file(path: PurePosixPath) -> bool:
    """Return True for files of operating systems (``.DS_Store``, ``__MACOSX/._x.V2``) and plots (``x.ps.gz``)."""
    packed = (
        path.suffix.lower() == ".gz" and PurePosixPath(path.stem).suffix.lower().lstrip(".") in NON_RECORD_EXTENSIONS
    )
    return path.name.startswith(".") or "__MACOSX" in path.parts or packed


_Member = tuple[str, bool, bool, Callable[[int], bytes]]
"""Archive member: name, True for a plain file, True for a folder, and a function that reads its first n bytes."""


def _zip_members(source: SourceFile) -> Iterator[_Member]:
    """Yield the members of a zip file."""
    with zipfile.ZipFile(io.BytesIO(source.data)) as archive:
        for info in archive.infolist():

            def data(most: int, info: zipfile.ZipInfo = info) -> bytes:
                with archive.open(info) as stream:
                    return stream.read(most)

            yield info.filename, (info.external_attr >> 16) & 0o170000 != 0o120000, info.is_dir(), data


def _tar_members(source: SourceFile) -> Iterator[_Member]:
    """Yield the members of a tar file."""
    with tarfile.open(fileobj=io.BytesIO(source.data), mode="r|*") as archive:
        for info in archive:
            stream = archive.extractfile(info) if info.isreg() else None
            yield info.name, stream is not None, info.isdir(), stream.read if stream else bytes
