"""What large studies take, each in a process of its own: a chunk of a sweep, gathering, statistics and figures."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Final, NamedTuple

from overturning.study.ensemble import draw_members
from verification.scale.made import made_study, write_made_cube, write_made_motions, write_made_parts, write_study
from verification.tables import Figure

SNAKEMAKE_MB: Final = 250.0
"""Set aside for Snakemake, which runs beside the jobs."""


class Taken(NamedTuple):
    """What a process took."""

    seconds: float
    processor_s: float
    memory_mb: float  # largest resident set
    longest: int = 0  # bytes of the longest line that it printed of those asked for


def taken(*command: object) -> Taken:
    """Run a subcommand of the package to its end."""
    return taken_by([sys.executable, "-m", "overturning.cli", *map(str, command)])


def taken_by(args: list[str], begins: bytes = b"", **where: Any) -> Taken:
    """Run a program to its end, and measure the lines that begin so; a RuntimeError where it fails."""
    begin = time.perf_counter()
    process = subprocess.Popen(args, stdout=subprocess.PIPE, **where)
    assert process.stdout
    longest = max((len(line) for line in process.stdout if begins and line.startswith(begins)), default=0)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{args[-1]} failed")
    return Taken(time.perf_counter() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, longest)


def measure_chunk(folder: Path, chunks: int = 8) -> list[Figure]:
    """A real chunk of a real record: an eighth of a million cases with their ensemble, on one core."""
    study = made_study(1)
    write_study(study, folder / "study.json")
    own = study.model_copy(update={"records": study.records.model_copy(update={"use": ("rinaldi",)})})
    write_study(own, folder / "own.json")
    taken("read", "--study", folder / "own.json", "--record", "rinaldi", "--output", folder / "motion.nc")
    draw_members(study.ensemble).write(folder / "members.csv")
    part = folder / f"rinaldi.1-of-{chunks}.nc"
    took = taken(
        "sweep", "--study", folder / "study.json", "--motion", folder / "motion.nc", "--output", part,
        "--members", folder / "members.csv", "--chunk", f"1-of-{chunks}",
    )  # fmt: skip
    cases = study.cases / chunks
    return [
        Figure("real chunk: cases", cases),
        Figure("real chunk: processor time", took.processor_s, "s"),
        Figure("real chunk: peak memory of its process", took.memory_mb, "MB"),
        Figure("two such processes and Snakemake", 2 * took.memory_mb + SNAKEMAKE_MB, "MB"),
        Figure("real chunk: disk per case", part.stat().st_size / cases, "bytes"),
    ]


def measure_gather(
    folder: Path, records: int = 10, chunks: int = 8, grid: dict[str, object] | None = None
) -> list[Figure]:
    """Gathering of made parts, ten million cases of them."""
    study = made_study(records, grid)
    write_study(study, folder / "study.json")
    write_made_motions(study, folder / "motion")
    parts = write_made_parts(study, folder / "sweep", chunks)
    took = taken(
        "gather", "--study", folder / "study.json", "--motions", folder / "motion", "--parts", folder / "sweep",
        "--chunks", chunks, "--output", folder / "cube.nc",
    )  # fmt: skip
    cases = records * study.cases
    of_parts, of_cube = sum(part.stat().st_size for part in parts), (folder / "cube.nc").stat().st_size
    return [
        Figure("made parts: cases", cases),
        Figure("made parts: gathering", took.seconds, "s"),
        Figure("made parts: peak memory of gathering", took.memory_mb, "MB"),
        Figure("made parts and their cube: disk per case", (of_parts + of_cube) / cases, "bytes"),
        Figure("made cube alone: disk per case", of_cube / cases, "bytes"),
    ]


def measure_lazily(
    folder: Path, records: int = 100, grid: dict[str, object] | None = None, cube: str = "made cube"
) -> list[Figure]:
    """All statistics, figures and the report of a made cube larger than memory; in the figures it has that name."""
    study = made_study(records, grid)
    write_study(study, folder / "study.json")
    write_made_motions(study, folder / "motion")
    write_made_cube(study, folder / "cube.nc", different=min(2, records))
    draw_members(study.ensemble).write(folder / "members.csv")
    base = ("--study", folder / "study.json", "--motions", folder / "motion")
    size = (folder / "cube.nc").stat().st_size
    found = [Figure(f"{cube}: cells", records * study.cases), Figure(f"{cube}: size", size / 1e9, "GB")]

    def note(what: str, took: Taken) -> None:
        found.append(Figure(f"{cube}: {what}, time", took.seconds, "s"))
        found.append(Figure(f"{cube}: {what}, peak memory", took.memory_mb, "MB"))

    note("intensities", taken("rotate", *base, "--output", folder / "intensity.nc"))
    for what, call in (
        (
            "figures of a record",
            "record import draw_record_figures; draw_record_figures(cube, intensity, motions, figures, write, [0])",
        ),
        (
            "figures of all records together",
            "study import draw_study_figures; draw_study_figures(cube, intensity, figures, write)",
        ),
    ):
        program = f"""
from functools import partial
from pathlib import Path
from overturning.figures.write import write_figure
from overturning.study.load import study_from
folder = Path({str(folder)!r})
cube, intensity, motions, figures = (folder / name for name in ("cube.nc", "intensity.nc", "motion", "figures"))
write = partial(write_figure, study_from(str(folder / "study.json")).figures)
from overturning.figures.{call}
"""
        note(what, taken_by([sys.executable, "-c", program]))
    drawn_cases = folder / "figures" / "illustrative"
    note("illustrative cases", taken("illustrative", "--cube", folder / "cube.nc", *base[2:], "--output", drawn_cases))
    # The report shows figures of each record.
    for drawn in list((folder / "figures").glob(f"*/{study.records.use[0]}.*")):
        for name in study.records.use[1:]:
            shutil.copy(drawn, drawn.with_name(f"{name}{drawn.suffix}"))
    note("report", taken("report", "--results", folder, "--output", folder / "report.html"))
    return found
