"""A step runs again when a source changes that it depends on, and not when another one changes."""

from pathlib import Path

import pytest

from overturning.study import sources


def test_the_source_hash_of_a_step_covers_its_subpackages_and_top_level_modules(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sources, "PACKAGE_FOLDER", tmp_path)
    for name in ("top.py", "dem/kernel/step.py", "report/page.css", "report/notes.txt"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("1", encoding="utf-8")

    def change_file_and_report_changed_source_hashes(name: str) -> list[bool]:
        """Change a file and return whether the source hashes of the subpackages dem and report changed."""
        steps = (("dem",), ("report",))
        before = [sources.package_source_hash.__wrapped__(*one) for one in steps]
        (tmp_path / name).write_text("2", encoding="utf-8")
        return [old != sources.package_source_hash.__wrapped__(*one) for old, one in zip(before, steps, strict=True)]

    assert change_file_and_report_changed_source_hashes("dem/kernel/step.py") == [True, False]
    assert change_file_and_report_changed_source_hashes("report/page.css") == [False, True]
    assert change_file_and_report_changed_source_hashes("report/notes.txt") == [False, False]
    assert change_file_and_report_changed_source_hashes("top.py") == [True, True]


def test_a_source_hash_of_an_unknown_subpackage_is_refused() -> None:
    with pytest.raises(FileNotFoundError, match="nonsense"):
        sources.package_source_hash("nonsense")
