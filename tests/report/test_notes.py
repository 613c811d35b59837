"""Notes on records from a file to the report: clipped samples, drift, contradictions that were trusted."""

from pathlib import Path

import numpy as np
import pytest

from overturning.findings.collect import Findings
from overturning.findings.processing import (
    DRIFT_DOUBT_KIND,
    TRUSTED_CONTRADICTION_DOUBT_KIND,
    DoubtsAboutRecordData,
    processing_finding_of_record,
)
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.read import read_record_without_processing
from overturning.records.record import Record, processing_peaks_and_notes_of_record
from overturning.report.page import render_report_html_page
from overturning.report.render import (
    LANGUAGES,
    parse_markdown_and_number_figures_and_tables,
    read_label_translations,
    render_template_as_markdown,
    translate_whole_text_by_table,
)
from overturning.report.terminal import plain_text_of_uncollapsed_paragraphs
from tests.report.by_hand import RECORD_FINDING, STUDY_FINDINGS
from tests.report.test_rendering import elements_of_well_formed_page

RECORD_TIME = np.arange(2000) / 100.0
NORTH_WAVE = np.sin(2 * np.pi * 0.7 * RECORD_TIME + 0.3) * np.exp(-(((RECORD_TIME - 8.0) / 3.0) ** 2))
EAST_WAVE = np.sin(2 * np.pi * 1.3 * RECORD_TIME) * np.exp(-(((RECORD_TIME - 8.0) / 3.0) ** 2))


def write_and_read_record_with_north(path: Path, north: np.ndarray, trust_data: bool = False) -> Record:
    """Write a file with columns of time, north and east, read it with declared columns, and return the record."""
    np.savetxt(path, np.column_stack([RECORD_TIME, north, EAST_WAVE]), fmt="%.9g", delimiter=",")
    given = DeclaredFileProperties(columns="time:s north:m/s2 east:m/s2", processed=True, trust_data=trust_data)
    return read_record_without_processing(path, given)


def markdown_report_on_record(record: Record, language: str) -> str:
    """Return the Markdown of a report on one record."""
    processing = processing_finding_of_record(processing_peaks_and_notes_of_record(record))
    doubts = [{"doubt": one, "record_count": 1, "records": ["vale"]} for one in processing.doubts]
    notes = DoubtsAboutRecordData.model_validate({"record_count_with_notes_or_doubts": 1, "doubts": doubts})
    parts = {"records": [RECORD_FINDING | {"processing": processing}], "record_notes": notes}
    return render_template_as_markdown(Findings.model_validate(STUDY_FINDINGS["direction"] | parts), language)


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_names_a_clipped_component_and_its_clipped_samples(tmp_path: Path, language: str) -> None:
    clipped = np.clip(2.0 * NORTH_WAVE, -1.0, 1.0)
    runs = np.split(clipped, np.flatnonzero(np.diff(clipped)) + 1)
    count = sum(run.size for run in runs if abs(run[0]) == 1.0 and run.size >= 3)
    assert count > 10
    text = markdown_report_on_record(write_and_read_record_with_north(tmp_path / "x.csv", clipped), language)
    page = render_report_html_page(parse_markdown_and_number_figures_and_tables(text), "title", language, None, {})
    elements_of_well_formed_page(page)
    (item,) = (one for one in page.split("<li>") if "clipped:" in one)
    assert item.startswith("vale")
    assert f"axis 'north' is clipped: {count} samples stand at its rail, 100 Gal".replace("'", "&#x27;") in item
    unfolded = plain_text_of_uncollapsed_paragraphs(parse_markdown_and_number_figures_and_tables(text))
    assert any(
        translate_whole_text_by_table("clipped samples", read_label_translations(language)) in one for one in unfolded
    )


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_names_drift_and_trusted_contradictions_of_a_record(tmp_path: Path, language: str) -> None:
    drifting = write_and_read_record_with_north(tmp_path / "x.csv", NORTH_WAVE + 0.003)
    assert DRIFT_DOUBT_KIND in processing_finding_of_record(processing_peaks_and_notes_of_record(drifting)).doubts
    text = markdown_report_on_record(drifting, language)
    assert {"en": "velocity of north ends at", "ja": "北方向の速度が最後に最大値の"}[language] in text
    assert translate_whole_text_by_table(DRIFT_DOUBT_KIND, read_label_translations(language)) in text
    dead = write_and_read_record_with_north(tmp_path / "y.csv", 1e-9 * NORTH_WAVE, trust_data=True)
    assert processing_finding_of_record(processing_peaks_and_notes_of_record(dead)).doubts == [
        TRUSTED_CONTRADICTION_DOUBT_KIND
    ]
    text = markdown_report_on_record(dead, language)
    assert "north\\' is dead" in text
    assert translate_whole_text_by_table(TRUSTED_CONTRADICTION_DOUBT_KIND, read_label_translations(language)) in text
