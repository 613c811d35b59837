"""Modules that each step imports: imports take longer than the work of a short step."""

import json
import os
import re
import shlex
import subprocess
import sys
from itertools import chain
from pathlib import Path

import pytest

from tests.workflow.conftest import SMALL_STUDY, StudyWorkflowCopyWithPlanning

pytestmark = pytest.mark.workflow

HEAVY_PACKAGES = {
    *("matplotlib", "obspy", "xarray", "pandas", "dask", "distributed", "numba", "typst", "jinja2"),
    *("scipy.interpolate", "scipy.optimize", "scipy.signal", "scipy.sparse", "scipy.spatial", "scipy.stats"),
}
"""Modules whose import takes 0.1 s or more."""

SLOW_SCIPY_PACKAGES = {"scipy.interpolate", "scipy.optimize", "scipy.sparse", "scipy.spatial", "scipy.stats"}
TABLE_PACKAGES = {"xarray", "pandas", "dask", "jinja2"}
ALLOWED_HEAVY_PACKAGES_BY_STEP = {
    "read": set(),
    "members": SLOW_SCIPY_PACKAGES,
    "sweep": {"numba"},
    "describe": set(),
    "gather": set(),
    "check-convergence": {"numba"},
    "rotate": TABLE_PACKAGES | SLOW_SCIPY_PACKAGES | {"distributed", "numba"},
    "fragility": TABLE_PACKAGES | SLOW_SCIPY_PACKAGES,
    "findings": TABLE_PACKAGES | SLOW_SCIPY_PACKAGES,
}
"""Heavy modules that a step may import; steps that draw or write pages are left out."""

WORKFLOW_STEPS_IN_ORDER = (
    "read",
    "describe",
    "members",
    "sweep",
    "gather",
    "check-convergence",
    "rotate",
    "fragility",
    "findings",
)
"""The steps in an order in which each has its inputs, and all that need tables and statistics are the last."""

PROGRAM_RUNNING_STEPS_IN_FORKS = f"""
import json, os, sys
from importlib import import_module
import netCDF4, overturning.records.store, overturning.study.load  # of all steps
from overturning.commands.application import run_command_line

def run(words):
    step = os.fork()
    if step:
        assert os.waitpid(step, 0)[1] == 0, words[0]
        return
    try:
        run_command_line(words)
        failed = False
    except SystemExit as end:
        failed = bool(end.code)
    print(json.dumps([words[0], [name for name in {sorted(HEAVY_PACKAGES)} if name in sys.modules]]), flush=True)
    os._exit(failed)

commands = json.load(sys.stdin)
for words in commands:
    if words[0] == "rotate":
        for name in {sorted(TABLE_PACKAGES | SLOW_SCIPY_PACKAGES)}:
            import_module(name)
    run(words)
"""
"""Steps in copies (forks) of one process, which has imported what all of them or all that are left may import."""


def test_each_workflow_step_imports_only_the_heavy_packages_that_it_needs(tmp_path: Path) -> None:
    study = SMALL_STUDY.replace("rinaldi, petrolia", "rinaldi").replace("step: 30, also: [32]", "step: 90")
    checkout = StudyWorkflowCopyWithPlanning(tmp_path / "imports", study)
    planned = [shlex.split(re.sub(r" 2?> .*", "", command))[1:] for command in checkout.plan().commands]
    commands = sorted(
        (words for words in planned if words[0] in ALLOWED_HEAVY_PACKAGES_BY_STEP),
        key=lambda words: WORKFLOW_STEPS_IN_ORDER.index(words[0]),
    )
    for word in chain.from_iterable(commands):
        if word.startswith("results/"):
            (checkout.folder / word).parent.mkdir(parents=True, exist_ok=True)
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM_RUNNING_STEPS_IN_FORKS],
        cwd=checkout.folder,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        input=json.dumps(commands),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    answers = [json.loads(line) for line in done.stdout.splitlines() if line.startswith('["')]
    imported = {name: set(found) for name, found in answers}
    assert imported.keys() == ALLOWED_HEAVY_PACKAGES_BY_STEP.keys()
    assert {
        name: found - ALLOWED_HEAVY_PACKAGES_BY_STEP[name]
        for name, found in imported.items()
        if found - ALLOWED_HEAVY_PACKAGES_BY_STEP[name]
    } == {}
