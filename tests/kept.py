"""Answers that are kept: what a layer finds for made-up input, and has to find again.

Closed forms and properties have tests of their own. These ask whether anything is another number than it was: "the
same cells give the same bits on your machine as on any other" (docs/tutorial.md), and from one version to the next. A
number that changes is a change of results: say it in CHANGELOG.md, and keep the new ones by ``python -m tests.kept``,
or of one layer by ``python -m tests.kept dem``.
"""

import importlib
import json
import math
import sys
from collections.abc import Callable, Mapping
from contextlib import chdir
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

ROOT = Path(__file__).parents[1]
LAYERS = ("dem",)
TOLERANCE = 1e-9
"""Of numbers, by the largest of their row: libm differs between processors in the last digit."""
MOST = 6
"""Numbers of an array that are kept one by one; a longer one is kept as its size and sums."""

Answers = dict[str, Callable[[], Mapping[str, Any]]]
"""What to ask, by name: each finds values by theirs."""


def plain(value: Any) -> Any:
    """A value as JSON has it: an array of more than `MOST` numbers by its size, what is missing in it, and sums.

    The weights of two of them differ from place to place, so that no numbers can be exchanged; the last is of sizes.
    """
    if isinstance(value, xr.Dataset | xr.DataArray):
        variables = value.variables if isinstance(value, xr.Dataset) else {"values": value.variable, **value.coords}
        value = {name: one.to_numpy() for name, one in variables.items()}
    if is_dataclass(value) and not isinstance(value, type):
        value = {item.name: getattr(value, item.name) for item in fields(value)}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, float):
        return float(f"{value:.12g}")
    if isinstance(value, str | bool | int | None):
        return value
    if isinstance(value, tuple | list | set) and not all(isinstance(one, int | float | np.number) for one in value):
        return [plain(one) for one in (sorted(value) if isinstance(value, set) else value)]
    values = np.asarray(value)
    if values.dtype.kind not in "biufc":
        return values.astype(str).tolist() if values.dtype.kind in "OUS" else str(value)
    if values.dtype.kind == "c":
        values = np.stack([values.real, values.imag], axis=-1)
    numbers = values.astype(np.float64).ravel()
    if numbers.size <= MOST:
        return [plain(one) for one in numbers.tolist()] if values.ndim else plain(numbers.item())
    known, places = np.isfinite(numbers), np.arange(numbers.size)
    weights = [1.0 + places % 7, 1.0 + (places * places) % 11]
    sums = [math.fsum((weight * numbers)[known].tolist()) for weight in weights]
    size, gaps = " × ".join(map(str, values.shape)), int((places * ~known).sum())
    return {"size": size, "gaps": gaps, "sums": plain([*sums, math.fsum(np.abs(numbers[known]).tolist())])}


def differences(now: Any, kept: Any, where: str = "") -> list[str]:
    """What is not as it is kept, a line each."""
    if isinstance(now, dict) and isinstance(kept, dict):
        names = dict.fromkeys([*kept, *now])
        return [line for name in names for line in differences(now.get(name), kept.get(name), f"{where}/{name}")]
    if isinstance(now, list) and isinstance(kept, list) and len(now) == len(kept):
        numbers = [abs(x) for x in kept if isinstance(x, int | float) and math.isfinite(x)]
        return [
            line for a, b in zip(now, kept, strict=True) for line in _unlike(a, b, where, max(numbers, default=0.0))
        ]
    return _unlike(now, kept, where)


def _unlike(now: Any, kept: Any, where: str, largest: float = 0.0) -> list[str]:
    if isinstance(now, dict | list) or isinstance(kept, dict | list):
        same = type(now) is type(kept) and not differences(now, kept)
    elif isinstance(now, float) and isinstance(kept, float):
        near = math.isclose(now, kept, rel_tol=TOLERANCE, abs_tol=TOLERANCE * largest)
        same = near or (math.isnan(now) and math.isnan(kept))
    else:
        same = now == kept
    return [] if same else [f"{where}: {now}, kept is {kept}"]


def file_of(layer: str) -> Path:
    return ROOT / "tests" / layer / "kept.json"


def check(layer: str, name: str, answers: Answers) -> None:
    """Compare what is found now with what is kept."""
    kept = json.loads(file_of(layer).read_text(encoding="utf-8"))
    assert list(answers) == list(kept), f"python -m tests.kept {layer}"
    with chdir(ROOT):  # from where scenes and tables are named
        found = differences(plain(answers[name]()), kept[name])
    assert found == [], f"{len(found)} values differ; are they meant to? See tests/kept.py"


def keep(layer: str) -> None:
    """Write what is found now."""
    answers: Answers = importlib.import_module(f"tests.{layer}.answers").ANSWERS
    rows = []
    for name, ask in answers.items():
        with chdir(ROOT):
            values = plain(ask())
        lines = (f"  {json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in values.items())
        rows.append(f"{json.dumps(name)}: {{\n" + ",\n".join(lines) + "\n}")
    file_of(layer).write_text("{\n" + ",\n".join(rows) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    for layer in sys.argv[1:] or LAYERS:
        keep(layer)
