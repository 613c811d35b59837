"""From a YAML file to a checked study, and from a wrong key to one line that says what to write instead."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from overturning.errors import ConfigError, did_you_mean
from overturning.files import portable_name, project_file, read_mapping
from overturning.study.schema import Study
from overturning.validation import describe_faults

if TYPE_CHECKING:
    from overturning.records.catalogue import RecordEntry


def load_study(path: Path) -> Study:
    """Read and check a study file.

    A `ConfigError` says that the file cannot be read, or names file, key, value and remedy of what is wrong.
    """
    return check_study(read_study(path), str(path))


def read_study(path: Path) -> dict[str, Any]:
    """Keys and values of a study file as they stand there; a `ConfigError` where it cannot be read."""
    return read_mapping(path, "study", "see config/README.md", "name a study file with --configfile")


def check_study(data: Mapping[str, Any], where: str) -> Study:
    """Check the content of a study file, `where` in the messages; a ConfigError has one line per wrong key."""
    try:
        return Study.model_validate(dict(data))
    except ValidationError as error:
        lines = describe_faults(error, Study, whole="the study")
        raise ConfigError("\n       ".join(f"{where}: {line}" for line in lines)) from None


def entries_of(study: Study, where: str, root: Path = Path()) -> dict[str, "RecordEntry"]:
    """Rows of the record table, whose path counts from `root`, that a study uses, in its order.

    A `ConfigError` names a record that is not in the table, and the study's file as `where`.
    """
    # Imported here: a step of the workflow that reads no record does not wait for them.
    from overturning.records.catalogue import RecordEntry, read_catalogue
    from overturning.records.pulses import parse_pulse

    table = read_catalogue(project_file(root / study.records.table))
    for name, line in study.records.pulses.items():
        if name in table:
            raise ConfigError(
                f"{where}: records.pulses: {name!r} is also in {study.records.table}; give the pulse another id"
            )
        parse_pulse(line)
        table[name] = RecordEntry(id=name, format="synthetic", source=line)
    for name in study.records.use:
        if name not in table:
            elsewhere = "there is none here but the package's: run in the study's project"
            remedy = "add a row for it" if (root / study.records.table).is_file() else elsewhere
            hint = did_you_mean(name, table, remedy)
            raise ConfigError(f"{where}: records.use: {name!r} is not in {study.records.table}; {hint}")
    return {name: table[name] for name in study.records.use}


def study_from(text: str) -> Study:
    """A study from the name of its file, or from its content as JSON; errors are those of `load_study`."""
    if not text.lstrip().startswith("{"):
        return load_study(Path(text))
    try:
        return check_study(json.loads(text), "--study")
    except json.JSONDecodeError as error:
        raise ConfigError(
            f"--study: not valid JSON ({error.msg} at character {error.pos}); give a file or its content"
        ) from None


def portable(study: Study) -> dict[str, Any]:
    """The filled-in study without folders of the machine it ran on: absolute paths keep their last part only."""
    data = study.model_dump(mode="json")
    for key in ("table", "folder"):
        data["records"][key] = portable_name(data["records"][key])
    for survey in data["surveys"]:
        survey["stones"] = portable_name(survey["stones"])
    return data
