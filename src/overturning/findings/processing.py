"""Origin, processing and notes of each record of a study, and the doubts about its data."""

from collections.abc import Mapping
from typing import Any, Final

from overturning.findings.results import StudyResults
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.records.doubts import NOTE_PHRASE_BY_DATA_PROBLEM, data_problem_kinds_in_notes
from overturning.records.record import processing_entry_text
from overturning.study.cube import record_sources_and_processing_by_id

DRIFT_DOUBT_KIND: Final = "a velocity or displacement that drifts"
"""Kind of doubt about a record whose velocity does not end near 0, or whose displacement is largest at its end."""

TRUSTED_CONTRADICTION_DOUBT_KIND: Final = "contradictions that were trusted"
"""Kind of doubt about a record that was read in spite of contradictions of its header and its data."""


class RecordProcessing(FindingBaseClass):
    """Source of a record's data, the processing by agency and program, and all notes about the data."""

    data_processing_state: str
    """"raw", "raw, response of a velocity sensor removed", "processed", "processed, as declared", or "as given"."""
    processing_agency: str
    """Agency that processed the data; empty if it is not known."""
    agency_processing: str
    """Processing by the agency, as its file states it; may be empty."""
    steps: list[str]
    """Processing steps of the study, with their parameters."""
    first_sample_time: str
    """Time of the first sample, ISO 8601 in UTC; empty if it is not known."""
    duration_s: OptionalNumberOrInfinity
    """Duration of the processed record, s."""
    pga_before_m_s2: OptionalNumberOrInfinity
    """Larger peak acceleration of north and east before the steps."""
    pga_after_m_s2: OptionalNumberOrInfinity
    """Larger peak acceleration of north and east after the steps."""
    pgv_before_m_s: OptionalNumberOrInfinity
    """Larger peak velocity of north and east before the steps."""
    pgv_after_m_s: OptionalNumberOrInfinity
    """Larger peak velocity of north and east after the steps."""
    pgd_before_m: OptionalNumberOrInfinity
    """Larger peak displacement of north and east before the steps."""
    pgd_after_m: OptionalNumberOrInfinity
    """Larger peak displacement of north and east after the steps."""
    user_declared_properties: list[str]
    """Properties of the record that the user declared because its files do not state them."""
    contradictions_trusted_by_user: list[str]
    """Contradictions of header and data in spite of which the user trusts the record."""
    notes: list[str]
    """Notes on how the record was read: omitted or resampled parts, clipped samples, other doubts."""
    drift_evidence: str
    """Evidence that velocity or displacement drifts, so that the peak displacement is not the ground's; or empty."""
    doubts: list[str]
    """Kinds of doubts about the data that may affect results, such as "clipped samples"."""


class RecordsWithOneKindOfDataDoubt(FindingBaseClass):
    """Records with one kind of doubt about their data, such as clipped samples."""

    doubt: str
    """Kind of doubt, such as "clipped samples"."""
    record_count: int
    """Number of these records."""
    records: list[str]
    """Identifiers of these records."""


class DoubtsAboutRecordData(FindingBaseClass):
    """Number of records with notes on their data, and the records with each kind of doubt."""

    record_count_with_notes_or_doubts: int
    """Number of records with something declared or trusted, a note, or a drift."""
    doubts: list[RecordsWithOneKindOfDataDoubt]
    """Records with each kind of doubt about the data; kinds without a record are left out."""


def processing_finding_of_record(record_source_and_processing: Mapping[str, Any]) -> RecordProcessing:
    """Return the report's entry on the source and processing of one record.

    Parameters
    ----------
    record_source_and_processing : mapping
        Return value of `overturning.records.record.processing_peaks_and_notes_of_record`.
    """
    data, _, agency = str(record_source_and_processing["data"]).partition(" by ")
    peaks = {
        name: dict(zip(("before", "after"), pair, strict=True))
        for name, pair in record_source_and_processing["peaks"].items()
    }
    notes, trusted, drift = (
        list(record_source_and_processing.get("notes", ())),
        list(record_source_and_processing["trusted"]),
        record_source_and_processing["drift"],
    )
    return RecordProcessing(
        data_processing_state=data,
        processing_agency=agency,
        agency_processing=record_source_and_processing["agency"],
        steps=[processing_entry_text(step) for step in record_source_and_processing["steps"]],
        first_sample_time=record_source_and_processing["start"],
        duration_s=record_source_and_processing["duration_s"],
        pga_before_m_s2=peaks["pga"]["before"],
        pga_after_m_s2=peaks["pga"]["after"],
        pgv_before_m_s=peaks["pgv"]["before"],
        pgv_after_m_s=peaks["pgv"]["after"],
        pgd_before_m=peaks["pgd"]["before"],
        pgd_after_m=peaks["pgd"]["after"],
        user_declared_properties=list(record_source_and_processing["declared"]),
        contradictions_trusted_by_user=trusted,
        notes=notes,
        drift_evidence=drift,
        doubts=[
            *data_problem_kinds_in_notes(notes),
            *([DRIFT_DOUBT_KIND] if drift else []),
            *([TRUSTED_CONTRADICTION_DOUBT_KIND] if trusted else []),
        ],
    )


def source_processing_and_notes_by_record_id(results: StudyResults) -> dict[str, RecordProcessing]:
    """Return source, processing and notes of each record, by record id, as far as the results state them."""
    return {
        name: processing_finding_of_record(provenance)
        for name, provenance in record_sources_and_processing_by_id(results.reference_element_cube).items()
    }


def summarise_record_notes_and_doubts(
    processing_by_record_id: Mapping[str, RecordProcessing | None],
) -> DoubtsAboutRecordData:
    """Count the records with notes on their data, and list the records with each kind of doubt."""
    known = {name: one for name, one in processing_by_record_id.items() if one is not None}
    named = {
        kind: [name for name, one in known.items() if kind in one.doubts]
        for kind in (*NOTE_PHRASE_BY_DATA_PROBLEM, DRIFT_DOUBT_KIND, TRUSTED_CONTRADICTION_DOUBT_KIND)
    }
    return DoubtsAboutRecordData(
        record_count_with_notes_or_doubts=sum(
            bool(one.user_declared_properties or one.contradictions_trusted_by_user or one.notes or one.drift_evidence)
            for one in known.values()
        ),
        doubts=[
            RecordsWithOneKindOfDataDoubt(doubt=kind, record_count=len(doubtful), records=doubtful)
            for kind, doubtful in named.items()
            if doubtful
        ],
    )
