"""What Snakemake says, read for its user: how far a run is, what failed, what was made."""

import re
from collections.abc import Iterator
from pathlib import Path

_STEPS = re.compile(r"^(\d+) of (\d+) steps \(\d+%\) done", re.MULTILINE)
_FAILED = re.compile(r"^Error in (?:local)?rule (\w+).*\n((?:    .*\n)+)", re.MULTILINE)
_LOG = re.compile(r"^    log: (\S+)", re.MULTILINE)
_STOPPED = re.compile(r"^WorkflowError.*\n((?:(?!  File |\s*$).*\n?)+)", re.MULTILINE)
_MADE = re.compile(r"^Cube and report of the study .*\n(?:  .*\n?)*", re.MULTILINE)
_DAMAGED = re.compile(r"^damaged, is made again: .*$", re.MULTILINE)
_IDLE = re.compile(r"^Nothing to be done.*$", re.MULTILINE)


def steps(talk: str) -> tuple[int, int] | None:
    """Steps that are done, and all of them; None as long as it is not known."""
    found = _STEPS.findall(talk)
    return (int(found[-1][0]), int(found[-1][1])) if found else None


def failures(talk: str) -> Iterator[str]:
    """The errors of a run in the words of the steps themselves, each once."""
    seen = set()
    for rule, about in _FAILED.findall(talk):
        log = _LOG.search(about)
        text = _own_words(Path(log[1])) if log else ""
        text = text or f"error: the step {rule} failed without a word" + (f"; see {log[1]}" if log else "")
        if text not in seen:
            seen.add(text)
            yield text
    if not seen:
        yield from (f"error: {text.strip()}" for text in dict.fromkeys(_STOPPED.findall(talk)))


def damaged(talk: str) -> list[str]:
    """Results that are made again because they were damaged."""
    return _DAMAGED.findall(talk)


def _own_words(log: Path) -> str:
    """The error at the end of a step's log with the lines that belong to it; of a traceback its last line."""
    lines = (
        [line for line in log.read_text(encoding="utf-8", errors="replace").splitlines() if line.strip()]
        if log.is_file()
        else []
    )
    begins = [index for index, line in enumerate(lines) if line.startswith("error: ")]
    if not begins:
        return f"error: {lines[-1].strip()} (see {log})" if lines else ""
    kept = [lines[begins[-1]]]
    for line in lines[begins[-1] + 1 :]:
        if not line.startswith("       "):
            break
        kept.append(line)
    return "\n".join(kept)


def made(talk: str) -> str:
    """What a run ends with: what it made, or that nothing was to be done."""
    found = _MADE.search(talk) or _IDLE.search(talk)
    return found[0].rstrip() if found else ""
