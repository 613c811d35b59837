"""A job that reads a record imports only what it needs, since it is started for each record."""

import subprocess
import sys
from pathlib import Path

import pytest

DEFAULT_RECORD_TABLE_PATH = Path(__file__).parents[2] / "config" / "records.tsv"
HEAVY_PACKAGES = {"xarray", "pandas", "scipy", "matplotlib", "numba", "dask", "snakemake"}
READING_CODE = f"""
from pathlib import Path
from overturning.records.catalogue import read_record_table
from overturning.records.processing import process_record
from overturning.records.read import read_record
from overturning.records.store import read_record_from_motion_file, write_record_to_motion_file
record = process_record(read_record(read_record_table({str(DEFAULT_RECORD_TABLE_PATH)!r})["rinaldi"], Path()), None)
"""
MOTION_FILE_ROUND_TRIP_CODE = """
import tempfile
with tempfile.TemporaryDirectory() as folder:
    write_record_to_motion_file(record, Path(folder) / "motion.nc")
    read_record_from_motion_file(Path(folder) / "motion.nc")
"""


CODE_PRINTING_IMPORTED_PACKAGES = "import sys\nprint(*sorted({m.split('.')[0] for m in sys.modules}))\n"


@pytest.fixture(scope="module")
def packages_imported_by_reading_and_storing() -> list[set[str]]:
    """Return two sets: packages imported by a new process after reading a record, and after storing it."""
    code = (
        READING_CODE + CODE_PRINTING_IMPORTED_PACKAGES + MOTION_FILE_ROUND_TRIP_CODE + CODE_PRINTING_IMPORTED_PACKAGES
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return [set(line.split()) for line in done.stdout.splitlines()]


@pytest.mark.parametrize(("after", "also"), [(0, {"obspy", "netCDF4"}), (1, {"obspy"})], ids=["read", "store"])
def test_reading_or_storing_a_record_imports_no_heavy_package(packages_imported_by_reading_and_storing, after, also):
    assert len(packages_imported_by_reading_and_storing) == 2
    assert {"numpy", "overturning"} <= packages_imported_by_reading_and_storing[after]
    assert not (HEAVY_PACKAGES | also) & packages_imported_by_reading_and_storing[after]
