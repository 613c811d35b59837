"""Logger plugin of Snakemake: a progress line, the error messages of failed steps, and the results.

Snakemake finds the plugin by the name of this package; the default profile selects it. With ``--verbose`` and for
requests that compute nothing (`SNAKEMAKE_OPTIONS_WITHOUT_COMPUTATION`) the messages of Snakemake are shown instead.
All messages of Snakemake are in ``.snakemake/log`` in any case.
"""

import re
import shutil
import sys
import threading
from contextlib import suppress
from logging import WARNING, LogRecord
from pathlib import Path
from typing import Any, Final

from snakemake.common import NOTHING_TO_BE_DONE_MSG, get_appdirs
from snakemake.logging import ColorizingTextHandler, DefaultFilter, DefaultFormatter
from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent
from typing_extensions import override

from snakemake_logger_plugin_overturning.expected import RunProgressEstimate

SNAKEMAKE_OPTIONS_WITHOUT_COMPUTATION: Final = frozenset({
    "--lint", "--report", "--unlock", "--summary", "-D", "--detailed-summary", "--list", "-l", "--list-rules", "--dag",
    "--rulegraph", "--filegraph", "--list-changes", "-h", "--help",
})  # fmt: skip
"""Command-line options, apart from a dry run, with which Snakemake computes nothing."""

_TERMINAL_UPDATE_INTERVAL_S = 0.5  # s between updates of the progress line on a terminal
_LOG_UPDATE_INTERVAL_S = 60.0  # s between progress lines if there is no terminal
# Messages that are not printed: the reason for a failure is in the log of the step.
_HIDDEN_MESSAGES = (
    "CalledProcessError",
    "At least one job did not complete successfully",
    "Exiting because a job execution failed",
)
_MIN_FREE_DISK_BYTES = 1_000_000  # bytes of free disk space; with less, a step cannot even write its error message
_USER_STOP_MESSAGE = "Terminating processes on user request"
_RESUME_HINT = "finished results are kept, and the same command resumes the run"


class LogHandler(LogHandlerBase):
    """Handler of Snakemake's events, which arrive in a separate thread; it prints the messages that a user needs."""

    writes_to_stream, writes_to_file, needs_rulegraph = True, False, False
    has_filter = has_formatter = True  # Snakemake must neither filter nor format the messages

    def __post_init__(self) -> None:
        about = self.common_settings
        self._snakemake: ColorizingTextHandler | None = None
        if about.verbose or about.dryrun or SNAKEMAKE_OPTIONS_WITHOUT_COMPUTATION & set(sys.argv):
            out = sys.stdout if about.stdout else sys.stderr
            self._snakemake = ColorizingTextHandler(
                about.nocolor, out, DefaultFormatter(about.quiet, about.show_failed_logs)
            )
            self._snakemake.addFilter(
                DefaultFilter(about.quiet, about.debug_dag, about.verbose, about.dryrun, about.printshellcmds)
            )
        self._expected = RunProgressEstimate()
        self._failures: dict[str, None] = {}
        self._stopped = False
        self._ended = threading.Event()
        self._drawing: threading.Thread | None = None
        self._first_figure: Path | None = None  # to be named on the terminal once the file exists

    @override
    def emit(self, record: LogRecord) -> None:
        if self._snakemake is not None:
            self._snakemake.handle(record)
            return
        about: dict[str, Any] = vars(record)
        event, text = about.get("event"), str(record.msg or "")
        self._update_progress_line_data(event, about)
        if self._stopped:  # Snakemake reports stopped jobs as failed
            return
        if event == LogEvent.JOB_ERROR:
            self._print_failure_once_and_keep_for_run_end(
                _last_error_message_in_step_log(about["rule_name"], about["log"])
            )
        elif event == LogEvent.GROUP_ERROR:
            for job in about["job_error_info"]:
                self._print_failure_once_and_keep_for_run_end(
                    _last_error_message_in_step_log(job["rule_name"], job["log"])
                )
        elif text.startswith(_USER_STOP_MESSAGE):
            self._stopped = True
            self._clear_progress_line_and_print(f"Stopped; {_RESUME_HINT}.")
        elif any(words in text for words in _HIDDEN_MESSAGES):
            return
        elif event == LogEvent.ERROR:
            self._print_failure_once_and_keep_for_run_end(f"error: {_snakemake_error_without_code_positions(text)}")
        elif record.levelno >= WARNING:
            self._clear_progress_line_and_print(text)
        elif text == NOTHING_TO_BE_DONE_MSG or "result" in about:
            self._clear_progress_line_and_print(text, sys.stdout)

    @override
    def close(self) -> None:
        """Stop and clear the progress line; repeat the messages of all failures, if any."""
        self._ended.set()
        if self._drawing is not None:
            self._drawing.join()
            self._clear_progress_line()
        # Repeat the failures at the end, where a user sees them.
        if self._expected.total_job_count and self._failures and not self._stopped:
            self._clear_progress_line_and_print(
                f"The run failed; all messages of Snakemake are in .snakemake/log; {_RESUME_HINT}."
            )
            for text in self._failures:
                self._clear_progress_line_and_print(text)
        self._failures.clear()
        super().close()

    def _update_progress_line_data(self, event_kind: Any, event_data: dict[str, Any]) -> None:
        """Update the data of the progress line from an event."""
        if "expected_s" in event_data:
            self._expected.expected_job_seconds_by_rule = event_data["expected_s"]
            figure = Path(event_data["first_figure"])
            self._first_figure = None if figure.is_file() else figure
        elif event_kind == LogEvent.RESOURCES_INFO and ("cores" in event_data or "nodes" in event_data):
            self._expected.parallel_job_count = int(event_data.get("cores") or event_data.get("nodes") or 1)
        elif event_kind == LogEvent.RUN_INFO:
            self._expected.store_run_start_and_job_counts(
                {rule: count for rule, count in event_data["stats"].items() if rule != "total"}
            )
            self._drawing = threading.Thread(target=self._redraw_progress_line_until_end, daemon=True)
            self._drawing.start()
        elif event_kind == LogEvent.JOB_INFO:
            name = " ".join([event_data["rule_name"], *map(str, event_data["wildcards"].values())])
            logs, size = (
                [Path(log) for log in event_data["log"]],
                _first_input_size_over_folder_mean(event_data["input"]),
            )
            self._expected.store_job_start(event_data["jobid"], event_data["rule_name"], name, logs, size)
        elif event_kind in (LogEvent.JOB_FINISHED, LogEvent.JOB_ERROR):
            well = event_kind == LogEvent.JOB_FINISHED
            self._expected.store_job_end(event_data["job_id" if well else "jobid"], well)
            if self._first_figure is not None and self._first_figure.is_file():
                self._clear_progress_line_and_print(f"First polar map: {self._first_figure}")
                self._first_figure = None

    def _print_failure_once_and_keep_for_run_end(self, failure_message: str) -> None:
        """Print a message of failure once, and keep it to be repeated at the end of the run."""
        if failure_message not in self._failures:
            self._failures[failure_message] = None
            self._clear_progress_line_and_print(failure_message)

    def _clear_progress_line_and_print(self, text: str, output_stream: Any = None) -> None:
        """Clear the progress line and print a text, by default to the standard error stream."""
        self._clear_progress_line()
        print(text, file=output_stream or sys.stderr, flush=True)

    def _redraw_progress_line_until_end(self) -> None:
        """Print the progress line at intervals until the run ends; replace it in place on a terminal."""
        on_terminal = sys.stderr.isatty()
        while not self._ended.wait(_TERMINAL_UPDATE_INTERVAL_S if on_terminal else _LOG_UPDATE_INTERVAL_S):
            line = self._expected.progress_line()
            if on_terminal:
                self._clear_progress_line()
                width = shutil.get_terminal_size().columns
                print(line[: width - 1], end="", file=sys.stderr, flush=True)
            else:
                print(line, file=sys.stderr, flush=True)

    def _clear_progress_line(self) -> None:
        if sys.stderr.isatty():
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


