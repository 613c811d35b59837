"""Output of measurements: NetCDF and CSV files, Markdown tables, and their markers in the docs."""

import fcntl
import os
import platform
import re
import subprocess
import textwrap
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final, NamedTuple

import pandas as pd
import typer
from llvmlite.binding import get_host_cpu_features

from overturning.errors import ResultError
from overturning.files import atomic_write
from verification.sentences import fill_measured_numbers_into_page

ROOT: Final = Path(__file__).parents[1]
RESULT_TABLE_FOLDER: Final = ROOT / "verification" / "results"
"""Folder of the tables in the repository; the docs link to them."""


class MeasuredNumber(NamedTuple):
    """Measured number with its quantity, unit and the commit at which it was measured."""

    quantity: str
    value: float
    unit: str = ""
    commit: str = ""
    """Commit at which the figure was measured; empty for the current one."""


def markdown_table(column_headers: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table of a header and rows."""
    lines = [column_headers, ["---"] * len(column_headers), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def measured_numbers_table(numbers: Iterable[MeasuredNumber]) -> str:
    """Return measured numbers as a Markdown table, with a column of commits unless all are of the current one."""
    rows, now = list(numbers), current_commit()
    if all(one.commit in ("", now) for one in rows):
        return markdown_table(("", "measured"), [(one.quantity, text_of_value_and_unit(one)) for one in rows])
    return markdown_table(
        ("", "measured", "commit"),
        [(one.quantity, text_of_value_and_unit(one), one.commit or now) for one in rows],
    )


@cache
def current_commit() -> str:
    """Return the short hash of the current commit, with "+" where tracked sources differ from it."""

    def git_output(*words: str) -> str:
        """Return the output of a git command."""
        return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()

    changed = git_output("status", "--porcelain", "--untracked-files=no", "--", "src", "verification/*.py", "config")
    return (git_output("rev-parse", "--short=8", "HEAD") or "unknown") + ("+" if changed else "")


VECTOR_BITS_BY_PROCESSOR_FEATURE: Final = {"avx512f": 512, "avx2": 256}
"""Width of a processor's vectors, bits, by the feature that provides them; the widest first."""


@cache
def processor_and_software_versions_line() -> str:
    """Return a line with the processor and the software versions on which measured figures depend."""
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    names = (line.partition(": ")[2] for line in lines if line.startswith("model name"))
    vectors = next(
        (bits for name, bits in VECTOR_BITS_BY_PROCESSOR_FEATURE.items() if get_host_cpu_features().get(name)), 128
    )
    model = f"{next(names, platform.machine())}, {len(os.sched_getaffinity(0))} cores, {vectors}-bit vectors"
    return f"{model}; Python {platform.python_version()}, " + ", ".join(
        f"{name} {version(name.lower())}" for name in ("Numba", "NumPy")
    )


def commit_and_machine_line() -> str:
    """Return the line below a table: the commit and the machine that it was measured with."""
    return f"*Commit {current_commit()}; {processor_and_software_versions_line()}.*"


def wrap_text(text: str, first_line_prefix: str = "") -> str:
    """Wrap text to the lines of a page; the first begins with `first_line_prefix`, such as the bullet of a list."""
    return textwrap.fill(
        text,
        118,
        initial_indent=first_line_prefix,
        subsequent_indent=" " * len(first_line_prefix),
        break_on_hyphens=False,
    )


def text_of_value_and_unit(measured_number: MeasuredNumber) -> str:
    """Return value and unit of a measured number as text, with four digits."""
    number = f"{measured_number.value:.4g}" if abs(measured_number.value) < 1e4 else f"{measured_number.value:,.0f}"
    return f"{number} {measured_number.unit}".strip()


def write_measured_numbers(
    new_numbers: Sequence[MeasuredNumber], path: Path, keep_other_stored_numbers: bool = False
) -> list[MeasuredNumber]:
    """Write measured numbers as CSV and return all numbers that the file has then.

    Parameters
    ----------
    new_numbers : sequence of MeasuredNumber
        Numbers that were just measured.
    path : Path
        CSV file.
    keep_other_stored_numbers : bool
        True to keep numbers of the file that were not measured again; False to remove them.
    """
    new = {one.quantity: one._replace(commit=current_commit()) for one in new_numbers}
    if keep_other_stored_numbers and path.is_file():
        new = {one.quantity: one for one in read_measured_numbers(path)} | new
    with atomic_write(path) as part:
        pd.DataFrame(list(new.values())).to_csv(part, index=False, float_format="%.6g", lineterminator="\n")
    return list(new.values())


def read_measured_numbers(path: Path) -> list[MeasuredNumber]:
    """Read a CSV file of measured numbers, as written by `write_measured_numbers`."""
    texts = dict.fromkeys(("quantity", "unit", "commit"), str)  # a commit such as 15163e45 is no number
    rows = pd.read_csv(path, keep_default_na=False, dtype=texts)
    return [
        MeasuredNumber(str(row.quantity), float(row.value), str(row.unit), str(getattr(row, "commit", "")))
        for row in iterate_rows(rows)
    ]


@contextmanager
def lock_folder_for_changes(folder: Path) -> Iterator[None]:
    """Lock a folder, so that no other process that uses this function changes its files."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def named_parts_or_all_if_none(named_parts: Sequence[str] | None, known_parts: Collection[str]) -> list[str]:
    """Return the parts named on the command line, in the order of `known_parts`; all if none is named."""
    if unknown := set(named_parts or ()) - set(known_parts):
        raise typer.BadParameter(f"{', '.join(sorted(unknown))}; known: {', '.join(known_parts)}")
    return [name for name in known_parts if not named_parts or name in named_parts]


def update_marked_tables_and_sentences_in_docs(
    markdown_by_marker: Mapping[str, str], readme_and_docs_folder: Path = ROOT
) -> None:
    """Write each Markdown text between its markers ``<!-- mark:begin -->`` and ``<!-- mark:end -->`` in the docs.

    A line below each text names the commit and the machine (see `commit_and_machine_line`). Figures within sentences
    are updated, too (see `verification.sentences`).

    Parameters
    ----------
    markdown_by_marker : mapping of str to str
        Markdown text by marker (``mark`` above).
    readme_and_docs_folder : Path
        Folder of README*.md and docs/*.md.

    Raises
    ------
    ResultError
        If no page has one of the markers; the other texts are written anyway.
    """
    missing = set(markdown_by_marker)
    with lock_folder_for_changes(readme_and_docs_folder):
        for page in (
            *sorted(readme_and_docs_folder.glob("README*.md")),
            *sorted((readme_and_docs_folder / "docs").glob("*.md")),
        ):
            if page.is_file():
                old = text = page.read_text(encoding="utf-8")
                for mark, body in markdown_by_marker.items():
                    begin, end = f"<!-- {mark}:begin -->", f"<!-- {mark}:end -->"
                    if begin in text and end in text:
                        missing.discard(mark)
                        new = f"{begin}\n\n{body}\n\n{commit_and_machine_line()}\n\n{end}".replace(
                            "\\", r"\\"
                        )  # keep backslashes literal in the replacement
                        text = re.sub(f"{begin}.*?{end}", new, text, flags=re.DOTALL)
                text = fill_measured_numbers_into_page(
                    text, readme_and_docs_folder / RESULT_TABLE_FOLDER.relative_to(ROOT)
                )
                if text != old:
                    with atomic_write(page) as part:
                        part.write_text(text, encoding="utf-8")
    if missing:
        names = ", ".join(f"<!-- {mark}:begin --> and <!-- {mark}:end -->" for mark in sorted(missing))
        raise ResultError(f"no page of docs/ nor README.md has {names}; add these markers to a page")


def write_table_as_netcdf_and_csv(
    rows: pd.DataFrame,
    path: Path,
    *,
    long_name_and_unit_by_column: Mapping[str, tuple[str, str]],
    global_attributes: Mapping[str, Any] | None = None,
    dimension_name: str = "row",
) -> None:
    """Write a table as NetCDF and CSV; the same numbers give the same bytes.

    Parameters
    ----------
    rows : DataFrame
        Columns of numbers and strings.
    path : Path
        NetCDF file; the CSV file has the same name with the extension .csv.
    long_name_and_unit_by_column : mapping of str to (str, str)
        Long name and unit of each column.
    global_attributes : mapping, optional
        Numbers to store as global attributes.
    dimension_name : str
        Name of the dimension.
    """
    table = rows.rename_axis(dimension_name).to_xarray().drop_vars(dimension_name).assign_attrs(global_attributes or {})
    encoding: dict[str, dict[str, Any]] = {}
    for name, column in table.data_vars.items():
        long_name, unit = long_name_and_unit_by_column[str(name)]
        number = column.dtype.kind in "iufb"
        column.attrs = {"long_name": long_name} | ({"units": unit} if number else {})
        encoding[str(name)] = {"zlib": True, "complevel": 1, "shuffle": True, "_FillValue": None} if number else {}
        if not number:
            table[name] = column.astype(object)
    with atomic_write(path) as part:
        table.to_netcdf(part, engine="netcdf4", encoding=encoding)
    write_csv(rows, path.with_suffix(".csv"))


def iterate_rows(table: pd.DataFrame) -> Iterator[Any]:
    """Yield the rows of a table, with the columns as attributes."""
    yield from table.itertuples(index=False)


def write_csv(rows: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV with six digits per number."""
    with atomic_write(path) as part:
        rows.to_csv(part, index=False, float_format="%.6g", na_rep="nan", lineterminator="\n")


def read_table(path: Path) -> pd.DataFrame:
    """Read a table from a NetCDF file of `write_table_as_netcdf_and_csv`; its attributes become those of the frame.

    Raises
    ------
    ResultError
        If the file is missing or not such a table.
    """
    import xarray as xr

    try:
        with xr.open_dataset(path, engine="netcdf4", decode_times=False) as table:  # a column in s is a number
            rows = table.to_dataframe()
            rows.attrs = dict(table.attrs)
    except (OSError, ValueError) as error:
        raise ResultError(f"{path}: cannot be read ({error}); run `make verify`") from None
    return rows


if __name__ == "__main__":
    update_marked_tables_and_sentences_in_docs({})
