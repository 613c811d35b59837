from pathlib import Path

import pytest

from overturning.errors import ArgumentError
from overturning.study import progress
from overturning.study.progress import logged_to, percents


def test_log_gets_per_cents_and_the_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([0.0, 0.5, 1.2, 1.3, 3.0, 4.0])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))

    def job() -> None:
        with logged_to(tmp_path / "logs" / "one.log") as say:
            note = percents(say)
            for done in (10, 25, 26, 26, 500):
                note(done, 1000)
            raise ArgumentError("height: -1 m; it must be above 0")

    with pytest.raises(ArgumentError):
        job()
    lines = (tmp_path / "logs" / "one.log").read_text(encoding="utf-8").splitlines()
    assert lines == ["2%", "50%", "error: height: -1 m; it must be above 0"]
    assert capsys.readouterr().err == ""