def _first_input_size_over_folder_mean(input_files: list[str]) -> float:
    """Return the size of a job's first input file over the mean of its folder's files of this type; 1 if unknown."""
    with suppress(OSError, IndexError, ZeroDivisionError):
        first = Path(str(input_files[0]))
        sizes = [path.stat().st_size for path in first.parent.glob(f"*{first.suffix}")]
        return first.stat().st_size * len(sizes) / sum(sizes)
    return 1.0


def _last_error_message_in_step_log(rule_name: str, log_files: list[str]) -> str:
    """Return the last "error: …" message in the log of a failed step; without one, the last line of the log."""
    for log in log_files:
        lines = [line for line in _read_log_lines(Path(log)) if line.strip()]
        begins = [index for index, line in enumerate(lines) if line.startswith("error: ")]
        if begins:
            after = lines[begins[-1] + 1 :]
            ends = next((index for index, line in enumerate(after) if not line.startswith("       ")), len(after))
            return "\n".join([lines[begins[-1]], *after[:ends]])
        if lines:
            return f"error: {lines[-1].strip()} (see {log})"
        if Path(log).is_file() and shutil.disk_usage(log).free < _MIN_FREE_DISK_BYTES:
            return (
                f"error: {log}: no space left on device; free some space and run again; nothing half-written was kept"
            )
    return f"error: the step {rule_name} failed without a message" + "".join(f"; see {log}" for log in log_files[:1])


def _snakemake_error_without_code_positions(text: str) -> str:
    """Return an error message of Snakemake without the file names and line numbers of the workflow's code."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("  File ")]
    if text.startswith("Traceback"):
        lines = lines[-1:]
        if lines[0].startswith("FileNotFoundError") and lines[0].endswith(".yaml'"):
            there = ", ".join(sorted(map(str, Path("config").glob("*.yaml")))) or "none"
            return f"no study {lines[0].split(chr(39))[-2]}; existing studies: {there}"
        if unwritable := re.search(r"Error: \[Errno \d+\] (.*): '(/[^']*)'$", lines[0]):
            reason, path = unwritable.groups()
            cache = Path(get_appdirs().user_cache_dir)  # Snakemake makes it before it reads the workflow
            if cache.is_relative_to(path) or Path(path).is_relative_to(cache):
                return (
                    f"{path}: {reason}; Snakemake needs the cache folder {cache}: set HOME or XDG_CACHE_HOME to a "
                    "folder that can be written"
                )
    first = re.sub(r"^\w+(?: in file .*, line \d+)?:\s*", "", lines[0]) if lines else ""
    return "\n".join(([first] if first else []) + lines[1:])


def _read_log_lines(path: Path) -> list[str]:
    """Return the lines of a log file; [] if it cannot be read."""
    with suppress(OSError):
        return path.read_text(encoding="utf-8", errors="replace").splitlines()
    return []
