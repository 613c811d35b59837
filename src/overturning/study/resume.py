"""Resume an earlier run: lock the folder, and remove damaged results so that they are made again.

The tools of Snakemake are not sufficient, as `verification.faults` shows: its lock remains if the process is killed; it
does not detect damage to a finished result (``ensure`` tests a result once, when it is made); and with ``update`` a
failed step restores the earlier cube with a new time, so that the next run treats it as up to date.
"""

import fcntl
import os
import re
import sys
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from overturning.errors import ResultError
from overturning.files import checksum_at_end_matches
from overturning.study.convergence import read_convergence_result
from overturning.study.ensemble_members import EnsembleParameterChanges
from overturning.study.evaluation import FIGURE_FILE_FORMATS
from overturning.study.netcdf import open_netcdf_without_masking_and_scaling

DAMAGED_FILE_LOG_PREFIX: Final = "damaged or gone, is made again if another result needs it: "
"""Log prefix of a damaged file, which was removed, or of a missing one."""

_TABLE_READERS_BY_FILE_NAME: Final[dict[str, Callable[[Path], Any]]] = {
    "members.csv": EnsembleParameterChanges.read_csv,
    "convergence.json": read_convergence_result,
}
FILE_END_BYTES_BY_SUFFIX: Final = {
    ".svg": (b"</svg>",), ".html": (b"</html>",), ".xml": (b"</nrml>",), ".json": (b"}", b"]"), ".js": (b");",),
    ".pdf": (b"%%EOF",), ".png": (b"IEND\xaeB`\x82",),
}  # fmt: skip
"""Last bytes of a complete file, apart from white space, by the extension of its name."""
END_CHECKED_FILE_PATTERNS: Final = (
    *("report.html", "report.pdf", "explore.html", "explore-records/*.js", "findings.json", "ro-crate-metadata.json"),
    *("fragility/*.xml", "fragility/curves.json", "survey/*.json"),
    *(f"figures/{name}.*" for name in ("axes", "rose", "plane", "earthquakes", "follow")),
    *(f"figures/{folder}/*.*" for folder in ("polar", "blocks", "intensity", "maps", "survey", "illustrative")),
)
"""Patterns of the files without checksum whose end is checked; files of the user are not among them."""
_FIGURE_SUFFIX_PATTERN: Final = rf"\.(?:{'|'.join(FIGURE_FILE_FORMATS)})"
_OPTIONAL_RESULT_FILE_PATTERN: Final = re.compile(
    r"convergence\.json|members\.csv|survey/\d+\.(?:json|motion\.nc)"
    r"|fragility/(?:fragility\.csv|curves\.json|fragility-(?:pga|pgv|sa-[\d.]+)\.xml)"
    rf"|figures/(?:plane|follow|earthquakes|blocks/[^/]+|survey/\d+){_FIGURE_SUFFIX_PATTERN}"
)
"""Names of the tables, curves and figures that only some studies have; simulations are not among them."""
_RECORD_FILE_PATTERNS: Final = (
    *("read/{}.nc", "read/*/{}.nc", "motion/{}.nc", "motion/*/{}.nc", "sweep/*/{}.*-of-*.nc"),
    *(f"figures/{kind}/{{}}.{end}" for kind in ("polar", "blocks", "intensity") for end in FIGURE_FILE_FORMATS),
    *("logs/read/{}.log", "logs/sweep/*/{}.*-of-*.log"),
    *("benchmarks/read/{}.tsv", "benchmarks/sweep/*/{}.*-of-*.tsv"),
)
"""Patterns of the files that a run writes for one record."""

OUTPUT_OPTIONS_OF_WORKFLOW_STEPS: Final = ("--output", "--results")
"""Options with which the steps of the workflow name the results that they write."""

_CLOCK_TOLERANCE_S: Final = 2.0  # s by which the clocks of a file system and of the processor may differ


def lock_results_folder_or_refuse(lock_file: Path) -> int | None:
    """Lock a results folder while this process lives, then wait for jobs of a killed run that still write to it.

    The operating system releases the lock when the process ends for any reason. Returns the file descriptor, which must
    stay open; None if the file system has no locks. A `ResultError` names the process of another run that holds the
    lock.
    """
    lock_file.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(lock_file, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        holder = os.read(descriptor, 20).decode(errors="replace") or "?"
        os.close(descriptor)
        raise ResultError(
            f"another run works in this folder (process {holder}); wait for it, or stop it and run again"
        ) from None
    except OSError:  # a file system without locks
        os.close(descriptor)
        return None
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, str(os.getpid()).encode(), 0)
    _wait_for_processes_of_killed_run(Path.cwd())
    return descriptor


def _wait_for_processes_of_killed_run(project_folder: Path) -> None:
    """Wait for processes of an earlier, killed run that still write to the results of this project."""
    import psutil

    for process in psutil.process_iter():
        with suppress(psutil.Error, OSError):
            words = process.cmdline()
            program = any(Path(word).name == "overturning" for word in words[:2])
            # A command that only reads results, such as `overturning survey --cube`, is no step of a run.
            writes = any(
                option in OUTPUT_OPTIONS_OF_WORKFLOW_STEPS and value.startswith("results/")
                for option, value in pairwise(words)
            )
            if program and writes and Path(process.cwd()) == project_folder:
                print(
                    f"A step of a killed run is still at work (process {process.pid}); waiting for it.", file=sys.stderr
                )
                process.wait()


