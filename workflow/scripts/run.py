"""Run a study, also after an earlier run was killed: hold the folder, wait for what outlived that run, then go on.

What Snakemake says goes into a log, `.snakemake/run.log`; here stand one line of progress, errors in the words of the steps
themselves, and what was made. With VERBOSE=1 in the environment, and for requests that run nothing, Snakemake speaks for itself.
"""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import pairwise
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from talk import damaged, failures, made, steps

_TALK = Path(".snakemake") / "run.log"
_SPEAKS = {
    "-n",
    "--dry-run",
    "--dryrun",
    "--lint",
    "--report",
    "--unlock",
    "--summary",
    "--list",
    "--dag",
    "--rulegraph",
    "-h",
    "--help",
}
_LOOK = 0.5  # s, between two looks at how far the run is
_WORD = 60.0  # s, between two lines where there is no terminal


def fault(arguments: list[str]) -> str:
    """What keeps a run from beginning, in a sentence; empty where nothing does."""
    named = [word for option, word in pairwise(arguments) if option in ("--configfile", "--configfiles")]
    for name in named:
        if not Path(name).is_file():
            there = ", ".join(sorted(map(str, Path("config").glob("*.yaml")))) or "none"
            return f"no study {name}; there are {there}"
    folder = Path("results") if Path("results").exists() else Path()
    if not os.access(folder, os.W_OK | os.X_OK):
        return f"the folder {folder.resolve()} cannot be written to; run as its owner, or give it write permission"
    return ""


@contextmanager
def cubes_kept() -> Iterator[None]:
    """Put cubes back that a run has taken away and not made anew: Snakemake removes a result before it makes it again.

    They are as old as can be then, so that the next run makes them in any case.
    """
    links = {path: path.with_name(f".{path.name}.kept") for path in Path("results").glob("*/cube*.nc")}
    for left in Path("results").glob("*/.cube*.nc.kept"):  # by a run that was killed
        left.unlink()
    for path, link in links.items():
        with suppress(OSError):  # a file system without hard links
            os.link(path, link)
    try:
        yield
    finally:
        for path, link in links.items():
            if link.exists() and not path.exists():
                link.rename(path)
                os.utime(path, (0, 0))
            link.unlink(missing_ok=True)


def follow(command: list[str], held: list[int]) -> int:
    """Run Snakemake, its talk in the log; say how far it is, and each failure when it comes about."""
    _TALK.parent.mkdir(exist_ok=True)
    said: set[str] = set()
    begin = shown = time.time()
    with _TALK.open("w", encoding="utf-8") as talk:
        process = subprocess.Popen(command, stdout=talk, stderr=subprocess.STDOUT, pass_fds=held)
        try:
            while True:
                code = process.poll()
                text = _TALK.read_text(encoding="utf-8", errors="replace")
                for line in (*damaged(text), *failures(text)):
                    if line not in said:
                        said.add(line)
                        _clear()
                        print(line, file=sys.stderr, flush=True)
                if code is not None:
                    break
                if sys.stderr.isatty():
                    _clear()
                    print(_progress(text, begin), end="", file=sys.stderr, flush=True)
                elif time.time() - shown > _WORD:
                    shown = time.time()
                    print(_progress(text, begin), file=sys.stderr, flush=True)
                time.sleep(_LOOK)
        except KeyboardInterrupt:
            process.terminate()
            process.wait()
            _clear()
            print("Stopped; finished results are kept, and the same command goes on from here.", file=sys.stderr)
            return 130
    _clear()
    text = _TALK.read_text(encoding="utf-8", errors="replace")
    if code == 0:
        print(made(text) or f"Done; Snakemake's talk is in {_TALK}.")
        return 0
    print(
        f"The run failed; Snakemake's talk is in {_TALK}. The rest is kept, and the same command goes on from here.",
        file=sys.stderr,
    )
    for line in said or [text.strip().splitlines()[-1] if text.strip() else "error: Snakemake ended without a word"]:
        print(line, file=sys.stderr)
    return code


def _clear() -> None:
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)


def _progress(talk: str, begin: float) -> str:
    """One line: steps of the run, and the sweep that is on with its time to go."""
    from overturning.study.progress import sweep_line

    counted = steps(talk)
    line = f"{counted[0]} of {counted[1]} steps" if counted else "begins"
    sweep = sweep_line(Path("results"), begin)
    return f"{line}; {sweep}" if sweep else line


def main() -> int:
    """Hold the folder and hand over to Snakemake."""
    arguments = sys.argv[1:]
    if problem := fault(arguments):
        print(f"error: {problem}", file=sys.stderr)
        return 1
    from overturning.errors import ResultError
    from overturning.study.going_on import hold

    command = ["snakemake", *arguments]
    if _SPEAKS & set(arguments):
        return subprocess.run(command, check=False).returncode
    try:
        descriptor = hold(Path(".snakemake", "run.lock"))
    except ResultError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    # Snakemake has the lock, too, and keeps it should this process be killed.
    held = [] if descriptor is None else [descriptor]
    if os.environ.get("VERBOSE", "0") not in ("", "0"):
        return subprocess.run(command, check=False, pass_fds=held).returncode
    with cubes_kept():
        return follow(command, held)


if __name__ == "__main__":
    sys.exit(main())
