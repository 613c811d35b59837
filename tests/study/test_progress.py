import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from overturning.errors import ArgumentError
from overturning.study.progress import Progress, logged_to, overall, sweep_line


def test_time_to_go_is_read_off_the_share_done() -> None:
    states = [{"share": 1.0, "begin": 0.0}, {"share": 0.5, "begin": 0.0}]
    # Three eighths of four records after 30 s: five eighths need 50 s more.
    assert overall(states, 4, 30.0) == "sweep: 1 of 4 parts, 38%, 0:50 to go"


def test_records_of_an_earlier_run_are_no_speed_of_this_one() -> None:
    states = [{"share": 1.0, "begin": 0.0}, {"share": 0.5, "begin": 1000.0}]
    assert overall(states, 2, 1010.0) == "sweep: 1 of 2 parts, 75%, 0:10 to go"


def test_finished_sweep_has_nothing_to_go() -> None:
    assert overall([{"share": 1.0, "begin": 0.0}], 1, 5.0) == "sweep: 1 of 1 parts, 100%"


def test_log_gets_quiet_lines_and_the_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def job() -> None:
        with logged_to(tmp_path / "logs" / "one.log") as say, Progress(tmp_path / "parts", "one", 3, say) as progress:
            progress(1, 2)
            raise ArgumentError("height: -1 m; it must be above 0")

    with pytest.raises(ArgumentError):
        job()
    lines = (tmp_path / "logs" / "one.log").read_text(encoding="utf-8").splitlines()
    assert lines == ["one: begins", "error: height: -1 m; it must be above 0"]
    assert capsys.readouterr().err == ""  # not a terminal: nothing is drawn
    assert list((tmp_path / "parts" / ".progress").iterdir()) == []


def test_a_terminal_shows_the_whole_sweep_on_one_line(tmp_path: Path) -> None:
    program = (
        "from pathlib import Path\n"
        "from overturning.study.progress import Progress\n"
        f"with Progress(Path({str(tmp_path)!r}), 'one', 2, lambda line: None):\n"
        "    pass\n"
    )
    controller, terminal = pty.openpty()
    subprocess.run([sys.executable, "-c", program], stderr=terminal, check=True)
    os.close(terminal)
    shown = os.read(controller, 1000).decode()
    os.close(controller)
    assert shown == "\r\x1b[Ksweep: 1 of 2 parts, 50%"


def test_the_sweep_that_is_on(tmp_path: Path) -> None:
    folder = tmp_path / "mine" / "sweep" / "nominal" / ".progress"
    folder.mkdir(parents=True)
    assert sweep_line(tmp_path, 0.0) == ""
    (folder / "a").write_text('{"share": 1.0, "begin": 0.0, "parts": 4}', encoding="utf-8")
    assert sweep_line(tmp_path, 0.0) == "", "none is on"
    (folder / "b").write_text('{"share": 0.5, "begin": 0.0, "parts": 4}', encoding="utf-8")
    line = sweep_line(tmp_path, 0.0)
    assert line.startswith("sweep: 1 of 4 parts, 38%")
    assert line.endswith(" to go")
    assert sweep_line(tmp_path, 1e12) == "", "an earlier run"
    # What was cut into fewer parts before is left from then.
    (folder / "a").write_text('{"share": 1.0, "begin": 0.0, "parts": 2}', encoding="utf-8")
    assert sweep_line(tmp_path, 0.0).startswith("sweep: 1 of 4 parts, 38%")
