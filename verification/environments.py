"""Time, size and packages of the environments that `make setup` and `make setup-dev` install.

``python -m verification.environments`` measures this checkout; with ``--before COMMIT``, it also measures the
environment of an earlier commit in turn. Packages are downloaded again each time (no cache of pip is used).
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Annotated, Final, NamedTuple

import typer

from verification.tables import (
    RESULT_TABLE_FOLDER,
    ROOT,
    MeasuredNumber,
    measured_numbers_table,
    update_marked_tables_and_sentences_in_docs,
    write_measured_numbers,
)

MEASUREMENTS_PER_ENVIRONMENT: Final = 2
"""Number of measurements of each environment; the fastest one is reported."""


class EnvironmentInstallationCost(NamedTuple):
    """Cost of installing a Python environment: times, disk size and number of packages.

    Costs are compared by elapsed time.
    """

    elapsed_time_s: float
    """Elapsed time, s."""
    processor_time_s: float
    """Processor time, s."""
    disk_size_gb: float
    """Size on the disk, GB (10⁹ bytes)."""
    installed_package_count: int
    """Number of installed packages, pip and this one included."""


def install_and_measure_environment(
    checkout_folder: Path, make_target: str, environment_folder: Path
) -> EnvironmentInstallationCost:
    """Run a make target that installs packages; return its cost.

    The cost has the elapsed and processor time, s, of the target, and size and package count of the environment.
    """
    # The environment of this process must not be found by pip or make.
    variables = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(
        [
            "make",
            "--silent",
            f"VENV={environment_folder}",
            f"PYTHON={Path(sys.base_prefix, 'bin', 'python3')}",
            make_target,
        ],
        cwd=checkout_folder,
        env=variables | {"PIP_NO_CACHE_DIR": "1"},
        check=True,
    )
    elapsed, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = (after.ru_utime - before.ru_utime) + (after.ru_stime - before.ru_stime)
    blocks = sum(path.lstat().st_blocks for path in environment_folder.rglob("*"))
    return EnvironmentInstallationCost(elapsed, spent, 512 * blocks / 1e9, count_installed_packages(environment_folder))


def count_installed_packages(environment_folder: Path) -> int:
    """Return the number of installed packages; copies inside another package (setuptools has some) do not count."""
    return len(list(environment_folder.glob("lib/*/site-packages/*.dist-info")))


def measure_new_environment_after_make_targets(
    checkout_folder: Path, make_targets: list[str]
) -> list[EnvironmentInstallationCost]:
    """Run make targets one after the other in a new Python environment, and return the cost after each."""
    with tempfile.TemporaryDirectory() as scratch:
        return [
            install_and_measure_environment(checkout_folder, target, Path(scratch, "environment"))
            for target in make_targets
        ]


def environment_cost_numbers(environment_name: str, cost: EnvironmentInstallationCost) -> list[MeasuredNumber]:
    """Return the cost of an environment as measured numbers."""
    return [
        MeasuredNumber(f"{environment_name}: time", cost.elapsed_time_s, "s"),
        MeasuredNumber(f"{environment_name}: processor time", cost.processor_time_s, "s"),
        MeasuredNumber(f"{environment_name}: size", cost.disk_size_gb, "GB"),
        MeasuredNumber(f"{environment_name}: packages", cost.installed_package_count),
    ]


def main(
    before: Annotated[str, typer.Option(help="earlier commit, whose `make setup` is measured, too")] = "",
) -> None:
    """Measure the environments and write their figures into the docs."""
    runs, tests, earlier = [], [], []
    with tempfile.TemporaryDirectory() as scratch:
        old = Path(scratch, "old")
        if before:
            subprocess.run(["git", "clone", "--quiet", "--no-checkout", str(ROOT), str(old)], check=True)
            subprocess.run(["git", "checkout", "--quiet", before], cwd=old, check=True)
        for _ in range(MEASUREMENTS_PER_ENVIRONMENT):  # in turn, so that other load on the machine affects both alike
            if before:
                earlier += measure_new_environment_after_make_targets(old, ["setup"])
            run, test = measure_new_environment_after_make_targets(ROOT, ["setup", "setup-dev"])
            runs.append(run)
            tests.append(test)
    figures = [
        *environment_cost_numbers("`make setup`", min(runs)),
        *environment_cost_numbers("then `make setup-dev`", min(tests)),
    ]
    if before:
        figures += environment_cost_numbers(f"`make setup` at {before}, one lock for all", min(earlier))
    written = write_measured_numbers(figures, RESULT_TABLE_FOLDER / "environments.csv", keep_other_stored_numbers=True)
    update_marked_tables_and_sentences_in_docs({"environments": measured_numbers_table(written)})


if __name__ == "__main__":
    typer.run(main)
