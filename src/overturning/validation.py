"""Readable messages for pydantic's validation errors: the key, its value and the expected value."""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from inspect import Parameter, Signature
from typing import Any, Final, Literal, TypeVar, get_args, get_origin, get_type_hints

from pydantic import BaseModel, ConfigDict, ValidationError

from overturning.errors import REASON_SEPARATOR, ArgumentError, did_you_mean

_TRUTH: Final = "true or false is needed"
_NUMBER: Final = "a number is needed"
_WHOLE: Final = "a whole number is needed"
_KEYS: Final = "keys with values are needed, as in {key: value}"
_DATE: Final = "a date is needed, as in 2026-11-21"
_MOMENT: Final = "a date and time are needed, as in 2016-11-13T11:02:56"

_WORDS: Final[dict[str, str]] = {
    "missing": "this key is needed",
    "extra_forbidden": "unknown key",
    **dict.fromkeys(("bool_type", "bool_parsing"), _TRUTH),
    **dict.fromkeys(("float_type", "float_parsing"), _NUMBER),
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float", "int_parsing_size"), _WHOLE),
    "finite_number": "a finite number is needed",
    "invalid_key": "a key must be a text; put it in quotes",
    **dict.fromkeys(("dict_type", "mapping_type", "model_type", "model_attributes_type", "dataclass_type"), _KEYS),
    **dict.fromkeys(("date_type", "date_parsing", "date_from_datetime_parsing", "date_from_datetime_inexact"), _DATE),
    **dict.fromkeys(("datetime_type", "datetime_parsing", "datetime_from_date_parsing"), _MOMENT),
    "none_required": "no value is allowed; leave the key out",
}
"""Constant messages by type of error."""

Details = dict[str, Any]


def _count(details: Details, side: str) -> str:
    """Return the allowed number of values of a list, or of keys; `side` is ``min`` or ``max``."""
    number = details[f"{side}_length"]
    return f"{number} value{'' if number == 1 else 's'}"


def _characters(details: Details, side: str) -> str:
    number = details[f"{side}_length"]
    return f"{number} character{'' if number == 1 else 's'}"


def _choice(details: Details, given: Any) -> str:
    """Return the allowed values of a choice, and the one closest to the given value."""
    known = re.findall(r"'([^']*)'", details["expected"])
    near = did_you_mean(given, known, " ") if isinstance(given, str) and len(known) > 1 else " "
    return f"it should be {details['expected']}{'' if near == ' ' else f'; {near}'}"


def _tag(details: Details) -> str:
    known = re.findall(r"'([^']*)'", details["expected_tags"])
    return (
        f"unknown {details['discriminator'].strip(chr(39))} {details['tag']!r}; {did_you_mean(details['tag'], known)}"
    )


_OF_DETAILS: Final[dict[str, Callable[[Details, Any], str]]] = {
    "too_short": lambda details, _: f"at least {_count(details, 'min')} needed, not {details['actual_length']}",
    "too_long": lambda details, _: f"at most {_count(details, 'max')} allowed, not {details['actual_length']}",
    "string_too_short": lambda details, given: (
        "a text is needed that is not empty" if not given else f"at least {_characters(details, 'min')} needed"
    ),
    "string_too_long": lambda details, _: f"at most {_characters(details, 'max')} allowed",
    "literal_error": _choice,
    "union_tag_invalid": lambda details, _: _tag(details),
    "union_tag_not_found": lambda details, _: (
        f"the key {details['discriminator']} is needed: it decides which other keys there are"
    ),
}
"""Functions that make a message by type of error, from the error's details and the value."""

LISTS: Final = ("tuple_type", "list_type", "set_type", "frozen_set_type")
"""Types of error of a value that is not a list."""


