"""`python -m verification.paired FOLDER`: compare the speed of two checkouts, in alternating processes.

Use it for a change that must not reduce speed: FOLDER is a checkout of the state before it. The processor times are
those of sweeps of three default records, for each scheme. The speed of a machine drifts, so only the ratios within a
pair of runs are meaningful. With `--whole-run`, complete runs of the studies `config/near-fault.yaml` (the default) and
`config/in-space.yaml` are compared instead, and docs/measurements.md gets the tables.
"""

from pathlib import Path
from statistics import median
from typing import Annotated

import typer

from verification.inputs import default_study_case_groups
from verification.tables import ROOT, update_marked_tables_and_sentences_in_docs
from verification.timing import run_case_groups_in_subprocess
from verification.whole_run import compare_run_costs_with_other_checkout

COMPARED_SCHEMES = ("centred", "cundall")
DOCS_MARKER_BY_STUDY = {"near-fault": "paired-run", "in-space": "paired-run-3d"}
"""Studies whose complete runs are compared, and the block of docs/measurements.md with the table of each."""


def main(
    folder: Annotated[Path, typer.Argument(help="checkout of the other state")],
    pairs: Annotated[int, typer.Option(min=1, help="pairs of runs")] = 5,
    whole_run: Annotated[bool, typer.Option("--whole-run", help="compare complete runs of two studies")] = False,
) -> None:
    """Compare the speed of this checkout with that of another one.

    Print million block steps per second and the ratios of speeds and times; with `whole_run`, compare complete runs of
    two studies, and write these tables into the docs.
    """
    if whole_run:
        tables = {}
        for name, block in DOCS_MARKER_BY_STUDY.items():
            study = (ROOT / "config" / f"{name}.yaml").read_text(encoding="utf-8")
            print(body := compare_run_costs_with_other_checkout(folder.resolve(), pairs, study), flush=True)
            tables[block] = body
        update_marked_tables_and_sentences_in_docs(tables)
        return
    groups, settings = default_study_case_groups(12, 9)[:3], [{"scheme": scheme} for scheme in COMPARED_SCHEMES]
    runs = [
        [run_case_groups_in_subprocess(groups, settings, checkout_folder=checkout) for checkout in (ROOT, folder)]
        for _ in range(pairs)
    ]
    for number, scheme in enumerate(COMPARED_SCHEMES):
        times = [[state[number].processor_time_s for state in pair] for pair in runs]
        rates = [
            [state[number].results.block_steps.sum() / state[number].processor_time_s / 1e6 for state in pair]
            for pair in runs
        ]
        here, there = (median(pair[state] for pair in rates) for state in (0, 1))
        speed, time = (median(pair[0] / pair[1] for pair in values) for values in (rates, times))
        print(f"{scheme}: {here:.1f} against {there:.1f} million block steps/s,", end=" ")
        print(f"ratio of speeds {speed:.3f}, of times {time:.3f} (medians of {pairs} pairs)")


if __name__ == "__main__":
    typer.run(main)
