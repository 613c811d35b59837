"""Documentation of the study file, generated from its model: JSON schema, table of keys, and template."""

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from overturning.records.catalogue import RecordTableRow
from overturning.study.schema import Study


def study_json_schema_text() -> str:
    """Return the JSON schema of study files as text."""
    schema = Study.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


WORKFLOW_CATALOGUE_SCHEMA_PATH = Path("workflow") / "schemas" / "config.schema.yaml"
"""Path of the schema for the catalogue of Snakemake workflows."""


def study_json_schema_as_yaml_text() -> str:
    """Return the JSON schema of study files as text in YAML format."""
    import yaml

    text: str = yaml.safe_dump(json.loads(study_json_schema_text()), allow_unicode=True, sort_keys=False, width=120)
    return f"# Made by `overturning study document`, do not edit.\n{text}"


def _resolve_schema_reference(root_json_schema: dict[str, Any], schema_entry: dict[str, Any]) -> dict[str, Any]:
    """Return an entry of a JSON schema, with its reference (``$ref``) replaced by the definition it refers to."""
    optional = schema_entry.get("anyOf", ())
    forms = optional if len(optional) == 2 and optional[1] == {"type": "null"} else schema_entry.get("oneOf", ())
    for form in (schema_entry, *forms):  # text, settings or null: use the keys of the settings
        if "$ref" in form:
            model = root_json_schema["$defs"][form["$ref"].rpartition("/")[2]]
            return model | {key: value for key, value in schema_entry.items() if key not in ("$ref", "oneOf", "anyOf")}
    return schema_entry


def _key_schema_entry_and_is_required_rows(
    root_json_schema: dict[str, Any], section_schema: dict[str, Any], key_prefix: str
) -> list[tuple[str, dict[str, Any], bool]]:
    """Return, for each key of a study section: the key, its entry in the JSON schema, and True if it is required."""
    entries = []
    said = section_schema.get("default") or {}  # of settings within settings, whose own keys may be needed
    for name, raw in section_schema.get("properties", {}).items():
        entry = _resolve_schema_reference(root_json_schema, raw)
        key, required = f"{key_prefix}{name}", name in section_schema.get("required", [])
        if required and name in said:
            entry, required = entry | {"default": said[name], "description": section_schema["description"]}, False
        below, items = entry.get("additionalProperties"), entry.get("items", {})
        if entry.get("properties"):
            entries += _key_schema_entry_and_is_required_rows(root_json_schema, entry, f"{key}.")
            continue
        entries.append((key, entry, required))
        if isinstance(below, dict):
            entries += _key_schema_entry_and_is_required_rows(
                root_json_schema, _resolve_schema_reference(root_json_schema, below), f"{key}.NAME."
            )
        elif "$ref" in items:  # a list of settings
            entries += _key_schema_entry_and_is_required_rows(
                root_json_schema, _resolve_schema_reference(root_json_schema, items), f"{key}[]."
            )
    return entries


def markdown_tables_of_study_keys_and_record_columns() -> dict[str, str]:
    """Return Markdown tables by name: keys of a study file (``keys``), columns of the record table (``columns``)."""
    schema = Study.model_json_schema()
    keys, columns = ["| key | default | meaning |", "|---|---|---|"], ["| column | meaning |", "|---|---|"]
    for key, entry, required in _key_schema_entry_and_is_required_rows(schema, schema, ""):
        default = "required" if required else f"`{json.dumps(entry.get('default'), ensure_ascii=False)}`"
        keys.append(f"| `{key}` | {default} | {entry.get('description', '')} |")
    for column, entry in RecordTableRow.model_json_schema()["properties"].items():
        columns.append(f"| `{column}` | {entry.get('description', '')} |")
    return {"keys": "\n".join(keys), "columns": "\n".join(columns)}


def insert_study_key_and_record_column_tables(readme_text: str) -> str:
    """Return a README text with the tables of study keys and record columns put between its marker comments."""
    for name, table in markdown_tables_of_study_keys_and_record_columns().items():
        begin, end = f"<!-- {name}: made by `overturning study document`, do not edit -->", f"<!-- end of {name} -->"
        before, _, rest = readme_text.partition(begin)
        readme_text = f"{before}{begin}\n{table}\n{end}{rest.partition(end)[2]}"
    return readme_text


def write_study_schemas_and_readme_tables(config_folder: Path) -> None:
    """Write the schema of study files as ``schema.json`` and YAML, and the tables of keys into ``README.md``."""
    (config_folder / "schema.json").write_text(study_json_schema_text(), encoding="utf-8")
    catalogue = config_folder.parent / WORKFLOW_CATALOGUE_SCHEMA_PATH
    if catalogue.parent.is_dir():
        catalogue.write_text(study_json_schema_as_yaml_text(), encoding="utf-8")
    readme = config_folder / "README.md"
    readme.write_text(insert_study_key_and_record_column_tables(readme.read_text(encoding="utf-8")), encoding="utf-8")


_NEW_STUDY_FILE_TEMPLATE = """\
# Every key is explained in config/README.md.
name: {name} # of the folder under results/
title: {title}
question: Which way do gravestones fall?
primary: {{statistic: {statistic}}} # what answers the question: choose it before the results are seen
records: {{use: [{records}]}} # ids of config/records.tsv
azimuth: {{step: {step:g}}} # degrees; a divisor of 360
b_over_h: {{start: 0.1, stop: 0.6, step: 0.1}} # width over height
height: [0.6] # m
friction: [0.58, 1.0]
"""


def new_study_file_text(
    study_name: str,
    record_ids: Sequence[str],
    study_title: str = "",
    azimuth_step_deg: float = 15.0,
    primary_statistic_name: str = "share",
) -> str:
    """Return the text of a new study file with the given records and primary statistic; the text is not validated."""
    quoted = json.dumps(study_title or study_name, ensure_ascii=False)
    return _NEW_STUDY_FILE_TEMPLATE.format(
        name=study_name,
        title=quoted,
        records=", ".join(record_ids),
        step=azimuth_step_deg,
        statistic=primary_statistic_name,
    )


_PARENT_FOLDER_LINK_PATTERN: Final = re.compile(r"\[([^]]+)\]\(\.\./[^)]+\)")
_REPOSITORY_ONLY_SECTION_PATTERN: Final = re.compile(
    r"<!-- repository -->\n.*?<!-- end of repository -->\n\n", re.DOTALL
)


def adapt_readme_text_to_new_project(config_readme_text: str) -> str:
    """Return the text of config/README.md for a new project, which lacks the folder docs/ and the example studies."""
    return _PARENT_FOLDER_LINK_PATTERN.sub(r"\1", _REPOSITORY_ONLY_SECTION_PATTERN.sub("", config_readme_text))
