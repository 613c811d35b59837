"""`python -m verification.stale`: the measured tables that are of other sources than today's, and what remakes them.

Each of `verification.registry.MEASURES` is measured within `measuring`, which keeps in verification/results/sources.csv
the hash of the sources it was measured with, its run time, and the machine.
"""

import ast
import hashlib
import os
import platform
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Final

import pandas as pd
import psutil
import typer
import yaml
from llvmlite.binding import get_host_cpu_features

from overturning.study import sources
from verification.registry import KERNEL, KERNELS, MEASURES, NO_MEASURE_HAS
from verification.tables import RESULTS, ROOT, alone, publish, wrapped, write_csv

KEPT: Final = "sources.csv"
NEVER: Final = ("__init__.py", "registry.py", "sentences.py", "stale.py", "summary.py", "tables.py")
"""Modules of this folder that lay figures out."""

WORDS: Final = ("name", "title", "question")
"""Keys of a study that no number depends on."""


def _canonical(node: Any) -> Any:
    """A syntax tree as text without what changes no number: comments, docstrings, annotations, messages, refusals."""
    if isinstance(node, ast.Raise):
        return "raise"
    if isinstance(node, ast.AST):
        # Empty fields are left out: which ones there are is another matter with each version of Python.
        fields = ((name, value) for name, value in ast.iter_fields(node) if value not in (None, []))
        left_out = {"returns", "kind", "type_comment"} | ({"annotation"} if isinstance(node, ast.arg) else set())
        return type(node).__name__, [(name, _canonical(value)) for name, value in fields if name not in left_out]
    if isinstance(node, list):
        return [_canonical(each) for each in node if not (_is_prose(each) or _is_refusal(each))]
    return repr(node)


def _is_prose(node: Any) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def _is_refusal(node: Any) -> bool:
    """Whether a statement raises an error or does nothing: what is not refused has the numbers it had without it."""
    if not isinstance(node, ast.If) or node.orelse or any(isinstance(part, ast.NamedExpr) for part in ast.walk(node)):
        return False
    return all(isinstance(each, ast.Raise) for each in node.body)


@cache
def _at(path: Path, function: str, _changed: int) -> bytes:
    return hashlib.sha256(repr(_canonical(sources.part_of(path, function))).encode()).digest()


def _of_file(path: Path, function: str = "") -> bytes:
    return _at(path, function, path.stat().st_mtime_ns)


def _counts(place: str, rooms: tuple[str, ...], kernels: tuple[str, ...]) -> bool:
    if place.startswith("verification/"):
        return Path(place).name not in NEVER
    inside = place.removeprefix("overturning/")
    if inside in NO_MEASURE_HAS or any(inside.startswith(f"dem/{kernel}/") for kernel in set(KERNELS) - set(kernels)):
        return False
    return any(inside == room or inside.startswith(f"{room}/") for room in rooms)


def source_hash(
    *names: str, rooms: tuple[str, ...] = KERNEL, kernels: tuple[str, ...] = KERNELS, inputs: tuple[str, ...] = ()
) -> str:
    """Hash, sixteen hexadecimal digits, of what modules are made of and of files that they read.

    Parameters
    ----------
    *names : str
        Of this folder or the package, as of `overturning.study.sources.sources_of`.
    rooms, kernels, inputs : tuple of str
        As of `Measure`.
    """
    here = ROOT / "verification"
    counted: dict[str, bytes] = {}
    for name in names:
        module, _, function = name.partition(":")
        first = "/".join(module.split(".")) + ".py"
        for path in sources.sources_of(name, here):
            place = path.relative_to(here.parent if path.is_relative_to(here) else sources.PACKAGE.parent).as_posix()
            if place == first:
                counted[f"{place}:{function}"] = _of_file(path, function)
            elif _counts(place, rooms, kernels):
                counted[place] = _of_file(path)
    counted |= {name: hashlib.sha256(_of_input(ROOT / name)).digest() for name in inputs}
    digest = hashlib.sha256()
    for place, content in sorted(counted.items()):
        digest.update(place.encode() + content)
    return digest.hexdigest()[:16]


def _of_input(path: Path) -> bytes:
    """What a file says: of a study its keys without its words, and its records' lines of the record table."""
    if path.suffix != ".yaml":
        return path.read_bytes()
    keys = yaml.safe_load(path.read_text(encoding="utf-8"))
    used = set(keys.get("records", {}).get("use", ()))
    table = (ROOT / "config" / "records.tsv").read_text(encoding="utf-8").splitlines()
    lines = [line for line in table if line.split("\t")[0] in used]
    return repr(({key: keys[key] for key in sorted(set(keys) - set(WORDS))}, lines)).encode()


