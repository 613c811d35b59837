"""Run a study, also after an earlier run was killed: unlock the folder if no other run is alive, then go on.

Snakemake leaves its lock behind when it is killed and refuses the next run; and its jobs may outlive it. What it says goes
into a log, `.snakemake/run.log`; here stand one line of progress, errors in the words of the steps themselves, and what was made.
With VERBOSE=1 in the environment, and for requests that run nothing, Snakemake speaks for itself.
"""

import fcntl
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import pairwise
from pathlib import Path

import psutil

sys.path.insert(0, str(Path(__file__).parent))
from talk import failures, made, steps

_PROGRAMS = ("snakemake", "overturning")
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


def alive(folder: Path) -> list[psutil.Process]:
    """Runs and jobs that still work in a folder, this process and those it came from left out."""
    own = {psutil.Process().pid, *(parent.pid for parent in psutil.Process().parents())}
    found = []
    for process in psutil.process_iter():
        try:
            names = {Path(word).name for word in process.cmdline()[:3]}
            if process.pid not in own and names & set(_PROGRAMS) and Path(process.cwd()) == folder:
                found.append(process)
        except (psutil.Error, OSError):
            continue
    return found


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
def alone(folder: Path) -> Iterator[int | None]:
    """Hold the folder as long as this run lasts; yields the process that holds it already, where one does."""
    (folder / ".snakemake").mkdir(exist_ok=True)
    with (folder / ".snakemake" / "run.lock").open("a+") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.seek(0)
            yield int(lock.read() or 0)
            return
        lock.truncate(0)
        lock.write(str(os.getpid()))
        lock.flush()
        yield None


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


def follow(command: list[str]) -> int:
    """Run Snakemake, its talk in the log; say how far it is, and each failure when it comes about."""
    _TALK.parent.mkdir(exist_ok=True)
    said: set[str] = set()
    begin = shown = time.time()
    with _TALK.open("w", encoding="utf-8") as talk:
        process = subprocess.Popen(command, stdout=talk, stderr=subprocess.STDOUT)
        try:
            while True:
                code = process.poll()
                text = _TALK.read_text(encoding="utf-8", errors="replace")
                for line in failures(text):
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
    """Unlock where it is safe and hand over to Snakemake."""
    folder, arguments = Path.cwd().resolve(), sys.argv[1:]
    if problem := fault(arguments):
        print(f"error: {problem}", file=sys.stderr)
        return 1
    with alone(folder) as holder:
        locks = folder / ".snakemake" / "locks"
        if holder is None and locks.is_dir() and any(locks.iterdir()):
            others = alive(folder)
            holder = others[0].pid if others else None
            if holder is None:
                print("An earlier run was killed; its finished results are kept.", file=sys.stderr)
                subprocess.run(["snakemake", "--unlock", *arguments], check=True, capture_output=True)
        if holder is not None:
            print(
                f"error: another run works in this folder (process {holder}); wait for it, or stop it and run again",
                file=sys.stderr,
            )
            return 1
        command = ["snakemake", *arguments]
        if os.environ.get("VERBOSE", "0") not in ("", "0") or _SPEAKS & set(arguments):
            return subprocess.run(command, check=False).returncode
        with cubes_kept():
            return follow(command)


if __name__ == "__main__":
    sys.exit(main())
