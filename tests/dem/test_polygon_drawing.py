"""The drawing of nearest faces in the docs is what its script draws today."""

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_the_drawing_is_the_scripts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spec = importlib.util.spec_from_file_location("draw_nearest_faces", ROOT / "docs" / "draw_nearest_faces.py")
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    committed = script.IMAGE.read_bytes()
    monkeypatch.setattr(script, "IMAGE", tmp_path / "drawn.svg")
    script.main()
    assert (tmp_path / "drawn.svg").read_bytes() == committed
