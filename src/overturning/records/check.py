"""Check record files: report each record with its axes, peaks and notes, or the reason why it is refused."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from overturning.errors import REASON_SEPARATOR, OverturningError
from overturning.records.assembly import assemble_record
from overturning.records.component import RecordComponent, peak_acceleration_comparable_to_header
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.files import read_components
from overturning.records.formats.table import NO_ACCELERATION_REASON, holds_no_acceleration
from overturning.records.grouping import group_components_by_record
from overturning.records.processing import process_record
from overturning.records.read import (
    copy_record_with_added_notes,
    notes_if_other_file_has_vertical_component,
    read_components_and_paths_of_file_and_siblings,
)
from overturning.records.record import (
    Record,
    displacement_drift_evidence,
    largest_pga_pgv_pgd_of_components,
    processing_entry_text,
    processing_state_label,
)
from overturning.records.source import SourceFile, has_non_record_name, read_source_file


@dataclass(frozen=True)
class RecordCheckResult:
    """Result of checking one record or one unreadable file: the record that was read, or the reason for refusing it."""

    file_names: tuple[str, ...]
    components: tuple[RecordComponent, ...] = ()  # axes of the record; empty if the file cannot be read
    unprocessed_record: Record | None = None  # None if refused or skipped
    refusal_or_skip_reason: str = ""  # why the record is refused or skipped
    record_after_default_processing: Record | None = None
    is_skipped_for_no_acceleration: bool = False  # True for a file of spectra or velocities next to records


def check_records_in_files(
    paths: Sequence[Path], user_declared_properties: DeclaredFileProperties | None = None
) -> list[RecordCheckResult]:
    """Read the components in files and folders, group them into records, and check each record.

    Folders are read recursively; for a single file, the other files of its record are read too. Files that cannot be
    read come first, then records in the order of their files. Without a declared sensor, surface and borehole sensors
    are checked.
    """
    sources, findings = _read_source_files_and_refusals(paths)
    user_declared_properties = (user_declared_properties or DeclaredFileProperties()).with_station_xml_from_files(
        sources
    )
    records = [source for source in sources if source not in user_declared_properties.stationxml_files]
    skipped = [source for source in records if holds_no_acceleration(source)]
    # Spectra and velocities alone are refused, with the reason that their reader gives.
    skipped = skipped if len(skipped) < len(records) else []
    findings += [
        RecordCheckResult(
            (source.name,), refusal_or_skip_reason=NO_ACCELERATION_REASON, is_skipped_for_no_acceleration=True
        )
        for source in skipped
    ]
    components, refused = _read_components_of_chosen_sensor_and_refusals(
        [source for source in records if source not in skipped], user_declared_properties
    )
    findings += refused
    located = [path for path in paths if path.is_file()]
    if len(paths) == len(components) == 1 and paths[0].is_file():
        components, located = read_components_and_paths_of_file_and_siblings(paths[0], user_declared_properties)
    groups = group_components_by_record(components)
    return findings + [_check_record(group, groups, located, user_declared_properties) for group in groups]


def _read_components_of_chosen_sensor_and_refusals(
    source_files: Sequence[SourceFile], user_declared_properties: DeclaredFileProperties
) -> tuple[list[RecordComponent], list[RecordCheckResult]]:
    """Return the components of the sensor that the user chose (default: all), and a result for each refused file."""
    components: list[RecordComponent] = []
    others: list[RecordComponent] = []
    refused = []
    for source in source_files:
        try:
            for one in read_components([source], user_declared_properties):
                (components if user_declared_properties.sensor in (None, one.sensor_position) else others).append(one)
        except OverturningError as problem:
            refused.append(RecordCheckResult((source.name,), refusal_or_skip_reason=str(problem)))
    if others and not components:
        files = tuple(dict.fromkeys(one.file_name for one in others))
        refused.append(
            RecordCheckResult(
                files,
                refusal_or_skip_reason=f"of the {others[0].sensor_position} sensor; "
                f"{user_declared_properties.sensor} is declared",
            )
        )
    return components, refused


def _check_record(
    components: Sequence[RecordComponent],
    component_groups_of_all_records: Sequence[Sequence[RecordComponent]],
    all_file_paths: Sequence[Path],
    user_declared_properties: DeclaredFileProperties,
) -> RecordCheckResult:
    """Check one record, given its components; the result has the assembled record, or the reason for refusing it."""
    files = tuple(dict.fromkeys(c.file_name for c in components))
    try:
        record = assemble_record(components, Path(files[0]).name.split(".")[0].lower(), user_declared_properties)
        own = [path for path in all_file_paths if path.name in files]
        record = copy_record_with_added_notes(
            record, notes_if_other_file_has_vertical_component(own, components, user_declared_properties) if own else []
        )
        return RecordCheckResult(
            files, tuple(components), record, record_after_default_processing=process_record(record, None)
        )
    except OverturningError as problem:
        several = _refusal_reason_if_several_sensors(components, component_groups_of_all_records)
        reason = REASON_SEPARATOR.join([several, str(problem)] if several else [str(problem)])
        return RecordCheckResult(files, tuple(components), refusal_or_skip_reason=reason)


def _refusal_reason_if_several_sensors(
    components: Sequence[RecordComponent], component_groups_of_all_records: Sequence[Sequence[RecordComponent]]
) -> str:
    """Return the reason to refuse components if sensors at several places of a station recorded the event, or ""."""
    first = components[0]
    alike = [
        one[0]
        for one in component_groups_of_all_records
        if all(getattr(one[0], n) == getattr(first, n) for n in ("station", "event"))
    ]
    places = list(dict.fromkeys(one.sensor_location for one in alike if one.sensor_location))
    if len(places) < 2 or not first.sensor_location:
        return ""
    named = " and ".join(map(repr, places[:6])) + (f" and {len(places) - 6} more" if len(places) > 6 else "")
    return f"{first.file_name}: components of {named} are not of one record; give the files of one place together"


def _read_source_files_and_refusals(paths: Sequence[Path]) -> tuple[list[SourceFile], list[RecordCheckResult]]:
    """Read the files at the paths; return them, and a refusal for each unreadable file or folder without records."""
    sources, findings = [], []
    for path in paths:
        there, skipped = _list_all_and_skipped_files(path, is_only_path_of_command=len(paths) == 1)
        if path.is_dir() and len(there) == len(skipped):
            why = f"{len(there)} files, none of them a record" if there else "an empty folder"
            findings.append(RecordCheckResult((path.name,), refusal_or_skip_reason=f"{path}: {why}"))
        for member in there:
            try:
                sources += [] if member in skipped else [read_source_file(member)]
            except OverturningError as problem:
                findings.append(RecordCheckResult((member.name,), refusal_or_skip_reason=str(problem)))
    return sources, findings


def _list_all_and_skipped_files(
    file_or_folder_path: Path, *, is_only_path_of_command: bool
) -> tuple[list[Path], list[Path]]:
    """List all files in a folder (or a single file), and those among them that are skipped because of their names.

    A file that is the only argument of a command is never skipped.
    """
    there = (
        sorted(p for p in file_or_folder_path.rglob("*") if p.is_file())
        if file_or_folder_path.is_dir()
        else [file_or_folder_path]
    )
    return there, [
        p for p in there if has_non_record_name(p) and (file_or_folder_path.is_dir() or not is_only_path_of_command)
    ]


def names_of_files_skipped_by_name(paths: Sequence[Path]) -> list[str]:
    """Return the names of files that are skipped: hidden ones, and those with an extension of no record format."""
    return sorted(
        p.name for path in paths for p in _list_all_and_skipped_files(path, is_only_path_of_command=len(paths) == 1)[1]
    )


def format_record_check(record_check: RecordCheckResult) -> str:
    """Format the result of checking one record as a few lines of text: metadata, axes, notes and peaks, or refusal."""
    head = ", ".join(record_check.file_names)
    record = record_check.unprocessed_record
    if record is None:
        axes = "".join(f"\n  {_format_component_summary(c)}" for c in record_check.components)
        word = "skipped" if record_check.is_skipped_for_no_acceleration else "refused"
        return (
            head
            + "".join(f"\n  {word}: {why}" for why in record_check.refusal_or_skip_reason.split(REASON_SEPARATOR))
            + axes
        )
    place = "" if record.latitude is None else f" ({record.latitude:z.4f}, {record.longitude:z.4f})"
    what = [x for x in (record.station + place, record.event, record.start or "start not stated") if x.strip()]
    kind = processing_state_label(record)
    lines = [
        head,
        f"  {record.extra['format']}, {kind}: {'; '.join(what)}",
        f"  {record.north.size} samples every {record.sampling_interval:g} s, "
        f"{'with' if record.up is not None else 'without'} vertical component",
        *(f"  {_format_component_summary(c)}" for c in record_check.components),
        *(f"  {note}" for note in notes_for_check_report(record, record_check.components[0].sensor_position)),
        f"  north and east: {_format_pga_pgv_pgd(record_check.record_after_default_processing or record)}",
    ]
    return "\n".join(lines)


def _format_pga_pgv_pgd(processed_record: Record) -> str:
    """Return a text with PGA, PGV and PGD of north and east; PGD is in parentheses if the displacement drifts."""
    pga, pgv, pgd = (
        f"{100 * peak:.1f}"
        for peak in largest_pga_pgv_pgd_of_components(
            processed_record.horizontal_components, processed_record.sampling_interval
        ).values()
    )
    why = displacement_drift_evidence(processed_record)
    pgd, drifts = (f"({pgd})", f"\n  drift, so its PGD is none: {why}") if why else (pgd, "")
    steps = [processing_entry_text(step) for step in processed_record.processing if step["step"] != "common_window"]
    how = f"after the default processing ({', '.join(steps)})" if steps else "as the file is"
    return f"PGA {pga} Gal, PGV {pgv} cm/s, PGD {pgd} cm {how}{drifts}"


def notes_for_check_report(record: Record, sensor_position: str = "surface") -> list[str]:
    """Return notes on a record: agency processing, omitted parts, properties given by the user, contradictions."""
    done = record.extra.get("agency_processing")
    cut = [processing_entry_text(step) for step in record.processing if step["step"] == "common_window"]
    declared, trusted = (record.extra.get(key) or [] for key in ("declared", "trusted"))
    undeclared = sensor_position == "borehole" and "borehole sensor" not in declared
    how = "(--sensor borehole, or sensor in the record table)"
    return [
        *([f"by the agency: {done}"] if done else []),
        *cut,
        *([f"declared: {'; '.join(declared)}"] if declared else []),
        *record.notes,
        *([f"of a borehole: refused unless it is declared {how}"] if undeclared else []),
        *(f"trusted although {why}" for why in trusted),
    ]


def _format_component_summary(component: RecordComponent) -> str:
    """Return a text with the direction, length and peak of a component, and the peak that its header states."""
    sense = {1: "up", -1: "down", 0: "direction unknown"}[component.vertical_sense]
    direction = f"azimuth {component.azimuth_deg:g}" if component.azimuth_deg is not None else sense
    where = f" ({component.sensor_location})" if component.sensor_location else ""
    size = (
        f"{component.acceleration.size} samples, peak {peak_acceleration_comparable_to_header(component) * 100:.4g} Gal"
    )
    text = f"{component.axis_name_in_file}{where}: {direction}, {size}"
    peak = component.header_peak
    if peak is None:
        return text + ", header states none"
    difference = (
        abs(peak_acceleration_comparable_to_header(component) - peak.absolute_acceleration) / peak.absolute_acceleration
        if peak.absolute_acceleration
        else 0.0
    )
    return text + f", header {peak.absolute_acceleration * 100:.4g} Gal ({difference * 100:.2f} % apart)"
