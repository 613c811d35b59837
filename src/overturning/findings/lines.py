"""Findings as lines of text for a terminal: a name, a number and its interval."""

from collections.abc import Iterator, Sequence
from typing import Any, Final

from pydantic import BaseModel

from overturning.findings.values import Estimate

_ENTRY_LABEL_FIELDS: Final = (
    "id", "record_group", "variant", "reference", "rule", "criterion", "predictor", "event", "jma_degree",
    "inferred_jma_degree", "record", "element", "more_exact_computation_kind", "stone_class", "survey_file_name",
    "measure",
    "intensity_measure", "name", "b_over_h", "site", "status", "doubt", "doubled_quantity", "motion_name",
    "first_criterion",
    "share_or_median_name", "azimuth_deg", "motion_azimuth_deg",
)  # fmt: skip
"""Fields that can label an entry of a list; the first one that differs between all entries is used, otherwise all."""

_JSON_ONLY_FIELDS: Final = frozenset(
    {"statistic", "software_versions", "sha256", "by_earthquake", "by_rule", "by_b_over_h_range", "by_record"}
)
"""Fields that are written to JSON but not printed as lines."""


def finding_text_lines(finding: BaseModel, text_before_field: str = "") -> Iterator[str]:
    """Yield a line "field, subfield: value" for each value in a (nested) part of the report's numbers.

    `text_before_field` is the text before the first field.
    """
    for name in type(finding).model_fields:
        if name not in _JSON_ONLY_FIELDS:
            yield from _text_lines_of_field_value(
                getattr(finding, name),
                f"{text_before_field}, {_field_name_with_spaces(name)}"
                if text_before_field
                else _field_name_with_spaces(name),
            )


def _field_name_with_spaces(field_name: str) -> str:
    """Return the name of a field as printed: underscores are replaced by spaces."""
    return field_name.replace("_", " ")


def _text_lines_of_field_value(field_value: Any, field_label_with_parents: str) -> Iterator[str]:
    """Yield a line for each number in the value of a field; each line begins with `field_label_with_parents`.

    The value may be a model, dict or list.
    """
    if isinstance(field_value, Estimate):
        yield f"{field_label_with_parents}: {_format_estimate(field_value)}"
    elif isinstance(field_value, BaseModel):
        yield from finding_text_lines(field_value, field_label_with_parents)
    elif isinstance(field_value, dict):
        for key, one in field_value.items():
            yield from _text_lines_of_field_value(one, f"{field_label_with_parents}, {key}")
    elif isinstance(field_value, list | tuple) and field_value and isinstance(field_value[0], BaseModel):
        for label, one in zip(_distinct_entry_labels(field_value), field_value, strict=True):
            yield from _text_lines_of_field_value(one, f"{field_label_with_parents}, {label}")
    elif field_value is not None and field_value not in ("", [], ()):
        yield f"{field_label_with_parents}: {_format_value(field_value)}"


def _distinct_entry_labels(list_entries: Sequence[BaseModel]) -> list[str]:
    """Return a label for each list entry: its value of the first name field in which all entries differ.

    Name fields are `_ENTRY_LABEL_FIELDS`. If no field differs between all entries, a label joins the values of all
    these fields; labels are numbered if some are still equal.
    """
    columns = [[getattr(one, name, None) for one in list_entries] for name in _ENTRY_LABEL_FIELDS]
    texts = [["" if value is None else _format_value(value) for value in column] for column in columns]
    known = [column for column in texts if any(column)]
    together = [", ".join(filter(None, row)) for row in zip(*known, strict=True)] or [""] * len(list_entries)
    numbered = [f"{text} {place}".strip() for place, text in enumerate(together, 1)]
    distinct = (column for column in [*known, together] if all(column) and len(set(column)) == len(column))
    return next(distinct, numbered)


def _format_value(field_value: Any) -> str:
    """Format a number, True or False, text or a list of these for printing."""
    if isinstance(field_value, bool):
        return "yes" if field_value else "no"
    if isinstance(field_value, list | tuple):
        return ", ".join(map(_format_value, field_value))
    return f"{field_value:.4g}" if isinstance(field_value, float) else f"{field_value}"


def _format_estimate(estimate: Estimate) -> str:
    """Format an estimate for printing: its value, its interval and its number of earthquakes."""
    count = f"{estimate.earthquake_count} earthquake{'' if estimate.earthquake_count == 1 else 's'}"
    if estimate.value is None:
        return f"not defined; {count}"
    interval = (
        f" ({estimate.low:.3g} to {estimate.high:.3g})"
        if estimate.low is not None and estimate.high is not None
        else ""
    )
    return f"{estimate.value:.3g}{interval}; {count}{'' if interval else ', too few for an interval'}"
