"""Results of a study, opened once, and the statistics that findings and report share."""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.labels import note_if_sizes_are_not_those_of_shown_stone
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.model import Model
from overturning.model.plane_weights import azimuths_in_results_bias_mean_fall_axis
from overturning.statistics import alignment_by_rule, earthquakes, reference_directions
from overturning.statistics.bootstrap import MeanOverEarthquakes
from overturning.statistics.circular import MIN_RESULTANT_WITH_MEAN_DIRECTION
from overturning.statistics.elements import ElementFallCounts, count_falls_of_each_and_any_element
from overturning.statistics.fragility import FittedFragilityCurve
from overturning.statistics.logistic import LogisticFit, fit_logistic_overturning_model
from overturning.statistics.opposite_azimuths import overturned_share
from overturning.statistics.space import count_agreeing_and_differing_2d_3d_outcomes
from overturning.study.convergence import ConvergenceCheckResult
from overturning.study.scenes import (
    NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
    select_outcomes_of_element,
    variant_scene,
)
from overturning.study.schema import Study
from overturning.surveys.displacement_results import StoredDisplacementComparison
from overturning.surveys.fragility_results import FRAGILITY_CURVES_PATH, fit_or_read_fragility_curves
from overturning.surveys.posterior import SurveyInversionResult
from overturning.surveys.stored_comparison import StoredSurveyComparison


@dataclass(frozen=True)
class RecordIdAndNames:
    """Identifier of a record, with the names of its station and its earthquake, which may be empty."""

    id: str
    station_name: str
    earthquake_name: str


