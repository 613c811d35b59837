"""What a run of the workflow says: one line of progress, failures in the words of the steps, and what was made.

A logger plugin of Snakemake, which finds it by the name of this package; the default profile chooses it. With
``--verbose`` and for requests that compute nothing (`LOOKS`) Snakemake speaks for itself. All that it says is in
``.snakemake/log`` in any case.
"""

import re
import shutil
import sys
import threading
from contextlib import suppress
from logging import WARNING, LogRecord
from pathlib import Path
from typing import Any, Final

from snakemake.common import NOTHING_TO_BE_DONE_MSG
from snakemake.logging import ColorizingTextHandler, DefaultFilter, DefaultFormatter
from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

from snakemake_logger_plugin_overturning.expected import Expected

LOOKS: Final = frozenset({
    "--lint", "--report", "--unlock", "--summary", "-D", "--detailed-summary", "--list", "-l", "--list-rules", "--dag",
    "--rulegraph", "--filegraph", "--list-changes", "-h", "--help",
})  # fmt: skip
"""Requests beside a dry run that compute nothing."""

_REDRAWN = 0.5  # s, between two looks at how far the run is
_WORD = 60.0  # s, between two lines of progress where there is no terminal
# A step that fails says why in its log.
_UNSAID = (
    "CalledProcessError",
    "At least one job did not complete successfully",
    "Exiting because a job execution failed",
)
_LITTLE = 1_000_000  # bytes; on a disk with less a step cannot even write why it failed
_STOPPED = "Terminating processes on user request"
_GOES_ON = "finished results are kept, and the same command goes on from here"


class LogHandler(LogHandlerBase):
    """Takes Snakemake's events, which arrive in a thread of their own, and says what a user needs to know."""

    writes_to_stream, writes_to_file, needs_rulegraph = True, False, False
    has_filter = has_formatter = True  # it chooses by itself, and has words of its own

    def __post_init__(self) -> None:
        about = self.common_settings
        self._snakemake: ColorizingTextHandler | None = None
        if about.verbose or about.dryrun or LOOKS & set(sys.argv):
            out = sys.stdout if about.stdout else sys.stderr
            self._snakemake = ColorizingTextHandler(
                about.nocolor, out, DefaultFormatter(about.quiet, about.show_failed_logs)
            )
            self._snakemake.addFilter(
                DefaultFilter(about.quiet, about.debug_dag, about.verbose, about.dryrun, about.printshellcmds)
            )
        self._expected = Expected()
        self._failures: dict[str, None] = {}
        self._stopped = False
        self._ended = threading.Event()
        self._drawing: threading.Thread | None = None

    def emit(self, record: LogRecord) -> None:
        """Take note of an event, and say what is to be said of it."""
        if self._snakemake is not None:
            self._snakemake.handle(record)
            return
        about: dict[str, Any] = vars(record)
        event, text = about.get("event"), str(record.msg or "")
        self._take_note(event, about)
        if self._stopped:  # jobs that were stopped have failed, for Snakemake
            return
        if event == LogEvent.JOB_ERROR:
            self._say_failure(_words_of_step(about["rule_name"], about["log"]))
        elif event == LogEvent.GROUP_ERROR:
            for job in about["job_error_info"]:
                self._say_failure(_words_of_step(job["rule_name"], job["log"]))
        elif text.startswith(_STOPPED):
            self._stopped = True
            self._say(f"Stopped; {_GOES_ON}.")
        elif any(words in text for words in _UNSAID):
            return
        elif event == LogEvent.ERROR:
            self._say_failure(f"error: {_without_places(text)}")
        elif record.levelno >= WARNING:
            self._say(text)
        elif text == NOTHING_TO_BE_DONE_MSG or "result" in about:
            self._say(text, sys.stdout)

    def close(self) -> None:
        """Take the line of progress away; where something failed, say it once more, last, where it is seen."""
        self._ended.set()
        if self._drawing is not None:
            self._drawing.join()
            self._clear()
        if self._expected.steps and self._failures and not self._stopped:
            self._say(f"The run failed; all that Snakemake says is in .snakemake/log; {_GOES_ON}.")
            for text in self._failures:
                self._say(text)
        self._failures.clear()
        super().close()

    def _take_note(self, event: Any, about: dict[str, Any]) -> None:
        """What the line of progress is made of."""
        if "expected_s" in about:
            self._expected.seconds = about["expected_s"]
        elif event == LogEvent.RESOURCES_INFO and ("cores" in about or "nodes" in about):
            self._expected.at_once = int(about.get("cores") or about.get("nodes") or 1)
        elif event == LogEvent.RUN_INFO:
            self._expected.plan({rule: count for rule, count in about["stats"].items() if rule != "total"})
            self._drawing = threading.Thread(target=self._draw, daemon=True)
            self._drawing.start()
        elif event == LogEvent.JOB_INFO:
            name = " ".join([about["rule_name"], *map(str, about["wildcards"].values())])
            logs, size = [Path(log) for log in about["log"]], _relative_size(about["input"])
            self._expected.begin(about["jobid"], about["rule_name"], name, logs, size)
        elif event in (LogEvent.JOB_FINISHED, LogEvent.JOB_ERROR):
            well = event == LogEvent.JOB_FINISHED
            self._expected.end(about["job_id" if well else "jobid"], well)

    def _say_failure(self, text: str) -> None:
        if text not in self._failures:
            self._failures[text] = None
            self._say(text)

    def _say(self, text: str, where: Any = None) -> None:
        self._clear()
        print(text, file=where or sys.stderr, flush=True)

    def _draw(self) -> None:
        on_terminal = sys.stderr.isatty()
        while not self._ended.wait(_REDRAWN if on_terminal else _WORD):
            line = self._expected.line()
            if on_terminal:
                self._clear()
                width = shutil.get_terminal_size().columns
                print(line[: width - 1], end="", file=sys.stderr, flush=True)
            else:
                print(line, file=sys.stderr, flush=True)

    def _clear(self) -> None:
        if sys.stderr.isatty():
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


