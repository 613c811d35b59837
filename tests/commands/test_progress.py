"""Progress lines of a step."""

import pytest

from overturning.commands import workflow


def test_progress_is_printed_at_most_once_a_second_and_no_percent_twice(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([0.0, 0.5, 1.2, 1.3, 3.0, 4.0])
    monkeypatch.setattr(workflow.time, "monotonic", lambda: next(clock))
    progress = workflow._create_percent_progress_printer()
    for done in (10, 25, 26, 26, 500):
        progress(done, 1000)
    assert capsys.readouterr().err.splitlines() == ["2%", "50%"]
