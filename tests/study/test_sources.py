from pathlib import Path

import pytest

from overturning.study import sources


def names(module: str) -> set[str]:
    return {path.stem for path in sources.sources_of(module)}


def test_imports_inside_functions_count() -> None:
    assert {"read", "store", "config"} <= names("overturning.commands.read")


def test_reading_does_not_depend_on_figures_nor_on_the_kernel() -> None:
    assert not {"polar", "kernel", "simulate", "page"} & names("overturning.commands.read")


def test_hash_follows_a_file_below(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.py").write_text("def f():\n    from overturning.b import g\n", encoding="utf-8")
    (tmp_path / "b.py").write_text("g = 1\n", encoding="utf-8")
    (tmp_path / "c.py").write_text("", encoding="utf-8")
    root = tmp_path.rename(tmp_path.with_name("overturning"))
    monkeypatch.setattr(sources, "_ROOT", root)
    before = sources.source_hash("overturning.a")
    (root / "c.py").write_text("other = 1\n", encoding="utf-8")
    assert sources.source_hash("overturning.a") == before
    (root / "b.py").write_text("g = 2\n", encoding="utf-8")
    assert sources.source_hash("overturning.a") != before


def test_unknown_module_is_refused() -> None:
    with pytest.raises(ValueError, match="no module"):
        sources.source_hash("overturning.commands.nonsense")
