"""The results of a study that the report speaks of, opened once."""

import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.figures.drawn_case import DrawnCase, read_cases
from overturning.figures.style import style
from overturning.figures.write import save
from overturning.files import portable_name
from overturning.model.falls import model_of
from overturning.model.model import Model
from overturning.report.words import Words, words_of
from overturning.statistics import alignment_by_rule, earthquakes
from overturning.statistics.bootstrap import Mean
from overturning.statistics.by_record import by_record, record_groups
from overturning.statistics.elements import ElementFalls, falls_by_element
from overturning.statistics.falls import fall_means, overturns
from overturning.statistics.space import plane_counts
from overturning.study.convergence import Convergence, read_convergence
from overturning.study.cube import open_records, shown_block, study_of
from overturning.study.scenes import NOMINAL, scene_of
from overturning.study.schema import Study
from overturning.surveys.comparison import SurveyResult, read_survey
from overturning.surveys.population import population_rates
from overturning.surveys.posterior import InversionResult, read_inversion

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class RecordName:
    """What a record is called; station and event may be empty."""

    id: str
    station: str
    event: str

    @property
    def heading(self) -> str:
        """Station and earthquake."""
        return ", ".join(text for text in (self.station, self.event) if text) or self.id


@dataclass(frozen=True)
class Results:
    """Results of a study.

    Attributes
    ----------
    study : Study
        The study.
    cube : xarray.Dataset
        Its cube, of the reference element of its scene; read one record at a time.
    cubes : dict of xarray.Dataset
        Cubes of all elements, of the study itself and of its variants, by name; read one record at a time.
    intensity : xarray.Dataset
        Intensity measures.
    figures, drawings : Path
        Folder of the study's figures, and one for those that the report draws itself.
    illustrative : list of DrawnCase
        Title, block, outcomes, rule, film and figures of each case to watch.
    convergence : Convergence or None
        What its convergence check found; None where the study leaves that out.
    surveys : tuple of SurveyResult
        Surveys of stones beside its predictions.
    populations : dict of xarray.Dataset
        Fall rates of the study's population, by the names of the cubes; empty where it has none.
    backwards : tuple of InversionResult
        Motion that each survey asks for, of those with the key `backwards`.
    """

    study: Study
    cube: xr.Dataset
    cubes: dict[str, xr.Dataset]
    intensity: xr.Dataset
    figures: Path
    drawings: Path
    illustrative: list[DrawnCase]
    convergence: Convergence | None
    surveys: tuple[SurveyResult, ...]
    populations: dict[str, xr.Dataset] = field(default_factory=dict)
    backwards: tuple[InversionResult, ...] = ()

    @cached_property
    def names(self) -> tuple[RecordName, ...]:
        """What the records are called."""
        texts = (self.cube[name].to_numpy().astype(str).tolist() for name in ("record_id", "station", "event"))
        return tuple(RecordName(*each) for each in zip(*texts, strict=True))

    @cached_property
    def events(self) -> NDArray[np.str_]:
        """Earthquake of each record."""
        return self.cube["event"].to_numpy().astype(str)

    @property
    def earthquake_count(self) -> int:
        """Number of earthquakes."""
        return len(set(self.events))

    @cached_property
    def with_vertical(self) -> int:
        """Number of records whose vertical motion was applied."""
        return int((self.cube["vertical"] == 1).sum().compute())

    @property
    def without_their_vertical(self) -> int:
        """Number of records whose vertical motion the study leaves out."""
        return 0 if self.study.simulation.vertical else int(self.intensity["pga_vertical"].notnull().sum())

    @cached_property
    def model(self) -> Model:
        """What stands on the ground."""
        return model_of(self.cube)

    @property
    def words(self) -> Words:
        """What is said of it."""
        return words_of(self.cube, len(scene_of(self.study).free))

    @cached_property
    def one_axis(self) -> bool:
        """Whether falls can go along one axis only, as in a single plane, so that nothing is told about direction."""
        axes = self.cube[self.model.direction].to_numpy().astype(np.float64) % 180.0
        return self.model.one_component and bool(np.ptp(axes) == 0.0)

    @cached_property
    def fallen(self) -> float:
        """Share of all cases that overturn; NaN where no outcome was found."""
        return float(overturns(self.cube).mean().compute())

    @cached_property
    def elements(self) -> tuple[ElementFalls, ...]:
        """Falls of each element of the study's own scene, of anything last; empty where it has one free element."""
        cube = self.cubes[NOMINAL]
        return tuple(falls_by_element(cube)) if "element" in cube.dims else ()

    @cached_property
    def statuses(self) -> dict[str, tuple[int, int]]:
        """Number of cells by status, and of those among them without an outcome."""
        status, unknown = self.cube["status"], self.cube["overturned"].isnull()
        counts = {}
        for code, name in zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True):
            cells = status == code
            counts[name.replace("_", " ")] = (int(cells.sum().compute()), int((cells & unknown).sum().compute()))
        return counts

    @property
    def of_known(self) -> str:
        """Of which cases shares are, as part of a sentence: nothing where none lacks an outcome."""
        return " whose outcome is known" if any(absent for _, absent in self.statuses.values()) else ""

    @cached_property
    def record_means(self) -> xr.Dataset:
        """Mean direction and axis of each record's falls with their resultants, over the informative blocks."""
        means = partial(fall_means, over=self.model.case_dims, informative=True)
        return by_record(means, self.cube, self.model.reads)

    @cached_property
    def _axes(self) -> dict[str, xr.Dataset]:
        return earthquakes.axes_by_group(self.cube)

    @cached_property
    def axes(self) -> dict[str, earthquakes.AxisSummary]:
        """Fall axes relative to the fault normal, by group of records."""
        return {name: earthquakes.summarise_axes(axes) for name, axes in self._axes.items()}

    @cached_property
    def axes_difference(self) -> Mean | None:
        """Of the two groups, where there are two."""
        return earthquakes.compare_alignment(*self._axes.values()) if len(self._axes) == 2 else None

    @cached_property
    def alignment_by_rule(self) -> dict[str, list[alignment_by_rule.RuleAlignment]]:
        """Alignment with the fault normal under each rule that chooses blocks, by group of records."""
        return alignment_by_rule.alignment_by_rule(self.cube)

    @cached_property
    def followed(self) -> tuple[dict[str, earthquakes.ReferenceAlignment], list[str]]:
        """What falls follow, for all B/H and then for parts of them, and the names of these parts, none of one B/H."""
        ratio = self.cube["b_over_h"].to_numpy()
        count, classes = ratio.size, min(CLASSES, ratio.size) if ratio.size > 1 else 0
        parts = [slice(count * part // classes, count * (part + 1) // classes) for part in range(classes)]
        ends = (dict.fromkeys(f"{end:g}" for end in ratio[part][[0, -1]]) for part in parts)
        names = [f"B/H {' to '.join(one)}" for one in ends]
        return earthquakes.alignment_with_references(self.cube, self.intensity, [slice(0, count), *parts]), names

    @cached_property
    def plane_counts(self) -> xr.Dataset:
        """What planes say beside a cube in space, as of `statistics.space.plane_counts`."""
        return plane_counts(self.cube)

    @property
    def faults_known(self) -> bool:
        """Whether a fall can be compared with a fault."""
        return any(summary.alignment.n > 0 for summary in self.axes.values())

    @property
    def every_plane_falls(self) -> bool:
        """Whether every block falls in every plane, so that no axis is easier; in space falls have directions then."""
        return self.model.one_component and self.fallen >= 1

    @property
    def tells_axes(self) -> bool:
        """Whether there is an axis relative to a fault to speak of."""
        return self.faults_known and self.fallen > 0 and not self.one_axis and not self.every_plane_falls

    @cached_property
    def first_records(self) -> list[RecordName]:
        """Records whose maps stand first: all, or of the first group the first of each of a few earthquakes.

        Records in whose map nothing falls are passed over, where there are others.
        """
        if len(self.names) <= MOST_MAPS:
            return list(self.names)
        members = next(iter(record_groups(self.cube).values()))
        block = self.cube["overturned"].sel(shown_block(self.cube, self.study))
        falls = members & (abs(block) == 1).any([name for name in block.dims if name != "record"]).to_numpy()
        chosen = zip(self.names, falls if falls.any() else members, strict=True)
        one_each = {name.event: name for name, own in reversed(list(chosen)) if own}
        return sorted(one_each.values(), key=self.names.index)[:MOST_MAPS]

    def reference_cube(self, variant: str) -> xr.Dataset:
        """Cube of the reference element of a variant's scene."""
        return _reference_cube(self.study, variant, self.cubes[variant])

    def drawn(self, name: str, draw: "Callable[[], Figure]") -> Path:
        """The file of a figure that the report draws itself."""
        with style():
            save(draw(), self.drawings / f"{name}.svg")
        return self.drawings / f"{name}.svg"


OF_THE_REPORT = ("title", "question", "asks", "primary", "figures", "population", "crate")
"""Keys of a study that the cube does not depend on."""

CLASSES = 3
"""Parts of the B/H of a study that are told apart where it is said what falls follow."""

MOST_MAPS = 4
"""Maps that stand at the beginning; those of further records stand with the records."""


def _reference_cube(study: Study, variant: str, cube: xr.Dataset) -> xr.Dataset:
    return cube.sel(element=scene_of(study, variant).default_element) if "element" in cube.dims else cube


@contextmanager
def open_results(folder: Path, beside: Study | None = None) -> Iterator[Results]:
    """Open a study's folder of results: cubes, intensities, figures, surveys, convergence; `ResultError` without one.

    What is `OF_THE_REPORT`, and the surveys, are those of `beside`, or of the cube's study where it is not given.
    """

    def cube_of(name: str) -> xr.Dataset:
        path = folder / ("cube.nc" if name == NOMINAL else f"cube.{name}.nc")
        cube = open_records(path, element=None, amplitude=None)
        stack.callback(cube.close)
        return cube

    def recorded(cube: xr.Dataset) -> xr.Dataset:
        return cube.sel(amplitude=1.0, drop=True) if "amplitude" in cube.dims else cube

    with ExitStack() as stack:
        # Each file is opened once: read through two handles at a time, it crashed the library below.
        nominal = cube_of(NOMINAL)
        study = study_of(nominal)
        if beside is not None:
            named = (survey.model_copy(update={"stones": portable_name(survey.stones)}) for survey in beside.surveys)
            own = {name: getattr(beside, name) for name in OF_THE_REPORT}
            study = study.model_copy(update=own | {"surveys": tuple(named)})
        whole = {NOMINAL: nominal} | {name: cube_of(name) for name in study.variants}
        cubes = {name: recorded(cube) for name, cube in whole.items()}
        stones, files = study.population, [folder / "survey" / f"{n + 1}" for n in range(len(study.surveys))]
        asked = [file for file, survey in zip(files, study.surveys, strict=True) if survey.backwards]
        yield Results(
            study,
            _reference_cube(study, NOMINAL, cubes[NOMINAL]),
            cubes,
            stack.enter_context(xr.open_dataset(folder / "intensity.nc")),
            folder / "figures",
            Path(stack.enter_context(tempfile.TemporaryDirectory())),
            read_cases(folder / "figures" / "illustrative"),
            read_convergence(folder / "convergence.json") if study.verification != "none" else None,
            tuple(read_survey(file.with_suffix(".json")) for file in files),
            {name: population_rates(cube, stones) for name, cube in whole.items()} if stones else {},
            tuple(read_inversion(file.with_suffix(".motion.nc")) for file in asked),
        )