@dataclass(frozen=True, kw_only=True)
class StudyResults:
    """Opened results files of one study, and statistics that are computed when first needed.

    Attributes
    ----------
    study : Study
        The study.
    reference_element_cube : xarray.Dataset
        Results cube of the reference element of the study's scene; read one record at a time.
    cubes_by_variant : dict of xarray.Dataset
        Cubes with all elements, by name of the variant or of the study itself; read one record at a time.
    other_amplitudes_cube : xarray.Dataset or None
        Cube like `reference_element_cube` at the other amplitude factors of the study, over ``amplitude``; None if
        the study has one factor.
    intensity_measures : xarray.Dataset
        Intensity measures of the records.
    convergence : ConvergenceCheckResult or None
        Result of the study's convergence check; None if the study has none.
    survey_comparisons : tuple of StoredSurveyComparison
        Comparisons of surveys of stones with the study's predictions; empty for a 3-D study.
    survey_displacement_comparisons : tuple of StoredDisplacementComparison
        Comparisons of the displacements in surveys with those of a 3-D study; empty for a 2-D study.
    population_rates_by_variant : dict of xarray.Dataset
        Fall rates of the study's stone population, keyed as `cubes_by_variant`; empty without a population.
    inferred_motions : tuple of SurveyInversionResult
        Motions inferred from the surveys with the key `backwards`.
    results_folder : Path
        Folder of the results.
    names_of_cubes_changed_after_run : tuple of str
        Names of the cubes whose outcomes were changed after the run.
    """

    study: Study
    reference_element_cube: xr.Dataset
    cubes_by_variant: dict[str, xr.Dataset]
    intensity_measures: xr.Dataset
    convergence: ConvergenceCheckResult | None
    survey_comparisons: tuple[StoredSurveyComparison, ...]
    survey_displacement_comparisons: tuple[StoredDisplacementComparison, ...] = ()
    population_rates_by_variant: dict[str, xr.Dataset] = field(default_factory=dict)
    inferred_motions: tuple[SurveyInversionResult, ...] = ()
    results_folder: Path = Path()
    names_of_cubes_changed_after_run: tuple[str, ...] = ()
    other_amplitudes_cube: xr.Dataset | None = None

    @cached_property
    def record_ids_and_names(self) -> tuple[RecordIdAndNames, ...]:
        """Identifier, station and earthquake of each record, in the order of the results."""
        cube = self.reference_element_cube
        texts = (cube[name].to_numpy().astype(str).tolist() for name in ("record_id", "station", "event"))
        return tuple(RecordIdAndNames(*each) for each in zip(*texts, strict=True))

    @cached_property
    def record_events(self) -> NDArray[np.str_]:
        """Name of the earthquake of each record, shape (records,)."""
        return self.reference_element_cube["event"].to_numpy().astype(str)

    @property
    def earthquake_count(self) -> int:
        """Number of earthquakes of the study."""
        return len(set(self.record_events))

    @cached_property
    def count_of_records_with_applied_vertical(self) -> int:
        """Number of records with vertical motion that the study applies."""
        return int((self.reference_element_cube["vertical"] == 1).sum().compute())

    @property
    def count_of_records_with_unused_vertical(self) -> int:
        """Number of records whose vertical component the study does not apply."""
        return 0 if self.study.simulation.vertical else int(self.intensity_measures["pga_vertical"].notnull().sum())

    @cached_property
    def model(self) -> Model:
        """Mechanical model (2-D or 3-D) with which the results of the study were computed."""
        return default_model_of_same_kind_as_results_cube(self.reference_element_cube)

    @cached_property
    def simulated_azimuths_impose_fall_axis(self) -> bool:
        """True if falls have an axis only because one vertical plane or a sector of azimuths was simulated."""
        return azimuths_in_results_bias_mean_fall_axis(self.reference_element_cube)

    @cached_property
    def logistic_fit(self) -> LogisticFit | None:
        """Logistic fit of the fall probability; None in 3-D, or if B/H is not that of the stone shown."""
        if not self.model.is_planar or note_if_sizes_are_not_those_of_shown_stone(self.reference_element_cube):
            return None
        return fit_logistic_overturning_model(self.reference_element_cube, self.intensity_measures)

    @cached_property
    def share_overturned(self) -> float:
        """Share of the cases with a known outcome that overturn; NaN if no outcome is known."""
        return float(overturned_share(self.reference_element_cube))

    @cached_property
    def fall_counts_of_study_elements(self) -> tuple[ElementFallCounts, ...]:
        """Numbers of falls of each element of the study's own scene, and of cases in which any element falls.

        Empty for a scene of one free element.
        """
        name = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
        return self.element_fall_counts_by_variant[name] if "element" in self.cubes_by_variant[name].dims else ()

    @cached_property
    def element_fall_counts_by_variant(self) -> dict[str, tuple[ElementFallCounts, ...]]:
        """Numbers of falls of each element of the scene, by name of the variant.

        A scene of one free element has one row, "block".
        """
        return {name: tuple(count_falls_of_each_and_any_element(cube)) for name, cube in self.cubes_by_variant.items()}

    @cached_property
    def case_and_missing_outcome_counts_by_status(self) -> dict[str, tuple[int, int]]:
        """Numbers of all cases and of cases without an outcome, by name of the case status."""
        status, unknown = self.reference_element_cube["status"], self.reference_element_cube["overturned"].isnull()
        counts = {}
        for code, name in zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True):
            cells = status == code
            counts[name.replace("_", " ")] = (int(cells.sum().compute()), int((cells & unknown).sum().compute()))
        return counts

    @property
    def free_element_names(self) -> tuple[str, ...]:
        """Names of the free elements of the study's own scene."""
        return variant_scene(self.study).free_element_names

    @cached_property
    def mean_fall_directions_and_axes_by_record(self) -> xr.Dataset:
        """Mean direction and mean axis of the falls under each record, with their mean resultant lengths.

        Only blocks of `mask_of_blocks_for_direction_statistics` count. All values are missing if the
        simulated planes alone impose an axis, and for records whose unknown outcomes may (``is_imposed``).
        """
        return earthquakes.mean_fall_directions_and_axes_by_record(self.reference_element_cube)

    @cached_property
    def fall_axes_from_fault_normal_by_record_group(self) -> dict[str, xr.Dataset]:
        """Mean fall axis of each earthquake relative to its fault normal, by record group (such as with a pulse)."""
        return earthquakes.fall_axes_from_fault_normal_by_group(self.reference_element_cube)

    @cached_property
    def fall_axis_to_fault_normal_summary_by_record_group(
        self,
    ) -> dict[str, earthquakes.MeanFallAxisAndAlignmentOverEarthquakes]:
        """Summary over earthquakes of the fall axes relative to the fault normals, by name of the group of records."""
        return {
            name: earthquakes.summarise_fall_axes(axes)
            for name, axes in self.fall_axes_from_fault_normal_by_record_group.items()
        }

    @cached_property
    def first_minus_second_record_group_alignment(self) -> MeanOverEarthquakes | None:
        """Mean alignment of falls with the fault normal, first minus second record group; None unless there are two."""
        groups = self.fall_axes_from_fault_normal_by_record_group.values()
        return earthquakes.difference_in_mean_alignment_with_fault_normal(*groups) if len(groups) == 2 else None

    @cached_property
    def fault_normal_alignments_by_record_group(
        self,
    ) -> dict[str, list[alignment_by_rule.FaultNormalAlignmentOfSelectedBlocks]]:
        """Alignments of falls with the fault normal, one for each block selection rule, by name of the record group."""
        return alignment_by_rule.fault_normal_alignments_by_record_group(self.reference_element_cube)

    @cached_property
    def fall_alignments_by_group_and_b_over_h_labels(
        self,
    ) -> tuple[dict[str, reference_directions.MeanFallAlignmentByBOverH], list[str]]:
        """Alignments of falls with reference directions, by name of the record group; and labels of B/H ranges.

        The first alignment in each list is over all B/H; the following ones are over the labelled ranges.
        """
        ratio = self.reference_element_cube["b_over_h"].to_numpy()
        count, classes = (
            ratio.size,
            min(MAX_B_OVER_H_RANGES_OF_REFERENCE_ALIGNMENT, ratio.size) if ratio.size > 1 else 0,
        )
        parts = [slice(count * part // classes, count * (part + 1) // classes) for part in range(classes)]
        ends = (dict.fromkeys(f"{end:g}" for end in ratio[part][[0, -1]]) for part in parts)
        names = [f"B/H {' to '.join(one)}" for one in ends]
        return reference_directions.alignments_with_reference_axes_by_record_group(
            self.reference_element_cube, self.intensity_measures, [slice(0, count), *parts]
        ), names

    @cached_property
    def fragility_curves(self) -> list[FittedFragilityCurve]:
        """Fitted fragility curves of the study's population of stones; empty without a population."""
        rates, file = self.population_rates_by_variant, self.results_folder / FRAGILITY_CURVES_PATH
        return (
            fit_or_read_fragility_curves(rates[NAME_OF_STUDY_ITSELF_AMONG_VARIANTS], self.intensity_measures, file)
            if rates
            else []
        )

    @cached_property
    def agreement_counts_of_2d_and_3d_outcomes(self) -> xr.Dataset:
        """Counts of 2-D simulations that give the 3-D outcome; see `count_agreeing_and_differing_2d_3d_outcomes`."""
        return count_agreeing_and_differing_2d_3d_outcomes(self.reference_element_cube)

    @property
    def has_falls_with_known_fault_normal(self) -> bool:
        """True if at least one earthquake has both falls and a known fault normal."""
        summaries = self.fall_axis_to_fault_normal_summary_by_record_group.values()
        return any(one.mean_cos_of_doubled_angle_to_fault_normal.earthquake_count > 0 for one in summaries)

    @property
    def any_fault_normal_is_stated(self) -> bool:
        """True if the study knows the fault normal of at least one record, with or without falls."""
        return bool(np.isfinite(self.reference_element_cube["fault_normal"].to_numpy().astype(np.float64)).any())

    @property
    def is_2d_and_every_case_overturns(self) -> bool:
        """True if the model is 2-D and every case with known outcome overturns, so that falls show no axis."""
        return self.model.is_planar and self.share_overturned >= 1

    @property
    def any_record_has_fall_axis(self) -> bool:
        """True if at least one record has a mean fall axis: a resultant of the doubled axes that is large enough.

        A record has none if each of its blocks falls in every simulated direction or in none.
        """
        resultant = self.mean_fall_directions_and_axes_by_record["axis_resultant"].to_numpy()
        return bool((resultant >= MIN_RESULTANT_WITH_MEAN_DIRECTION).any())

    @property
    def ids_of_records_with_fall_axis_due_to_gaps(self) -> list[str]:
        """Ids of the records whose mean fall axis may be due only to unknown outcomes at some azimuths."""
        imposed = self.mean_fall_directions_and_axes_by_record["is_imposed"].to_numpy()
        return [name.id for name, one in zip(self.record_ids_and_names, imposed, strict=True) if one]

    @property
    def has_fall_axis_comparable_with_fault_normal(self) -> bool:
        """True if falls have an axis that can be compared with a known fault normal."""
        return (
            self.has_falls_with_known_fault_normal
            and self.any_record_has_fall_axis
            and self.share_overturned > 0
            and not self.simulated_azimuths_impose_fall_axis
            and not self.is_2d_and_every_case_overturns
        )

    def cube_of_default_element(self, variant_name: str) -> xr.Dataset:
        """Return a variant's results cube for the scene element whose outcomes are shown by default."""
        return select_cube_of_default_element(self.study, variant_name, self.cubes_by_variant[variant_name])


STUDY_KEYS_NOT_AFFECTING_CUBE = ("title", "question", "asks", "language", "primary", "figures", "population", "crate")
"""Settings of a study on which the cube does not depend."""

MAX_B_OVER_H_RANGES_OF_REFERENCE_ALIGNMENT = 3
"""Number of ranges of B/H for which the alignment with references is computed."""


def select_cube_of_default_element(study: Study, variant_name: str, cube: xr.Dataset) -> xr.Dataset:
    """Select from a variant's results cube the scene element whose outcomes are shown by default."""
    return select_outcomes_of_element(cube, variant_scene(study, variant_name).name_of_element_shown_by_default)