class StrictModel(BaseModel):
    """Base class of models read from files: unknown keys are refused, instances are immutable."""

    # A misspelt key is an error. Immutable instances can be hashed, cached and shared between threads.
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def format_validation_error(fault: Any) -> str:
    """Return a message with the fault of a value and the expected value, for one error of a ValidationError."""
    kind, details, given = fault["type"], fault.get("ctx", {}), fault.get("input")
    if kind == "string_pattern_mismatch":
        return _pattern(details["pattern"])
    if kind in LISTS:
        single = isinstance(given, str | int | float) and not isinstance(given, bool)
        return f"a list is needed: [{given}]" if single else "a list is needed, as in [first, second]"
    if kind in ("string_type", "string_sub_type", "string_unicode"):
        return "a text is needed" + ("; put it in quotes" if isinstance(given, bool | int | float) else "")
    if kind == "missing" and fault["loc"] and isinstance(fault["loc"][-1], int):
        return "a value is missing here"
    if kind in _OF_DETAILS:
        return _OF_DETAILS[kind](details, given)
    return _WORDS.get(kind, str(fault["msg"]).removeprefix("Value error, ").replace("Input should be", "it should be"))


def _pattern(pattern: str) -> str:
    """Return a message with the characters that a pattern of this package allows."""
    if "[0-9a-f]" in pattern:
        return "64 digits of a SHA-256 are needed: 0 to 9 and a to f"
    if r"\S" in pattern:
        return f"a word without spaces is needed, of at most {re.findall(r'[0-9]+', pattern)[-1]} characters"
    signs = ", hyphens and underscores" if "_" in pattern else " and hyphens"
    return f"only small letters, digits{signs} are allowed, a letter or digit first"


def _of_values(faults: Sequence[Any]) -> list[Any]:
    """Return the errors, without "too short" for lists that are too short only because a value is invalid."""
    places = [tuple(fault["loc"]) for fault in faults]
    return [
        fault
        for fault, place in zip(faults, places, strict=True)
        if fault["type"] != "too_short" or not any(other[: len(place)] == place != other for other in places)
    ]


Steps = list[int | str]


def describe_faults(
    error: ValidationError, root: Any, names: Callable[[Steps], Steps] = list, whole: str = ""
) -> list[str]:
    """Return a line for each invalid key of a file: the key, its value and the expected value.

    Parameters
    ----------
    error : ValidationError
        Error from the validation of `root`.
    root : type
        Model or type that was validated; it gives the known keys.
    names : callable, optional
        Function from the path of a value (keys and list positions) to the path that is printed.
    whole : str, optional
        Name of a value without a key.
    """
    found: dict[tuple[str, str], list[str]] = {}
    for fault in _of_values(error.errors()):
        steps, forms = _place(fault, root)
        given, kind = fault["input"], fault["type"]
        message = format_validation_error(fault)
        if kind == "extra_forbidden":
            known = sorted({name for form in forms for name in form.model_fields})
            message += f"; {did_you_mean(str(steps[-1]), known)}" if known else ""
        elif kind in ("model_type", "union_tag_not_found", "model_attributes_type") and forms:
            message = _keys_below(steps, forms, given)
        odd = kind == "extra_forbidden" and not _is_key(str(steps[-1]))  # not even similar to a key
        key = short_value(steps[-1]) if odd else ".".join(map(str, names(steps))) or whole
        quiet = isinstance(given, BaseModel | dict) or kind in ("missing", "extra_forbidden")
        messages = found.setdefault((_short(key), "" if quiet else f"{short_value(given)} – "), [])
        messages += [message] if message not in messages else []
    # A value that fits no member of a union has one message per member.
    return [f"{f'{key}: ' if key else ''}{given}{'; or '.join(texts)}" for (key, given), texts in found.items()]


Model = TypeVar("Model", bound=BaseModel)


def raise_argument_errors(model: type[Model]) -> type[Model]:
    """Decorate a model for use in Python: its constructor accepts positional values and raises ArgumentErrors.

    An unknown keyword is answered with the closest one. Values that are validated as a part of another model, or by
    `model_validate`, raise pydantic's errors as usual. Subclasses inherit the constructor.
    """
    construct = model.__init__

    @wraps(construct)
    def init(self: Model, *given: Any, **named: Any) -> None:
        known = type(self).model_fields
        for name in named.keys() - known.keys():
            raise ArgumentError(f"{name}: no keyword of {type(self).__qualname__}; {did_you_mean(name, known)}")
        try:
            construct(self, **dict(zip(known, given, strict=False)), **named)
        except ValidationError as error:
            raise ArgumentError(REASON_SEPARATOR.join(describe_faults(error, type(self)))) from None

    model.__init__ = init  # type: ignore[method-assign, assignment]
    # For help: the fields with their plain types, as parameters that may be positional.
    kinds, place = get_type_hints(model), Parameter.POSITIONAL_OR_KEYWORD
    fields = model.model_fields.items()
    parameters = [Parameter(name, place, default=field.default, annotation=kinds[name]) for name, field in fields]
    model.__signature__ = Signature(parameters)
    return model


