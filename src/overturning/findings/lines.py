"""Findings as lines of text for a terminal: a name, a number and its interval."""

from collections.abc import Iterator
from typing import Any, Final

from pydantic import BaseModel

from overturning.findings.values import Estimate

_NAME_FIELDS: Final = ("group", "variant", "reference", "rule", "criterion", "predictor", "event", "degree", "inferred",
                 "id", "record", "element", "setting", "stones", "measure", "name", "b_over_h")  # fmt: skip
"""Fields that can label an entry of a list; the first one that the entry has is used."""

_JSON_ONLY_FIELDS: Final = frozenset(
    {"statistic", "versions", "sha256", "by_earthquake", "by_rule", "by_b_over_h_range", "by_record"}
)
"""Fields that are written to JSON but not printed as lines."""


def finding_lines(finding: BaseModel, path: str = "") -> Iterator[str]:
    """Yield a line "path of field names: value" for each number of a finding and its parts."""
    for name in type(finding).model_fields:
        if name not in _JSON_ONLY_FIELDS:
            yield from _value_lines(
                getattr(finding, name), f"{path}, {_field_label(name)}" if path else _field_label(name)
            )


def _field_label(name: str) -> str:
    """Replace underscores in a field name by spaces."""
    return name.replace("_", " ")


def _value_lines(value: Any, path: str) -> Iterator[str]:
    """Yield the lines of a field value: one line, or the lines of the parts of a model, dict or list."""
    if isinstance(value, Estimate):
        yield f"{path}: {_format_estimate(value)}"
    elif isinstance(value, BaseModel):
        yield from finding_lines(value, path)
    elif isinstance(value, dict):
        for key, one in value.items():
            yield from _value_lines(one, f"{path}, {key}")
    elif isinstance(value, list | tuple) and value and isinstance(value[0], BaseModel):
        for place, one in enumerate(value, 1):
            label = next(
                (str(getattr(one, name)) for name in _NAME_FIELDS if getattr(one, name, None) is not None), place
            )
            yield from _value_lines(one, f"{path}, {label}")
    elif value is not None and value not in ("", [], ()):
        yield f"{path}: {_format_value(value)}"


def _format_value(value: Any) -> str:
    """Format a number, flag, text or list for a line."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return ", ".join(map(_format_value, value))
    return f"{value:.4g}" if isinstance(value, float) else f"{value}"


def _format_estimate(estimate: Estimate) -> str:
    """Return an estimate with its interval and number of earthquakes."""
    if estimate.value is None:
        return f"not defined; {estimate.earthquakes} earthquakes"
    interval = (
        f" ({estimate.low:.3g} to {estimate.high:.3g})"
        if estimate.low is not None and estimate.high is not None
        else ""
    )
    count = f"{estimate.earthquakes} earthquake{'' if estimate.earthquakes == 1 else 's'}"
    return f"{estimate.value:.3g}{interval}; {count}{'' if interval else ', too few for an interval'}"
