from pathlib import Path

import pytest

from overturning.study import sources


def names(module: str) -> set[str]:
    return {path.stem for path in sources.sources_of(module)}


def test_imports_inside_functions_count() -> None:
    assert {"read", "store", "schema"} <= names("overturning.commands.workflow:read")


def test_reading_does_not_depend_on_figures_nor_on_the_kernel() -> None:
    assert not {"polar", "kernel", "simulate", "page"} & names("overturning.commands.workflow:read")


def test_hash_follows_a_file_below(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.py").write_text("def f():\n    from overturning.b import g\n", encoding="utf-8")
    (tmp_path / "b.py").write_text("g = 1\n", encoding="utf-8")
    (tmp_path / "c.py").write_text("", encoding="utf-8")
    root = tmp_path.rename(tmp_path.with_name("overturning"))
    monkeypatch.setattr(sources, "PACKAGE", root)
    before = sources.source_hash("overturning.a")
    (root / "c.py").write_text("other = 1\n", encoding="utf-8")
    assert sources.source_hash("overturning.a") == before
    (root / "b.py").write_text("g = 2\n", encoding="utf-8")
    assert sources.source_hash("overturning.a") != before


def test_a_step_does_not_depend_on_its_neighbours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = "def helper():\n    return 1\n\ndef f():\n    return helper()\n\ndef g():\n    from overturning.b import h\n"
    root = tmp_path / "overturning"
    (root / "sub").mkdir(parents=True)
    (root / "b.py").write_text("h = 1\n", encoding="utf-8")
    monkeypatch.setattr(sources, "PACKAGE", root)

    def hashes(text: str) -> list[str]:
        (root / "sub" / "a.py").write_text(text, encoding="utf-8")
        sources._imports.cache_clear()
        return [sources.source_hash(f"overturning.sub.a:{name}") for name in "fg"]

    before = hashes(text)
    for after, same in (
        (text.replace("import h", "import h as i"), [True, False]),
        (text.replace("return 1", "return 2"), [False, True]),
        ("import math\n" + text, [False, False]),
    ):
        assert [old == new for old, new in zip(before, hashes(after), strict=True)] == same
    with pytest.raises(ValueError, match="no function 'nonsense'"):
        sources.source_hash("overturning.sub.a:nonsense")


def test_unknown_module_is_refused() -> None:
    with pytest.raises(ValueError, match="no module"):
        sources.source_hash("overturning.commands.nonsense")
