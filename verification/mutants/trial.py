"""A copy of the project in which one mutant after another is put to the tests."""

import ast
import hashlib
import json
import math
import os
import resource
import shutil
import signal
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from functools import cached_property
from itertools import accumulate
from pathlib import Path
from typing import Final

from overturning.study.sources import sources_of
from verification.mutants.drawing import LAYERS, Mutant
from verification.tables import ROOT

_COPIED: Final = ("src", "tests", "verification", "config", "workflow", "docs", "surveys")
_MEMORY: Final = 8 << 30  # bytes of address space of one run of the tests
_LEAST: Final = 120.0  # s that a run of the tests has in any case
_MOST: Final = 45.0  # s that the tests of a mutant usually take, at most: what only later ones would notice has lived
_SLOWER: Final = 4.0  # times as long as without a mutant: it hangs, or compiles its kernels anew
_LEFT_OUT: Final = ("tests/dem/test_cache.py", "tests/dem/test_cluster.py", "tests/dem/test_vector_code.py")
"""They ask where compiled kernels lie, which the plugin changes; begin processes of their own; or look at every variant
of the kernels' code."""


_PLUGIN: Final = '''\
"""Compiled kernels are kept by what they are made of, so that a mutant costs the kernels that it is in."""

import hashlib
import os
import signal
from pathlib import Path

import pytest

from overturning.dem.kernel import cache
from overturning.study.sources import sources_of

LONGEST = 90.0  # s of processor time of one test, its kernels compiled within: several times that of any
ROOMS = {"BlockRules": "block", "BodyRules": "body", "SceneRules": "polygon"}
_layers, _directory, _package = cache.sources_digest, cache.cache_directory, Path(cache.__file__).parents[2]
_queue, _kept = _package / "dem" / "kernel" / "queue.py", Path(os.environ["NUMBA_CACHE_DIR"])


def _of(files):
    return hashlib.sha256(b"".join(path.read_bytes() for path in sorted(set(files)))).hexdigest()[:16]


def _made_of(room):
    """What the queue is compiled with for the model of a folder; it imports none of it itself."""
    parts = sorted((_package / "dem" / room).glob("*.py"))
    return [*parts, *sources_of("overturning.dem.kernel.queue"), *sources_of(f"overturning.dem.{room}.rules")]


def _digest(sources):
    if sources == _queue:
        return "queue"
    if not (sources.suffix == ".py" and sources.is_relative_to(_package)):
        return _layers(sources)
    return _of(sources_of(".".join(("overturning", *sources.relative_to(_package).with_suffix("").parts))))


_own = {rules: _kept / f"{rules}-{_of(_made_of(room))}" for rules, room in ROOMS.items()}
_whole = _kept / _of([path for room in ROOMS.values() for path in _made_of(room)]) / "overturning-queue"


def _link(folder, other, pattern):
    other.mkdir(parents=True, exist_ok=True)
    for path in folder.glob(pattern):
        (other / path.name).unlink(missing_ok=True)
        os.link(path, other / path.name)


for _folder in _own.values():
    _link(_folder, _whole, "*")
cache.layer_of = lambda module: module if module.is_relative_to(_package) else module.parent
cache.sources_digest = _digest
cache.cache_directory = lambda sources=None: _whole if sources == _queue else _directory(sources)


def pytest_sessionfinish():
    for rules, folder in _own.items():
        _link(_whole, folder, f"*.{rules}.*")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config, items):
    """In the order in which the files are named."""
    places = {file: place for place, file in enumerate(config.args)}
    items.sort(key=lambda item: places[item.nodeid.partition("::")[0]])


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol():
    signal.setitimer(signal.ITIMER_PROF, LONGEST)  # its signal ends the process
'''