def remove_damaged_results_and_fix_future_times(results_folder: Path) -> list[Path]:
    """Remove damaged and incomplete result files of a study, and each list of figures that names a missing figure.

    The next run makes them again if another result needs them. Returns the files that were damaged or missing. File
    times in the future (after the clock was set back) are set to just before now, in their order, so that files made
    from them are newer.
    """
    for left in results_folder.rglob(".*.part"):
        left.unlink(missing_ok=True)
    damaged = [
        path
        for path in sorted(results_folder.rglob("*.nc"))
        if path.name[0] != "." and not checksum_at_end_matches(path)
    ]
    for pattern, read in _TABLE_READERS_BY_FILE_NAME.items():
        for path in sorted(results_folder.glob(pattern)):
            try:
                read(path)
            except ResultError:
                damaged.append(path)
    for pattern in END_CHECKED_FILE_PATTERNS:
        damaged += [path for path in sorted(results_folder.glob(pattern)) if not _ends_like_complete_file(path)]
    for path in damaged:
        path.unlink(missing_ok=True)
    # Snakemake detects a missing output, but not a missing file in an output folder.
    for drawn in results_folder.glob("figures/*.txt"):
        names = drawn.read_text(encoding="utf-8", errors="replace").splitlines()
        if gone := [path for name in names if not (path := drawn.parent / name).is_file()]:
            drawn.unlink()
            damaged += gone
    now = time.time()
    times = {path: path.lstat().st_mtime for path in results_folder.rglob("*") if path.is_file()}
    ahead = sorted((path for path in times if times[path] > now + _CLOCK_TOLERANCE_S), key=lambda path: times[path])
    for rank, path in enumerate(ahead):
        moment = now - 1e-3 * (len(ahead) - rank)
        os.utime(path, (moment, moment))
    return damaged


def _ends_like_complete_file(path: Path) -> bool:
    """True if a file ends as complete files of its kind do; False if it was cut off, for instance by a full disk."""
    if (ends := FILE_END_BYTES_BY_SUFFIX.get(path.suffix)) is None or not path.is_file():
        return True
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 64))
        return file.read().rstrip().endswith(ends)


def remove_results_no_longer_made(results_folder: Path, relative_paths_of_produced_files: Collection[str]) -> list[str]:
    """Remove tables, curves and figures that a study does not make, because its settings have changed.

    Users would mistake these files for results of the present settings. Simulations and files with other names stay.

    Parameters
    ----------
    results_folder : Path
        Folder of the results of the study.
    relative_paths_of_produced_files : collection of str
        Files that the study makes, relative to this folder.

    Returns
    -------
    list of str
        Names of the removed files, relative to this folder.
    """
    names = [path.relative_to(results_folder).as_posix() for path in results_folder.rglob("*") if path.is_file()]
    gone = sorted(
        name
        for name in names
        if name not in relative_paths_of_produced_files and _OPTIONAL_RESULT_FILE_PATTERN.fullmatch(name)
    )
    for name in gone:
        (results_folder / name).unlink()
    return gone


def remove_files_of_dropped_records(results_folder: Path, record_ids: Collection[str]) -> dict[str, int]:
    """Remove motions and outcomes of records that a study no longer uses from its results folder.

    Files of a record are removed only if a run has written its motion or a part of its outcomes there: such files
    contain a checksum and the id of the record. All other files stay.

    Parameters
    ----------
    results_folder : Path
        Folder of the results of the study; files outside it are never removed, not even through links.
    record_ids : collection of str
        Ids of the records of the study.

    Returns
    -------
    dict
        Number of removed files, by record id.
    """
    gone = {
        name
        for name, path in _motion_and_outcome_files_of_records(results_folder)
        if name not in record_ids and _is_undamaged_file_of_record(path, name)
    }
    inside, removed = results_folder.resolve(), {}
    for name in sorted(gone):
        found = [path for pattern in _RECORD_FILE_PATTERNS for path in results_folder.glob(pattern.format(name))]
        ours = [path for path in found if path.is_file() and path.parent.resolve().is_relative_to(inside)]
        for path in ours:
            path.unlink()
        removed[name] = len(ours)
    return removed


def _motion_and_outcome_files_of_records(results_folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield record id and path of each file of a record's motion or outcomes in a results folder."""
    for pattern in ("read/*.nc", "motion/*.nc", "sweep/*/*.nc"):
        for path in results_folder.glob(pattern):
            yield path.name.partition(".")[0], path


def _is_undamaged_file_of_record(path: Path, record_id: str) -> bool:
    """True if a NetCDF file is undamaged (its checksum is correct) and belongs to the given record."""
    try:
        with open_netcdf_without_masking_and_scaling(path, "read", "remove it", require_checksum=True) as file:
            return bool(getattr(file, "record_id", "") == record_id)
    except ResultError:
        return False


def back_up_cubes(results_folder: Path) -> None:
    """Back up results cubes under other names, because Snakemake deletes output files before a job starts."""
    for path in results_folder.glob("cube*.nc"):
        kept = path.with_name(f".{path.name}.kept")
        kept.unlink(missing_ok=True)
        with suppress(OSError):  # a file system without hard links
            os.link(path, kept)


def restore_deleted_cubes_from_backups(results_folder: Path) -> None:
    """Restore deleted cubes from backups after an interrupted run; their file time 0 makes the next run remake them."""
    for kept in results_folder.glob(".cube*.nc.kept"):
        path = kept.with_name(kept.name.removeprefix(".").removesuffix(".kept"))
        if path.exists():
            kept.unlink()
        else:
            kept.rename(path)
            os.utime(path, (0, 0))
