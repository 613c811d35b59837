"""A job that reads a record imports only what it needs, since it is started for each record."""

import subprocess
import sys
from pathlib import Path

import pytest

TABLE = Path(__file__).parents[2] / "config" / "records.tsv"
HEAVY = {"xarray", "pandas", "scipy", "matplotlib", "numba", "dask", "snakemake"}
READ = f"""
from pathlib import Path
from overturning.records.catalogue import read_record_table
from overturning.records.processing import process_record
from overturning.records.read import read_record
from overturning.records.store import read_record_from_motion_file, write_record_to_motion_file
record = process_record(read_record(read_record_table({str(TABLE)!r})["rinaldi"], Path()), None)
"""
STORE = """
import tempfile
with tempfile.TemporaryDirectory() as folder:
    write_record_to_motion_file(record, Path(folder) / "motion.nc")
    read_record_from_motion_file(Path(folder) / "motion.nc")
"""


MODULES = "import sys\nprint(*sorted({m.split('.')[0] for m in sys.modules}))\n"


@pytest.fixture(scope="module")
def imported() -> list[set[str]]:
    """Packages that one process has imported: after a record is read, and after it was stored, too."""
    code = READ + MODULES + STORE + MODULES
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return [set(line.split()) for line in done.stdout.splitlines()]


@pytest.mark.parametrize(("after", "also"), [(0, {"obspy", "netCDF4"}), (1, {"obspy"})], ids=["read", "store"])
def test_reading_imports_nothing_heavy(imported, after, also):
    assert len(imported) == 2
    assert {"numpy", "overturning"} <= imported[after]
    assert not (HEAVY | also) & imported[after]