class Trial:
    """The copy, and the tests that look at each module, those that are likely to notice first.

    Parameters
    ----------
    folder : Path
        Where the copy, compiled kernels and the times of the tests are kept.
    """

    def __init__(self, folder: Path) -> None:
        self._tree, self._times_file = folder / "tree", folder / "times.json"
        shutil.rmtree(self._tree, ignore_errors=True)
        for name in _COPIED:
            shutil.copytree(ROOT / name, self._tree / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("pyproject.toml", "README.md", "CITATION.cff"):
            shutil.copy(ROOT / name, self._tree / name)
        (self._tree / "kernels_of_mutants.py").write_text(_PLUGIN, encoding="utf-8")
        self._turn = 0
        self._environment = os.environ | {
            "PYTHONPATH": f"{self._tree / 'src'}:{self._tree}",
            "NUMBA_CACHE_DIR": str(folder / "kernels"),
            "PYTHONPYCACHEPREFIX": str(folder / "bytecode"),
            "NUMBA_NUM_THREADS": "1",
        }

    def baseline(self) -> None:
        """Run the tests that are new or changed without a mutant, for their times; they must pass."""
        known = json.loads(self._times_file.read_text(encoding="utf-8")) if self._times_file.is_file() else {}
        files = sorted({file for files in self._seen_by.values() for file in files})
        states = {file: hashlib.sha256((self._tree / file).read_bytes()).hexdigest() for file in files}
        new = [file for file in files if known.get(file, {}).get("state") != states[file]]
        if not new:
            return
        report = self._times_file.with_suffix(".xml")
        passed, talk = self._tests(new, 3600, report)
        times: dict[str, float] = defaultdict(float)
        failed = set()
        for case in ElementTree.parse(report).iter("testcase"):
            file = case.attrib["classname"].replace(".", "/") + ".py"
            times[file] += float(case.attrib["time"])
            failed |= {file} if any(case.iter("failure")) or any(case.iter("error")) else set()
        known |= {file: {"state": states[file], "seconds": times[file]} for file in new if file not in failed}
        self._times_file.write_text(json.dumps(known), encoding="utf-8")
        if not passed:
            raise SystemExit(f"tests do not pass without a mutant:\n{talk[-2000:]}")

    @cached_property
    def _times(self) -> dict[str, float]:
        known = json.loads(self._times_file.read_text(encoding="utf-8"))
        return {file: one["seconds"] for file, one in known.items()}

    @cached_property
    def _seen_by(self) -> dict[str, list[str]]:
        """Tests of the layers by each module of their own that they reach, and of another layer that they import."""
        seen = defaultdict(list)
        for path in sorted((self._tree / "tests").rglob("test_*.py")):
            layer = path.parent.name
            if layer not in LAYERS:
                continue
            near = _imported(path)
            reached = {other for name in near for other in sources_of(name)}
            for other in reached:
                file = other.relative_to(ROOT / "src" / "overturning").as_posix()
                module = ".".join(("overturning", *Path(file).with_suffix("").parts))
                if layer == file.split("/")[0] or module in near:
                    seen[file].append(path.relative_to(self._tree).as_posix())
        return dict(seen)

    def tests_of(self, mutant: Mutant) -> list[str]:
        """Files of tests for a mutant, as many as usually take `_MOST`: those of its own layer first.

        Of these first what finds again what is kept, then what imports its module itself.
        """
        layer = mutant.file.split("/")[0]
        files = self._seen_by.get(mutant.file) or sorted(
            path.relative_to(self._tree).as_posix() for path in (self._tree / "tests" / layer).glob("test_*.py")
        )
        module = ".".join(("overturning", *Path(mutant.file).with_suffix("").parts))

        def order(file: str) -> tuple[bool, bool, bool, float]:
            own, itself = f"tests/{layer}/" in file, module in _imported(self._tree / file)
            return not own, not file.endswith("/test_kept.py"), not itself, self._times.get(file, 0.0)

        ordered = sorted(files, key=order)
        until = accumulate(self._times.get(file, 0.0) for file in ordered)
        return [file for file, seconds in zip(ordered, until, strict=True) if seconds <= _MOST] or ordered[:1]

    def notices(self, mutant: Mutant) -> bool:
        """Whether a test fails with the mutant in place; one that hangs has noticed it, too."""
        path = self._tree / "src" / "overturning" / mutant.file
        text = path.read_text(encoding="utf-8")
        files = self.tests_of(mutant)
        try:
            self._write(path, mutant.applied(text))
            usual = sum(self._times.get(file, 0.0) for file in files)
            return not self._tests(files, _LEAST + _SLOWER * usual)[0]
        finally:
            self._write(path, text)

    def _write(self, path: Path, text: str) -> None:
        """Write a module with a time of its own, so that no compiled one is taken for it."""
        path.write_text(text, encoding="utf-8")
        self._turn += 1
        os.utime(path, (2_000_000_000 + self._turn, 2_000_000_000 + self._turn))

    def _tests(self, files: list[str], seconds: float, report: Path | None = None) -> tuple[bool, str]:
        quick = ["-q", "-m", "not long", "-p", "no:xdist", "-p", "no:cacheprovider", "-p", "kernels_of_mutants"]
        quick += [word for test in _LEFT_OUT for word in ("--deselect", test)]
        quick += [f"--junitxml={report}"] if report else ["-x"]
        command = [sys.executable, "-m", "pytest", *quick, *files]
        process = subprocess.Popen(
            command,
            cwd=self._tree,
            env=self._environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
            preexec_fn=lambda: _limit(seconds),
        )
        try:
            talk, _ = process.communicate(timeout=10 * seconds)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            return False, "no end"
        return process.returncode == 0, talk


def _limit(seconds: float) -> None:
    """Bounds of one run of the tests: of its memory and of its own time, whatever else the processor has to do."""
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(seconds), math.ceil(seconds) + 1))


def _imported(path: Path) -> set[str]:
    """Modules of the package that a file imports itself, or from what lies beside it in the tests."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    files = {name: Path(*name.split(".")).with_suffix(".py") for name in names}
    beside = [ROOT / file for name, file in files.items() if name.startswith("tests.")]
    beside += [path.parent / file for file in files.values() if len(file.parts) == 1]
    return {
        name for name, file in files.items() if name.startswith("overturning.") and (ROOT / "src" / file).is_file()
    }.union(*(_imported(other) for other in beside if other.is_file()))