def _place(fault: Any, root: Any) -> tuple[Steps, list[type[BaseModel]]]:
    """Return the path of a value (keys and list positions), and the models to which its last key belongs or leads.

    Names that pydantic adds for members of a union, and tags of models, are left out: they are not keys of the file.
    """
    steps: Steps = []
    forms = _models(root)
    for place, part in enumerate(fault["loc"]):
        last = place == len(fault["loc"]) - 1
        if isinstance(part, int) or (last and fault["type"] == "extra_forbidden"):
            steps.append(part)
        elif owner := next((form for form in forms if part in form.model_fields), None):
            steps.append(part)
            forms = _models(owner.model_fields[part].annotation)
        elif tagged := [form for form in forms if part in _tags([form])[1]]:
            forms = tagged
        elif _is_key(part):
            steps.append(part)
    return steps, forms


def _models(annotation: Any) -> list[type[BaseModel]]:
    """Return the models in an annotation, also those inside lists and unions."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models(part)]


def _tags(forms: Sequence[type[BaseModel]]) -> tuple[str, list[str]]:
    """Return the key that distinguishes the models of a union, and its values; empty if there is none."""
    for name in forms[0].model_fields if forms else ():
        words = [form.model_fields[name].annotation for form in forms if name in form.model_fields]
        if all(get_origin(word) is Literal for word in words):
            return name, [str(tag) for word in words for tag in get_args(word)]
    return "", []


def _is_key(part: str) -> bool:
    members = {"float", "int", "str", "bool", "tuple", "list", "literal", "none"}
    return part.replace("_", "").replace("-", "").isalnum() and part not in members and part[:12] != "constrained-"


def _keys_below(steps: Steps, forms: Sequence[type[BaseModel]], given: object) -> str:
    """Return a message with the correct form of a mapping, if a single value was given instead."""
    if len(forms) > 1:
        key, known = _tags(forms)
        if isinstance(given, str) and given in known:
            return f"write {{{key}: {given}}}"
        return f"the key {key} is needed, one of {', '.join(known)}"
    fields = forms[0].model_fields
    first = _key_for(fields, given)
    fits = isinstance(given, int | float) and not isinstance(given, bool)
    value = f"{given:g}" if fits else (short_value(given).strip('"') if isinstance(given, str) and given else "…")
    name = f"{steps[-1]}: " if steps and isinstance(steps[-1], str) else ""
    return f"it has keys of its own; write {name}{{{first}: {value}}}; known: {', '.join(fields)}"


def _key_for(fields: Mapping[str, Any], given: object) -> str:
    """Return the most likely key of a value: ``step``, or the first key that accepts a value of its type."""
    kinds = {int: (int, float), float: (float, int), str: (str,), list: (tuple,)}
    if type(given) in (int, float) and "step" in fields:
        return "step"
    for name, field in fields.items():
        if any(kind in _kinds(field.annotation) for kind in kinds.get(type(given), ())):
            return name
    return next(iter(fields))


def _kinds(annotation: Any) -> set[Any]:
    """Return the plain types in an annotation: `tuple` for any list, `str` for a literal word."""
    if (origin := get_origin(annotation)) is tuple:
        return {tuple}
    if origin is Literal:
        return {type(word) for word in get_args(annotation)}
    return {annotation, *(kind for part in get_args(annotation) for kind in _kinds(part))}


def short_value(value: object) -> str:
    """Return a value as written in a file, shortened to 60 characters and to three levels of nested lists."""

    def cut(part: object, level: int) -> object:
        if isinstance(part, list | tuple):
            return [cut(one, level - 1) for one in part[:20]] if level else "…"
        if isinstance(part, dict):
            return {str(key): cut(one, level - 1) for key, one in part.items()} if level else "…"
        return part if part is None or isinstance(part, bool | int | float) else str(part)[:60]

    return _short(json.dumps(cut(value, 3), ensure_ascii=False))


def _short(text: str) -> str:
    return text if len(text) <= 60 else text[:57] + "…"
