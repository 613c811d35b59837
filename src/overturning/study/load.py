"""From a YAML file to a checked study, and from a wrong key to one line that says what to write instead."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from pydantic import BaseModel, ValidationError

from overturning.errors import ConfigError, did_you_mean
from overturning.files import read_mapping, shipped, without_folders
from overturning.study.schema import Study
from overturning.tables import what_is_wrong

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
        raise ConfigError("\n       ".join(dict.fromkeys(_lines(error, where)))) from None


def _lines(error: ValidationError, where: str) -> list[str]:
    lines = []
    for item in error.errors():
        # The names of union members and validators that pydantic puts into the location are no keys of the file.
        steps = [part for part in item["loc"] if isinstance(part, int) or _is_key(str(part))]
        key = ".".join(str(part) for part in steps) or "the study"
        if item["type"] == "extra_forbidden" and steps[-1:] != list(
            item["loc"][-1:]
        ):  # it does not even look like a key
            steps.append(str(item["loc"][-1]))
            key = _short(item["loc"][-1])
        given, message = item["input"], what_is_wrong(item)
        if item["type"] == "extra_forbidden":
            message += f"; {did_you_mean(str(steps[-1]), sorted(_model_at(steps[:-1]).model_fields))}"
        elif item["type"] == "tuple_type" and isinstance(given, str | int | float):
            message = f"a list is needed: [{given}]"
        elif item["type"] == "model_type":
            message = _keys_below(steps, given)
        unsaid = isinstance(given, BaseModel | dict) or item["type"] in ("missing", "extra_forbidden")
        lines.append(f"{where}: {key}: {'' if unsaid else f'{_short(given)} – '}{message}")
    return lines


def _short(value: object) -> str:
    """A value as the file has it, its beginning where it is long; of nested lists three levels."""

    def cut(part: object, level: int) -> object:
        if isinstance(part, list | tuple):
            return [cut(one, level - 1) for one in part[:20]] if level else "…"
        return part if part is None or isinstance(part, bool | int | float) else str(part)[:60]

    text = json.dumps(cut(value, 3), ensure_ascii=False)
    return text if len(text) <= 60 else text[:57] + "…"


def _is_key(part: str) -> bool:
    members = {"float", "int", "str", "tuple", "literal", "constrained-int"}
    return part.replace("_", "").replace("-", "").isalnum() and part not in members


def _forms(annotation: Any) -> list[Any]:
    """Members of a union such as a word or settings, without the marks that tell them apart."""
    return [get_args(form)[0] if get_args(form) else form for form in get_args(annotation)]


def _model_at(steps: list[int | str]) -> type[BaseModel]:
    """The settings to which the keys of a place in a study lead."""
    model: type[BaseModel] = Study
    for step in steps:
        annotation = model.model_fields[step].annotation if step in model.model_fields else None
        for form in (annotation, *_forms(annotation)):
            if isinstance(form, type) and issubclass(form, BaseModel):
                model = form
    return model


def _keys_below(steps: list[int | str], given: object) -> str:
    """How to write what has keys of its own where one value was given."""
    fields = list(_model_at(steps).model_fields)
    first = "step" if "step" in fields else fields[0]
    value = f"{given:g}" if isinstance(given, int | float) and not isinstance(given, bool) else "…"
    return f"it has keys of its own; write {steps[-1]}: {{{first}: {value}}}; known: {', '.join(fields)}"


def entries_of(study: Study, where: str, root: Path = Path()) -> dict[str, "RecordEntry"]:
    """Rows of the record table, whose path counts from `root`, that a study uses, in its order.

    A `ConfigError` names a record that is not in the table, and the study's file as `where`.
    """
    # Imported here: a step of the workflow that reads no record does not wait for them.
    from overturning.records.catalogue import RecordEntry, read_catalogue
    from overturning.records.pulses import parse_pulse

    table = read_catalogue(shipped(root / study.records.table))
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
        data["records"][key] = without_folders(data["records"][key])
    for survey in data["surveys"]:
        survey["stones"] = without_folders(survey["stones"])
    return data
