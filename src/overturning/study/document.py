"""The JSON schema and the key table, both made from the configuration model."""

import json
from pathlib import Path
from typing import Any

from overturning.records.catalogue import RecordEntry
from overturning.study.config import Study

_MARKS = {
    "keys": ("<!-- keys: made by `overturning study document`, do not edit -->", "<!-- end of keys -->"),
    "columns": ("<!-- columns: made by `overturning study document`, do not edit -->", "<!-- end of columns -->"),
}


def schema_text() -> str:
    """The JSON schema of a study file."""
    schema = Study.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def key_table() -> str:
    """The keys of a study file as a Markdown table: key, default, meaning."""
    schema = Study.model_json_schema()
    rows = ["| key | default | meaning |", "|---|---|---|"]
    for key, entry, required in _keys(schema, schema, ""):
        default = "needed" if required else f"`{json.dumps(entry.get('default'), ensure_ascii=False)}`"
        rows.append(f"| `{key}` | {default} | {entry.get('description', '')} |")
    return "\n".join(rows) + "\n"


def _resolve(schema: dict[str, Any], entry: dict[str, Any]) -> dict[str, Any]:
    if "$ref" in entry:
        return {**schema["$defs"][entry["$ref"].rpartition("/")[2]], **{k: v for k, v in entry.items() if k != "$ref"}}
    for form in entry.get("oneOf", ()):  # a word or settings: the keys are those of the settings
        if "$ref" in form:
            model = schema["$defs"][form["$ref"].rpartition("/")[2]]
            return {**model, **{key: value for key, value in entry.items() if key != "oneOf"}}
    return entry


def _keys(schema: dict[str, Any], model: dict[str, Any], prefix: str) -> list[tuple[str, dict[str, Any], bool]]:
    entries = []
    for name, raw in model.get("properties", {}).items():
        entry = _resolve(schema, raw)
        key, required = f"{prefix}{name}", name in model.get("required", [])
        below = entry.get("additionalProperties")
        if isinstance(below, dict):
            entries.append((key, {**entry, "default": entry.get("default", {})}, required))
            entries.extend(_keys(schema, _resolve(schema, below), f"{key}.NAME."))
        elif entry.get("properties"):
            entries.extend(_keys(schema, entry, f"{key}."))
        elif "$ref" in entry.get("items", {}):  # a list of settings
            entries.append((key, entry, required))
            entries.extend(_keys(schema, _resolve(schema, entry["items"]), f"{key}[]."))
        else:
            entries.append((key, entry, required))
    return entries


def column_table() -> str:
    """The columns of the record table as a Markdown table."""
    rows = ["| column | meaning |", "|---|---|"]
    for name, entry in RecordEntry.model_json_schema()["properties"].items():
        rows.append(f"| `{name}` | {entry.get('description', '')} |")
    return "\n".join(rows) + "\n"


def with_tables(text: str) -> str:
    """The text of a README with the tables put between their marks."""
    for table, (begin, end) in zip((key_table(), column_table()), _MARKS.values(), strict=True):
        before, _, rest = text.partition(begin)
        _, _, after = rest.partition(end)
        text = f"{before}{begin}\n{table}{end}{after}"
    return text


def write_documentation(folder: Path) -> None:
    """Write ``schema.json`` and the tables in ``README.md`` of a folder."""
    (folder / "schema.json").write_text(schema_text(), encoding="utf-8")
    readme = folder / "README.md"
    readme.write_text(with_tables(readme.read_text(encoding="utf-8")), encoding="utf-8")
