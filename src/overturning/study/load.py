"""Read and validate study files, with one line of message for each wrong key."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from overturning.errors import REASON_SEPARATOR, ConfigError, closest_name_hint
from overturning.files import file_name_if_absolute_else_path, path_in_working_folder_or_package, read_yaml_mapping
from overturning.study.schema import Study
from overturning.validation import describe_invalid_keys

if TYPE_CHECKING:
    from overturning.records.catalogue import RecordTableRow


def load_study(path: Path) -> Study:
    """Read a study file and return the validated study.

    A `ConfigError` is raised if the file cannot be read or is invalid; the message names each wrong key, with remedy.
    """
    return study_from_content(read_unvalidated_study_content(path), str(path))


def read_unvalidated_study_content(
    path: Path, remedy_in_error_message: str = "check its name and permissions"
) -> dict[str, Any]:
    """Read keys and values of a study file without validation; raise a `ConfigError` if it cannot be read.

    `remedy_in_error_message` is the remedy stated if the file is missing or its permissions forbid reading.
    """
    return read_yaml_mapping(path, "study", "see config/README.md", remedy_in_error_message)


def study_from_content(study_file_content: Mapping[str, Any], study_file_in_error_messages: str) -> Study:
    """Return the study that a study file's content describes; a `ConfigError` has a line for each wrong key."""
    try:
        return Study.model_validate(dict(study_file_content))
    except ValidationError as error:
        lines = describe_invalid_keys(error, Study, name_of_value_without_key="the study")
        # Settings that do not go together are one error of pydantic, of several lines.
        lines = [each for line in lines for each in line.replace(REASON_SEPARATOR, "\nthe study: ").split("\n")]
        raise ConfigError(REASON_SEPARATOR.join(f"{study_file_in_error_messages}: {line}" for line in lines)) from None


def read_record_table_rows_of_study(
    study: Study, study_file_in_error_messages: str, project_folder: Path = Path()
) -> dict[str, "RecordTableRow"]:
    """Return the record-table rows of the records in a study; the path of the table is relative to `project_folder`.

    A `ConfigError` names a record that is not in the table, with the study file as `study_file_in_error_messages`.
    """
    # Imported lazily: workflow steps that read no record start faster.
    from overturning.records.catalogue import RecordTableRow, read_record_table
    from overturning.records.pulses import parse_pulse

    table = read_record_table(path_in_working_folder_or_package(project_folder / study.records.table))
    faults = []
    for name, line in study.records.pulses.items():
        if name in table:
            faults.append(f"records.pulses: {name!r} is also in {study.records.table}; give the pulse another id")
            continue
        try:
            parse_pulse(line)
        except ConfigError as error:
            faults.append(f"records.pulses.{name}: {error}")
        table[name] = RecordTableRow(id=name, format="synthetic", source=line)
    if faults:
        raise ConfigError(REASON_SEPARATOR.join(f"{study_file_in_error_messages}: {fault}" for fault in faults))
    for name in study.records.use:
        if name not in table:
            elsewhere = "there is none here but the package's: run in the study's project"
            remedy = "add a row for it" if (project_folder / study.records.table).is_file() else elsewhere
            hint = closest_name_hint(name, table, remedy)
            raise ConfigError(
                f"{study_file_in_error_messages}: records.use: {name!r} is not in {study.records.table}; {hint}"
            )
    return {name: table[name] for name in study.records.use}


def load_study_from_file_or_json(study_file_path_or_json_text: str) -> Study:
    """Load a study from a file name or from JSON text; for errors see `load_study`."""
    if not study_file_path_or_json_text.lstrip().startswith("{"):
        return load_study(Path(study_file_path_or_json_text))
    try:
        return study_from_content(json.loads(study_file_path_or_json_text), "--study")
    except json.JSONDecodeError as error:
        raise ConfigError(
            f"--study: not valid JSON ({error.msg} at character {error.pos}); give a file or its content"
        ) from None


def study_settings_with_file_names_for_absolute_paths(study: Study) -> dict[str, Any]:
    """Return a study's settings as a dictionary in which absolute paths are shortened to the file name."""
    data = study.model_dump(mode="json")
    for key in ("table", "folder"):
        data["records"][key] = file_name_if_absolute_else_path(data["records"][key])
    for survey in data["surveys"]:
        survey["stones"] = file_name_if_absolute_else_path(survey["stones"])
    return data
