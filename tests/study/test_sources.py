"""A step runs again when a source changes that it depends on, and not when another one changes."""

from pathlib import Path

import pytest

from overturning.study import sources


def test_the_source_hash_of_a_step_covers_its_subpackages_and_top_level_modules(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sources, "PACKAGE", tmp_path)
    for name in ("top.py", "dem/kernel/step.py", "report/page.css", "report/notes.txt"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("1", encoding="utf-8")

    def changed(name: str) -> list[bool]:
        """For each of two steps, return True if its hash changes when a file changes."""
        steps = (("dem",), ("report",))
        before = [sources.package_source_hash.__wrapped__(*one) for one in steps]
        (tmp_path / name).write_text("2", encoding="utf-8")
        return [old != sources.package_source_hash.__wrapped__(*one) for old, one in zip(before, steps, strict=True)]

    assert changed("dem/kernel/step.py") == [True, False]
    assert changed("report/page.css") == [False, True]
    assert changed("report/notes.txt") == [False, False]
    assert changed("top.py") == [True, True]


def test_a_source_hash_of_an_unknown_subpackage_is_refused() -> None:
    with pytest.raises(FileNotFoundError, match="nonsense"):
        sources.package_source_hash("nonsense")
