"""The jobs of `make verify`."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.long
def test_the_verification_workflow_plans_every_part(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "verification" / "Snakefile"), "--dry-run"]
    for name in ("verification", "src", "config", "surveys"):
        (tmp_path / name).symlink_to(ROOT / name)
    done = subprocess.run([*command, "--cores", "1"], cwd=tmp_path, check=True, capture_output=True, text=True)
    for name in ("rocking", "sliding", "stiffness", "rigid", "energy", "peers", "stability", "scenes", "stacks"):
        assert f"results/verification/{name}.nc" in done.stdout + done.stderr
