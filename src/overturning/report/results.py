"""Results of a study as the report uses them: findings' results with figures, cases to watch and phrases."""

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from overturning.figures.drawn_case import DrawnCase, read_cases
from overturning.figures.style import style
from overturning.figures.write import save
from overturning.findings import results as findings
from overturning.findings.results import RecordName
from overturning.report.words import Words, words_of
from overturning.statistics.by_record import record_groups
from overturning.study.cube import first_shown_block
from overturning.study.scenes import variant_scene
from overturning.study.schema import Study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_MAPS = 4
"""Number of maps at the beginning; the maps of other records are with the records."""


@dataclass(frozen=True, kw_only=True)
class Results(findings.Results):
    """Results of a study, with figures.

    Attributes
    ----------
    figures, drawings : Path
        Folder of the study's figures, and one for figures that the report draws itself.
    illustrative : list of DrawnCase
        Cases to watch.
    """

    figures: Path
    drawings: Path
    illustrative: list[DrawnCase]

    @property
    def words(self) -> Words:
        """Phrases for the model of the cube."""
        return words_of(self.cube, len(variant_scene(self.study).free_names))

    @property
    def of_known(self) -> str:
        """Of which cases shares are, as part of a sentence: nothing where none lacks an outcome."""
        return " whose outcome is known" if any(absent for _, absent in self.status_counts.values()) else ""

    @cached_property
    def first_records(self) -> list[RecordName]:
        """Records with a map at the beginning: all, or the first of each of a few earthquakes of the first group.

        Records without falls are left out if others have falls.
        """
        if len(self.record_names) <= MOST_MAPS:
            return list(self.record_names)
        members = next(iter(record_groups(self.cube).values()))
        block = self.cube["overturned"].sel(first_shown_block(self.cube, self.study))
        falls = members & (abs(block) == 1).any([name for name in block.dims if name != "record"]).to_numpy()
        chosen = zip(self.record_names, falls if falls.any() else members, strict=True)
        one_each = {name.event: name for name, own in reversed(list(chosen)) if own}
        return sorted(one_each.values(), key=self.record_names.index)[:MOST_MAPS]

    def drawn(self, name: str, draw: "Callable[[], Figure]") -> Path:
        """Draw a figure of the report into a file and return its path."""
        with style():
            save(draw(), self.drawings / f"{name}.svg")
        return self.drawings / f"{name}.svg"


@contextmanager
def open_results(folder: Path, beside: Study | None = None) -> Iterator[Results]:
    """Open a study's folder of results as `overturning.findings.results.open_results` does, with its figures."""
    with findings.open_results(folder, beside) as opened, tempfile.TemporaryDirectory() as drawings:
        yield Results(
            **{one.name: getattr(opened, one.name) for one in fields(opened)},
            figures=folder / "figures",
            drawings=Path(drawings),
            illustrative=read_cases(folder / "figures" / "illustrative"),
        )
