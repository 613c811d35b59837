"""Modules that each step imports in a process of its own: imports take longer than the work of a short step."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.workflow.conftest import SMALL, Checkout

pytestmark = pytest.mark.workflow

HEAVY = {
    *("matplotlib", "obspy", "xarray", "pandas", "dask", "distributed", "numba", "typst", "jinja2"),
    *("scipy.interpolate", "scipy.optimize", "scipy.signal", "scipy.sparse", "scipy.spatial", "scipy.stats"),
}
"""Modules whose import takes 0.1 s or more."""

STATISTICS = {"scipy.interpolate", "scipy.optimize", "scipy.sparse", "scipy.spatial", "scipy.stats"}
TABLES = {"xarray", "pandas", "dask", "jinja2"}
NEEDED = {
    "read": set(),
    "members": STATISTICS,
    "sweep": {"numba"},
    "describe": set(),
    "gather": set(),
    "check-convergence": {"numba"},
    "rotate": TABLES | STATISTICS | {"scipy.signal", "distributed"},
    "fragility": TABLES | STATISTICS,
    "findings": TABLES | STATISTICS,
}
"""Heavy modules that a step may import; steps that draw or write pages are left out."""

PROGRAM = f"""
import atexit, json, sys
atexit.register(lambda: print(json.dumps([name for name in {sorted(HEAVY)} if name in sys.modules])))
from overturning.cli import main
main()
"""


def test_steps_import_only_what_they_need(tmp_path: Path) -> None:
    study = SMALL.replace("rinaldi, petrolia", "rinaldi").replace("step: 30, also: [32]", "step: 90")
    checkout = Checkout(tmp_path / "imports", f"{study}population: {{}}\n")
    imported = {}
    for command in checkout.plan().commands:
        _, *words = shlex.split(re.sub(r" 2?> .*", "", command))
        if words[0] not in NEEDED:
            continue
        for word in words:
            if word.startswith("results/"):
                (checkout.folder / word).parent.mkdir(parents=True, exist_ok=True)
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM, *words], cwd=checkout.folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        imported[words[0]] = set(json.loads(done.stdout.splitlines()[-1]))
    assert imported.keys() == NEEDED.keys()
    assert {name: found - NEEDED[name] for name, found in imported.items() if found - NEEDED[name]} == {}