def _relative_size(inputs: list[str]) -> float:
    """Size of the first file that a job reads, for instance a motion, over the mean of those of its kind beside it."""
    with suppress(OSError, IndexError, ZeroDivisionError):
        first = Path(str(inputs[0]))
        sizes = [path.stat().st_size for path in first.parent.glob(f"*{first.suffix}")]
        return first.stat().st_size * len(sizes) / sum(sizes)
    return 1.0


def _words_of_step(rule: str, logs: list[str]) -> str:
    """The error at the end of a step's log with the lines that belong to it; of a traceback its last line."""
    for log in logs:
        lines = [line for line in _lines(Path(log)) if line.strip()]
        begins = [index for index, line in enumerate(lines) if line.startswith("error: ")]
        if begins:
            after = lines[begins[-1] + 1 :]
            ends = next((index for index, line in enumerate(after) if not line.startswith("       ")), len(after))
            return "\n".join([lines[begins[-1]], *after[:ends]])
        if lines:
            return f"error: {lines[-1].strip()} (see {log})"
        if Path(log).is_file() and shutil.disk_usage(log).free < _LITTLE:
            return (
                f"error: {log}: no space left on device; free some space and run again; nothing half-written was kept"
            )
    return f"error: the step {rule} failed without a word" + "".join(f"; see {log}" for log in logs[:1])


def _without_places(text: str) -> str:
    """An error of Snakemake's without the places in the workflow's files where it came about."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("  File ")]
    if text.startswith("Traceback"):
        lines = lines[-1:]
        if lines[0].startswith("FileNotFoundError") and lines[0].endswith(".yaml'"):
            there = ", ".join(sorted(map(str, Path("config").glob("*.yaml")))) or "none"
            return f"no study {lines[0].split(chr(39))[-2]}; there are {there}"
    first = re.sub(r"^\w+(?: in file .*, line \d+)?:\s*", "", lines[0]) if lines else ""
    return "\n".join(([first] if first else []) + lines[1:])


def _lines(path: Path) -> list[str]:
    with suppress(OSError):
        return path.read_text(encoding="utf-8", errors="replace").splitlines()
    return []
