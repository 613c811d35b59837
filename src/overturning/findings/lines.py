"""Findings as lines of text for a terminal: a name, a number and its interval."""

from collections.abc import Iterator
from typing import Any, Final

from pydantic import BaseModel

from overturning.findings.values import Estimate

_NAMES: Final = ("group", "variant", "reference", "rule", "criterion", "predictor", "event", "degree", "inferred",
                 "id", "record", "element", "setting", "stones", "measure", "name", "b_over_h")  # fmt: skip
"""Fields that name the entries of a list, the first that an entry has."""

_LEFT_OUT: Final = frozenset({"statistic", "versions", "sha256", "by_earthquake", "by_rule", "by_range", "by_record"})
"""Fields that are in the JSON only."""


def finding_lines(found: BaseModel, path: str = "") -> Iterator[str]:
    """Yield a line for each number of findings, with its path of names."""
    for name in type(found).model_fields:
        if name not in _LEFT_OUT:
            yield from _lines(getattr(found, name), f"{path}, {_spoken(name)}" if path else _spoken(name))


def _spoken(name: str) -> str:
    return name.replace("_", " ")


def _lines(value: Any, path: str) -> Iterator[str]:
    """Yield the lines of a value: of its parts, of its entries, or its own."""
    if isinstance(value, Estimate):
        yield f"{path}: {_estimate(value)}"
    elif isinstance(value, BaseModel):
        yield from finding_lines(value, path)
    elif isinstance(value, dict):
        for key, one in value.items():
            yield from _lines(one, f"{path}, {key}")
    elif isinstance(value, list | tuple) and value and isinstance(value[0], BaseModel):
        for place, one in enumerate(value, 1):
            label = next((str(getattr(one, name)) for name in _NAMES if getattr(one, name, None) is not None), place)
            yield from _lines(one, f"{path}, {label}")
    elif value is not None and value not in ("", [], ()):
        yield f"{path}: {_plain(value)}"


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return ", ".join(map(_plain, value))
    return f"{value:.4g}" if isinstance(value, float) else f"{value}"


def _estimate(one: Estimate) -> str:
    """Return an estimate with its interval and number of earthquakes."""
    if one.value is None:
        return f"not defined; {one.earthquakes} earthquakes"
    interval = f" ({one.low:.3g} to {one.high:.3g})" if one.low is not None and one.high is not None else ""
    count = f"{one.earthquakes} earthquake{'' if one.earthquakes == 1 else 's'}"
    return f"{one.value:.3g}{interval}; {count}{'' if interval else ', too few for an interval'}"
