"""`python -m verification.answers`: write the table of the findings of the shipped studies into README.md.

Requires the results of the studies in `STUDIES` and of config/fine-map.yaml, from `make run STUDY=…`.
"""

import math
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from overturning.findings.contrast import compared_records
from overturning.findings.results import Results, open_results
from overturning.statistics.bootstrap import Mean
from overturning.statistics.elements import count_common_falls, mean_contrast
from overturning.study.load import load_study
from overturning.study.scenes import NOMINAL
from verification.tables import ROOT, markdown, publish

Row = tuple[str, str, int]
"""Quantity, its value with its 95 % interval, and the number of earthquakes."""

PICTURES: Final = {"rinaldi.svg": "fine-map", "rinaldi-in-space.svg": "in-space"}
"""Image in docs/images → study whose map of the Rinaldi record it shows."""


def _row(quantity: str, mean: Mean, *, percent: bool = False) -> Row:
    """Return a row of the table; without an interval if there are too few earthquakes."""

    def number(value: float) -> str:
        shown = f"{100 * value:.{0 if value >= 0.1 else 1}f}" if percent else f"{value:.2f}"
        return shown.lstrip("-") if float(shown) == 0 else shown.replace("-", "−")

    none = math.isnan(mean.low) or mean.low == mean.high
    interval = "" if none else f" ({number(mean.low)} to {number(mean.high)})"
    return quantity, f"{number(mean.value)}{interval}{' %' if percent else ''}", mean.n


def _group(name: str) -> str:
    """Return a short name of a group of records."""
    return "no pulse" if name.startswith("without") else "velocity pulse"


def _direction(results: Results) -> Iterator[Row]:
    for group, summary in results.axis_summaries.items():
        yield _row(f"alignment with the fault normal, {_group(group)}", summary.alignment)


def _reference(results: Results) -> Iterator[Row]:
    for group, found in results.reference_alignment[0].items():
        for name in ("peak velocity", "fault normal"):
            yield _row(f"alignment with the {name}, {_group(group)}", found.means[name, True][0])


def _contrast(results: Results) -> Iterator[Row]:
    other = results.study.primary.against
    assert other is not None
    places = compared_records(results, other)
    counts = count_common_falls(*(results.reference_cube(name).isel(record=places) for name in (NOMINAL, other)))
    found = mean_contrast(counts, results.events[places])
    yield _row("falls in both", found.both, percent=True)
    yield _row(f"falls in “{results.study.name}” only", found.only_this, percent=True)
    yield _row(f"falls in “{other}” only", found.only_other, percent=True)
    if found.same_way.n:
        yield _row("falls the same way, where it falls in both", found.same_way, percent=True)


STUDIES: Final[dict[str, Callable[[Results], Iterator[Row]]]] = {
    "near-fault": _direction, "in-space": _reference, "three-tier": _contrast, "waiau": _contrast,
}  # fmt: skip


def main() -> None:
    """Write the table and copy the maps."""
    lines = []
    for name, rows in STUDIES.items():
        study = load_study(ROOT / "config" / f"{name}.yaml")
        with open_results(ROOT / "results" / name, study) as results:
            question = f"{study.question} ([{name}](config/{name}.yaml))"
            for quantity, value, earthquakes in rows(results):
                lines.append((question, quantity, value, earthquakes))
                question = ""
    for picture, study_name in PICTURES.items():
        drawn: Path = ROOT / "results" / study_name / "figures" / "polar" / "rinaldi.svg"
        shutil.copyfile(drawn, ROOT / "docs" / "images" / picture)
    publish({"found": markdown(("question", "quantity", "result (95 % interval)", "earthquakes"), lines)})


if __name__ == "__main__":
    main()
