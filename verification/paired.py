"""`python -m verification.paired FOLDER`: compare the speed of two checkouts, in alternating processes.

Use it for a change that must not reduce speed: FOLDER is a checkout of the state before it. The processor times are
those of sweeps of three default records, for each scheme. The speed of a machine drifts, so only the ratios within a
pair of runs are meaningful. With `--whole-run`, complete runs of the default study are compared, too, and
docs/measurements.md gets the table.
"""

from pathlib import Path
from statistics import median
from typing import Annotated

import typer

from verification.inputs import default_study_groups
from verification.tables import ROOT, publish_markdown
from verification.timing import run_in_subprocess
from verification.whole_run import compare_whole_runs

SCHEMES = ("centred", "cundall")


def main(
    folder: Annotated[Path, typer.Argument(help="checkout of the other state")],
    pairs: Annotated[int, typer.Option(min=1, help="pairs of runs")] = 5,
    whole_run: Annotated[bool, typer.Option("--whole-run", help="compare runs of the default study, too")] = False,
) -> None:
    """Print processor times, million block steps per second and their ratios."""
    groups, settings = default_study_groups(12, 9)[:3], [{"scheme": scheme} for scheme in SCHEMES]
    runs = [
        [run_in_subprocess(groups, settings, checkout=checkout) for checkout in (ROOT, folder)] for _ in range(pairs)
    ]
    for number, scheme in enumerate(SCHEMES):
        times = [[state[number].seconds for state in pair] for pair in runs]
        rates = [
            [state[number].results.block_steps.sum() / state[number].seconds / 1e6 for state in pair] for pair in runs
        ]
        here, there = (median(pair[state] for pair in rates) for state in (0, 1))
        speed, time = (median(pair[0] / pair[1] for pair in values) for values in (rates, times))
        print(f"{scheme}: {here:.1f} against {there:.1f} million block steps/s,", end=" ")
        print(f"ratio of speeds {speed:.3f}, of times {time:.3f} (medians of {pairs} pairs)")
    if whole_run:
        print(body := compare_whole_runs(folder.resolve(), pairs))
        publish_markdown({"paired-run": body})


if __name__ == "__main__":
    typer.run(main)
