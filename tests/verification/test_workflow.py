"""The jobs of `make verify`, and which sources make them run again."""

import subprocess
import sys
from pathlib import Path

import pytest

from overturning.study import sources

ROOT = Path(__file__).parents[2]


@pytest.mark.long
def test_every_part_is_planned(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "verification" / "Snakefile"), "--dry-run"]
    (tmp_path / "verification").symlink_to(ROOT / "verification")
    done = subprocess.run([*command, "--cores", "1"], cwd=tmp_path, check=True, capture_output=True, text=True)
    for name in ("rocking", "sliding", "stiffness", "rigid", "energy", "peers", "stability", "scenes"):
        assert f"results/verification/{name}.nc" in done.stdout + done.stderr


def test_a_job_depends_on_its_own_sources_and_on_the_packages() -> None:
    found = {str(path.relative_to(ROOT)) for path in sources.sources_of("verification.page", ROOT / "verification")}
    assert {"verification/tables.py", "verification/stability/figures.py", "src/overturning/model/cases.py"} <= found
    assert "verification/bench.py" not in found
    hashes = {
        sources.source_hash(f"verification.{name}", ROOT / "verification")
        for name in ("page", "stability.__main__", "work_precision.__main__")
    }
    assert len(hashes) == 3
