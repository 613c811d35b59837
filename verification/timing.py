"""Processor time of computations, as the minimum of several runs: in this process, a new one, or another checkout."""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple, TypeVar

import numpy as np

from overturning.model.results import CaseResults
from overturning.model.variables import PLANAR_OUTCOME_VARIABLES
from verification.inputs import CaseGroup
from verification.tables import ROOT

Result = TypeVar("Result")

TOTAL_PROCESSOR_TIME_TO_STOP_REPEATS_S: Final = 4.0
"""Total processor time, s, after which a computation is not repeated; disturbances matter little in long runs."""


class ResultsWithProcessorTime(NamedTuple):
    """Results of a sequence of case groups, joined in order, and their processor time, s."""

    results: CaseResults
    processor_time_s: float


def run_and_measure_min_processor_time(
    computation: Callable[[], Result], repetition_count: int = 3, warm_up: Callable[[], object] | None = None
) -> tuple[Result, float]:
    """Run a computation several times; return its result and minimum processor time, s.

    The times of all threads are added. `warm_up` (default: the computation itself) runs first, to compile.
    """
    (warm_up or computation)()
    times: list[float] = []
    while len(times) < repetition_count and sum(times) < TOTAL_PROCESSOR_TIME_TO_STOP_REPEATS_S:
        begin = time.process_time()
        result = computation()
        times.append(time.process_time() - begin)
    return result, min(times)


def minimum_processor_time(computation: Callable[[], object], repetition_count: int = 3) -> float:
    """Return the minimum processor time of several runs of a computation after a warm-up, s, all threads added."""
    return run_and_measure_min_processor_time(computation, repetition_count)[1]


def run_python_program_and_measure_cpu_time(
    python_code: str, *arguments: object, **environment: str
) -> tuple[str, float]:
    """Run a Python program; return its output and the processor time of its process, s."""
    begin = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-c", python_code, *map(str, arguments)]
    done = subprocess.run(
        command, env=os.environ | environment, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True
    )
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.stdout, (end.ru_utime + end.ru_stime) - (begin.ru_utime + begin.ru_stime)


_RESULT_NAMES_READ_FROM_CHILD: Final = (
    *(item.name for item in PLANAR_OUTCOME_VARIABLES if item.name != "mirrored"),
    "block_steps",
)

_CHILD_PROGRAM: Final = """
import json, sys, time
from pathlib import Path
import numpy as np
given, asked = np.load(sys.argv[1]), json.loads(sys.argv[3])
exec(asked["before"])
from overturning import Cases, Motion, run_cases as run
if asked["scene"]:
    from overturning.dem.numerics import NumericalOptions
    from overturning.dem.run import simulate_cases as run_scene
    from overturning import load_scene
    scene = load_scene(asked["scene"], Path(asked["root"]))
    def run(motion, cases, **settings):
        return run_scene(scene, motion, cases, NumericalOptions(**settings))
groups = [
    (Motion(*given[f"motion{i}"], sampling_interval=float(given[f"interval{i}"])), Cases(*given[f"cases{i}"]))
    for i in range(asked["groups"])
]
made = {}
for i, settings in enumerate(asked["settings"]):
    run(*groups[0], **settings)
    times = []
    for _ in range(asked["repeats"]):
        begin = time.process_time()
        found = [run(*group, **settings) for group in groups]
        times.append(time.process_time() - begin)
    made[f"seconds{i}"] = min(times)
    made |= {f"{name}{i}": np.concatenate([getattr(one, name) for one in found]) for name in vars(found[0])}
np.savez(sys.argv[2], **made)
"""
"""Program of the child process. It uses only names that all checkouts have."""


def run_case_groups_in_subprocess(
    groups: Sequence[CaseGroup],
    run_cases_arguments_by_setting: Sequence[dict[str, Any]],
    *,
    checkout_folder: Path = ROOT,
    statements_before_import: str = "",
    scene_name: str = "",
    repetition_count: int = 1,
    **environment: str,
) -> list[ResultsWithProcessorTime]:
    """Run groups of cases in a separate process; return results and processor time for each of several settings.

    Parameters
    ----------
    groups : sequence of CaseGroup
        Cases by motion; their amplitudes are not used.
    run_cases_arguments_by_setting : sequence of dict
        Arguments of `run_cases`, or of `NumericalOptions` for a scene.
    checkout_folder : Path
        Folder whose ``src`` is used.
    statements_before_import : str
        Statements to execute before the kernel is imported.
    scene_name : str
        Name of a shipped scene; empty: a single block.
    repetition_count : int
        Number of timed runs; the minimum counts.
    **environment : str
        Environment variables of the process.
    """
    inputs: dict[str, Any] = {}
    for i, (motion, cases) in enumerate(groups):
        inputs |= {
            f"cases{i}": np.stack([cases.azimuth_deg, cases.height, cases.b_over_h, cases.friction]),
            f"motion{i}": np.stack([motion.north, motion.east]),
            f"interval{i}": np.array(motion.sampling_interval),
        }
    asked = {
        "before": statements_before_import,
        "scene": scene_name,
        "root": str(ROOT),
        "groups": len(groups),
        "repeats": repetition_count,
    }
    with tempfile.TemporaryDirectory() as scratch:
        given, made = f"{scratch}/inputs.npz", f"{scratch}/found.npz"
        np.savez(given, allow_pickle=False, **inputs)
        source = str((checkout_folder / "src").resolve())
        run_python_program_and_measure_cpu_time(
            _CHILD_PROGRAM,
            given,
            made,
            json.dumps(asked | {"settings": list(run_cases_arguments_by_setting)}),
            PYTHONPATH=source,
            **environment,
        )
        with np.load(made) as arrays:
            return [
                ResultsWithProcessorTime(
                    CaseResults(**{name: arrays[f"{name}{i}"] for name in _RESULT_NAMES_READ_FROM_CHILD}),
                    float(arrays[f"seconds{i}"]),
                )
                for i in range(len(run_cases_arguments_by_setting))
            ]