def hash_of(name: str) -> str:
    """Hash of the sources and inputs of one of the `MEASURES`."""
    one = MEASURES[name]
    places = (one.source or name, *one.others)
    names = (place if place.startswith("overturning.") else f"verification.{place}" for place in places)
    return source_hash(*names, rooms=one.rooms, kernels=one.kernels, inputs=one.inputs)


def kept(results: Path = RESULTS) -> pd.DataFrame:
    """What is kept of each measure: `measure`, `sources`, `seconds` and `machine`."""
    path = results / KEPT
    columns = ["measure", "sources", "seconds", "machine"]
    return pd.read_csv(path, keep_default_na=False) if path.is_file() else pd.DataFrame(columns=columns)


VECTORS = {"avx512f": 512, "avx2": 256}
"""Width of a processor's vectors, bits, by what it has; the widest first."""


def machine() -> str:
    """The machine and what runs on it, in a line."""
    names = (line.partition(": ")[2] for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
             if line.startswith("model name"))  # fmt: skip
    model = next(names, platform.machine())
    memory = psutil.virtual_memory().total / 2**30
    system = platform.freedesktop_os_release()["PRETTY_NAME"]
    parts = (f"{name} {version(name.lower())}" for name in ("Numba", "llvmlite", "NumPy"))
    cores = len(os.sched_getaffinity(0))
    vectors = next((bits for name, bits in VECTORS.items() if get_host_cpu_features().get(name)), 128)
    hardware = f"{model}, {cores} cores, vectors of {vectors} bits, {memory:.0f} GiB"
    return f"{hardware}; {system}; Python {platform.python_version()}, {', '.join(parts)}"


def machines(results: Path = RESULTS) -> dict[str, str]:
    """On what the tables were measured, by its mark."""
    known = kept(results).groupby("machine", sort=True)["measure"].agg(list)
    measured = {name: of for name, of in known.items() if name}
    lines = [
        wrapped(f"{name}." if len(measured) == 1 else f"{name}: {', '.join(sorted(of))}.", "- ")
        for name, of in measured.items()
    ]
    return {"machine": "\n".join(lines)}


@contextmanager
def measuring(name: str, results: Path = RESULTS) -> Iterator[None]:
    """Measure one of the `MEASURES`: keep its hash, of the sources as they are at the begin, where it succeeds."""
    begin, found = time.monotonic(), hash_of(name)
    yield
    row = {"measure": name, "sources": found, "seconds": round(time.monotonic() - begin), "machine": machine()}
    with alone(results):
        old = kept(results)
        new = pd.concat([old[old["measure"] != name], pd.DataFrame([row])])
        write_csv(new.sort_values("measure"), results / KEPT)
    publish(machines(results), results.parents[1])


def stale(results: Path = RESULTS) -> list[str]:
    """The measures that are of other sources than today's, or of none that are known."""
    known = dict(kept(results)[["measure", "sources"]].to_numpy().tolist())
    return [name for name in MEASURES if known.get(name) != hash_of(name)]


def registered() -> set[str]:
    """Marks, files and drawings of all `MEASURES`."""
    return {*chain.from_iterable(one.results for one in MEASURES.values()), "machine", KEPT}


def commands_of(names: list[str], results: Path = RESULTS) -> list[str]:
    """A line for each command that remakes stale tables: what it makes, and what it took, s."""
    seconds = dict(kept(results)[["measure", "seconds"]].to_numpy().tolist())
    commands = dict.fromkeys(MEASURES[name].line for name in names)
    lines = []
    for command in commands:
        own = [name for name in names if MEASURES[name].line == command]
        made = ", ".join(dict.fromkeys(chain.from_iterable(MEASURES[name].results for name in own)))
        took = " + ".join(f"{seconds[name]} s" for name in own if name in seconds)
        lines.append(f"{command}{took and f'  # {took}'}\n    {made}")
    return lines


def main(
    check: Annotated[bool, typer.Option(help="fail where a table is stale")] = False,
) -> None:
    """List what is stale and the commands that remake it."""
    names = stale()
    print(*commands_of(names), sep="\n")
    print(f"{len(names)} of {len(MEASURES)} measures are of other sources than today's")
    if check and names:
        raise SystemExit(1)


if __name__ == "__main__":
    typer.run(main)
