"""Run a study, also after an earlier run was killed: unlock the folder if no other run is alive, then go on.

Snakemake leaves its lock behind when it is killed and refuses the next run; and its jobs may outlive it.
"""

import subprocess
import sys
from pathlib import Path

import psutil

_PROGRAMS = ("snakemake", "overturning")


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


def main() -> int:
    """Unlock where it is safe and hand over to Snakemake."""
    folder = Path.cwd().resolve()
    locks = folder / ".snakemake" / "locks"
    if locks.is_dir() and any(locks.iterdir()):
        others = alive(folder)
        if others:
            print(
                f"error: another run works in this folder (process {others[0].pid}); wait for it, or stop it and run again",
                file=sys.stderr,
            )
            return 1
        print("An earlier run was killed; its finished results are kept.", file=sys.stderr)
        subprocess.run(["snakemake", "--unlock", *sys.argv[1:]], check=True, capture_output=True)
    return subprocess.run(["snakemake", *sys.argv[1:]], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
