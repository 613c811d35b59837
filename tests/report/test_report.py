"""The report of a tiny study on the page and on paper."""

import json
import re
from pathlib import Path

from overturning.report.write import write_report
from overturning.study.recheck import recompute_and_compare_random_cases
from overturning.study.schema import Study
from tests.expect import skip_test_unless_skipping_is_forbidden


def test_report_language_argument_overrides_that_of_study(
    results_with_hostile_names: Path, report_page_and_pdf: tuple[str, bytes], study_in_japanese: Study, tmp_path: Path
) -> None:
    page, pdf = tmp_path / "again.html", tmp_path / "again.pdf"
    write_report(results_with_hostile_names, page, pdf, study_in_japanese, language="en")
    assert (page.read_text(encoding="utf-8"), pdf.read_bytes()) == report_page_and_pdf
    assert report_page_and_pdf[1].startswith(b"%PDF")


def test_report_page_loads_no_external_file_and_escapes_scripts_in_names(
    report_page_and_pdf: tuple[str, bytes],
) -> None:
    page, _ = report_page_and_pdf
    assert "<script>window.hurt" not in page
    assert "&lt;script&gt;window.hurt" in page
    # The page names only the page next to it, and works without it.
    assert set(re.findall(r'(?:src|href)="(?!#|data:)([^"#]*)', page)) == {"explore.html"}
    for script in re.findall(r'<script type="application/json">(.*?)</script>', page, flags=re.DOTALL):
        json.loads(script)


def test_report_is_written_in_the_language_of_the_study(
    report_page_and_pdf: tuple[str, bytes], japanese_report_page_and_pdf: tuple[str, bytes]
) -> None:
    page, pdf = japanese_report_page_and_pdf
    assert '<html lang="ja">' in page
    assert "<b>図1.</b>" in page
    assert '<html lang="en">' in report_page_and_pdf[0]
    if not pdf:
        skip_test_unless_skipping_is_forbidden(
            "no Japanese font (Debian package fonts-noto-cjk): the PDF is not written"
        )
    assert pdf.startswith(b"%PDF")


def test_recheck_reproduces_unchanged_results_and_detects_changed_outcomes(
    results_with_hostile_names: Path, tmp_path: Path
) -> None:
    found = recompute_and_compare_random_cases(results_with_hostile_names / "cube.nc", max_random_case_count=40)
    assert found.values_are_identical_and_hash_is_correct
    assert found.recomputed_cell_count == 40
    assert found.cell_count_with_recomputed_ensemble > 0
    changed = tmp_path / "cube.nc"
    changed.write_bytes((results_with_hostile_names / "cube.nc").read_bytes())
    from netCDF4 import Dataset

    with Dataset(changed, "a") as file:
        file.set_auto_maskandscale(False)
        file["overturned"][:] = 1 - file["overturned"][:]
    spoilt = recompute_and_compare_random_cases(
        changed, results_with_hostile_names / "motion", max_random_case_count=10
    )
    assert not spoilt.stored_values_match_content_hash
    assert len(spoilt.difference_messages) >= 5
    assert "overturned is" in spoilt.difference_messages[0]
