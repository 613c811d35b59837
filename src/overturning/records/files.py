"""Read the components of files and archives, each in the format of its content."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import PurePosixPath
from typing import Final

from overturning.errors import RecordError, RecordRefusalReasonCollector
from overturning.records.component import RecordComponent
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.formats.table import (
    NO_ACCELERATION_REASON,
    RecordFileFormat,
    detect_format,
    find_format_by_name_or_none_if_auto,
    has_known_format,
    holds_no_acceleration,
)
from overturning.records.source import NON_RECORD_EXTENSIONS, SourceFile, is_archive, unpack_archive

ARCHIVE_EXTENSIONS_SKIPPED_IF_FORMAT_UNKNOWN: Final = frozenset(("csv", "doc", "docx", "txt", "xls", "xlsx"))
"""Extensions of tables and texts that agencies add to an archive of records, such as `_SearchResults.csv` of PEER."""


def read_components(
    files_and_archives: Iterable[SourceFile], user_declared_properties: DeclaredFileProperties
) -> list[RecordComponent]:
    """Read all components from files and archives; the format of each file is detected from its content.

    Files of plain number columns need columns declared by the user. StationXML among the files is passed to the readers
    that need it. Raises a RecordError for a file of unknown format, or of another format than declared.
    """
    files_and_archives = list(files_and_archives)
    packed = list(_unpacked_files_with_their_archives(files_and_archives))
    user_declared_properties = user_declared_properties.with_station_xml_from_files(member for member, _ in packed)
    named = find_format_by_name_or_none_if_auto(
        "csv" if user_declared_properties.columns else user_declared_properties.format
    )
    is_csv = named is not None and named.name == "csv"
    components: list[RecordComponent] = []
    left_out: dict[SourceFile, str] = {}
    tables: list[SourceFile] = []
    reasons = RecordRefusalReasonCollector()
    for member, file in packed:
        in_archive = member is not file
        if member in user_declared_properties.stationxml_files:
            continue
        if in_archive and (member.extension in NON_RECORD_EXTENSIONS or holds_no_acceleration(member)):
            left_out[member] = NO_ACCELERATION_REASON
        elif in_archive and not is_csv and _is_table_of_unknown_format(member):
            tables.append(member)
        else:
            with reasons.suppress_record_error_and_keep_reasons():
                components += _read_file_components(member, named, user_declared_properties)
    # A table or a letter that comes with the records has another extension than they have.
    records = {PurePosixPath(one.file_name).suffix.lower().lstrip(".") for one in components}
    for member in tables:
        if records and member.extension not in records:
            left_out[member] = "its format is not recognised"
        else:
            with reasons.suppress_record_error_and_keep_reasons():
                _read_file_components(member, named, user_declared_properties)
    with reasons.suppress_record_error_and_keep_reasons():
        if left_out and not components:
            why = "none of the archive's members is an accelerogram: get the file that holds one"
            raise RecordError(f"{next(iter(left_out)).name}: {why}")
        if files_and_archives and not any(
            member not in user_declared_properties.stationxml_files for member, _ in packed
        ):
            what = "StationXML alone" if packed else "an archive without files"
            raise RecordError(
                f"{' '.join(file.name for file in files_and_archives)}: {what}; name the file of a record, too"
            )
    reasons.raise_collected_reasons()
    return _drop_raw_versions_and_add_omission_notes(components, packed, left_out)


def _unpacked_files_with_their_archives(
    files_and_archives: Iterable[SourceFile],
) -> Iterator[tuple[SourceFile, SourceFile]]:
    """Yield pairs of a file and the archive that it is unpacked from; a file outside archives is paired with itself."""
    for file in files_and_archives:
        for member in unpack_archive(file) if is_archive(file.data) else [file]:
            yield member, file


def _is_table_of_unknown_format(archive_member: SourceFile) -> bool:
    """Return True if an archive member has the extension of a table (such as .csv) but no known record format."""
    return archive_member.extension in ARCHIVE_EXTENSIONS_SKIPPED_IF_FORMAT_UNKNOWN and not has_known_format(
        archive_member
    )


def _read_file_components(
    source_file: SourceFile,
    required_format_or_none: RecordFileFormat | None,
    user_declared_properties: DeclaredFileProperties,
) -> list[RecordComponent]:
    """Read the components of one file in the required format, or, if None is required, in the detected format."""
    if not source_file.data.strip(b"\0 \r\n\t"):
        raise RecordError(f"{source_file.name}: the file is empty; get it again")
    if (
        required_format_or_none is not None
        and required_format_or_none.name != "csv"
        and not required_format_or_none.matches_file(source_file)
    ):
        raise RecordError(
            f"{source_file.name}: not a {required_format_or_none.title} file; check `format` in the record table"
        )
    return (required_format_or_none or detect_format(source_file)).read_components(
        source_file, user_declared_properties
    )


def _drop_raw_versions_and_add_omission_notes(
    components: Sequence[RecordComponent],
    pairs_of_file_and_archive: Sequence[tuple[SourceFile, SourceFile]],
    omission_reason_by_file: Mapping[SourceFile, str],
) -> list[RecordComponent]:
    """Drop raw components that their archive also holds processed; add notes on omitted files to the others.

    Agencies deliver a record in up to three volumes: raw (1), processed (2), spectra (3).
    """
    archive = {member.sha256: file for member, file in pairs_of_file_and_archive if member is not file}
    raw, processed = (
        [c for c in components if c.sha256 in archive and c.is_already_corrected is kind] for kind in (False, True)
    )
    twice = [
        one
        for one in raw
        if any(archive[o.sha256] is archive[one.sha256] and _are_versions_of_same_component(one, o) for o in processed)
    ]
    said = [(c.file_name, "the same is there processed") for c in twice]
    said += [
        (file.name, why) for file, why in omission_reason_by_file.items() if file.extension not in NON_RECORD_EXTENSIONS
    ]
    kept = [c for c in components if not any(c is other for other in twice)]
    return [_copy_with_omission_notes(c, said) if c.sha256 in archive else c for c in kept]


def _copy_with_omission_notes(
    component: RecordComponent, names_and_reasons_of_omitted_files: Sequence[tuple[str, str]]
) -> RecordComponent:
    """Return a copy of a component with notes on omitted files: those with the stem of its file, or else all."""
    own = [
        one
        for one in names_and_reasons_of_omitted_files
        if one[0].partition(".")[0] == component.file_name.partition(".")[0]
    ]
    notes = [f"{name} left out: {why}" for name, why in dict.fromkeys(own or names_and_reasons_of_omitted_files)]
    return replace(component, notes=(*component.notes, *notes))


def _are_versions_of_same_component(first_component: RecordComponent, second_component: RecordComponent) -> bool:
    """Return True if two components have the same format, axis direction, station, sensor location and earthquake."""
    same = ("format_name", "station", "event", "sensor_location", "sensor_position", "azimuth_deg", "vertical_sense")
    return all(getattr(first_component, name) == getattr(second_component, name) for name in same)
