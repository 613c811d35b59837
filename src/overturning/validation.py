"""Readable messages for pydantic's validation errors: the key, its value and the expected value."""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache, wraps
from inspect import Parameter, Signature
from typing import Any, Final, Literal, TypeVar, get_args, get_origin, get_type_hints

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from overturning.errors import REASON_SEPARATOR, ArgumentError, closest_name_hint

_BOOLEAN_NEEDED_MESSAGE: Final = "true or false is needed"
_NUMBER_NEEDED_MESSAGE: Final = "a number is needed"
_INTEGER_NEEDED_MESSAGE: Final = "a whole number is needed"
_KEYS_NEEDED_MESSAGE: Final = "keys with values are needed, as in {key: value}"
_DATE_NEEDED_MESSAGE: Final = "a date is needed, as in 2026-11-21"
_DATETIME_NEEDED_MESSAGE: Final = "a date and time are needed, as in 2016-11-13T11:02:56"

_MESSAGES_BY_ERROR_TYPE: Final[dict[str, str]] = {
    "missing": "this key is needed",
    "extra_forbidden": "unknown key",
    **dict.fromkeys(("bool_type", "bool_parsing"), _BOOLEAN_NEEDED_MESSAGE),
    **dict.fromkeys(("float_type", "float_parsing"), _NUMBER_NEEDED_MESSAGE),
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float", "int_parsing_size"), _INTEGER_NEEDED_MESSAGE),
    "finite_number": "a finite number is needed",
    "invalid_key": "a key must be a text; put it in quotes",
    **dict.fromkeys(
        ("dict_type", "mapping_type", "model_type", "model_attributes_type", "dataclass_type"), _KEYS_NEEDED_MESSAGE
    ),
    **dict.fromkeys(
        ("date_type", "date_parsing", "date_from_datetime_parsing", "date_from_datetime_inexact"), _DATE_NEEDED_MESSAGE
    ),
    **dict.fromkeys(("datetime_type", "datetime_parsing", "datetime_from_date_parsing"), _DATETIME_NEEDED_MESSAGE),
    "none_required": "no value is allowed; leave the key out",
}
"""Constant messages by type of error."""

ErrorDetails = dict[str, Any]


def _allowed_value_count_text(error_details: ErrorDetails, min_or_max: str) -> str:
    """Return the allowed number of values in a list as text, such as "3 values", from a validation error."""
    number = error_details[f"{min_or_max}_length"]
    return f"{number} value{'' if number == 1 else 's'}"


def _allowed_character_count_text(error_details: ErrorDetails, min_or_max: str) -> str:
    """Return the allowed number of characters of a text, such as "3 characters", from a validation error."""
    number = error_details[f"{min_or_max}_length"]
    return f"{number} character{'' if number == 1 else 's'}"


def _allowed_values_text(error_details: ErrorDetails, given_value: Any) -> str:
    """Return a message with the allowed values of a setting, and the one closest to the given value."""
    known = re.findall(r"'([^']*)'", error_details["expected"])
    near = closest_name_hint(given_value, known, " ") if isinstance(given_value, str) and len(known) > 1 else " "
    return f"it should be {error_details['expected']}{'' if near == ' ' else f'; {near}'}"


def _unknown_setting_kind_text(error_details: ErrorDetails) -> str:
    """Return a message for an unknown value of a key that selects one of several kinds of setting."""
    known = re.findall(r"'([^']*)'", error_details["expected_tags"])
    hint = closest_name_hint(error_details["tag"], known)
    return f"unknown {error_details['discriminator'].strip(chr(39))} {error_details['tag']!r}; {hint}"


_MESSAGE_FUNCTIONS_BY_ERROR_TYPE: Final[dict[str, Callable[[ErrorDetails, Any], str]]] = {
    "too_short": lambda details, _: (
        f"at least {_allowed_value_count_text(details, 'min')} needed, not {details['actual_length']}"
    ),
    "too_long": lambda details, _: (
        f"at most {_allowed_value_count_text(details, 'max')} allowed, not {details['actual_length']}"
    ),
    "string_too_short": lambda details, given: (
        "a text is needed that is not empty"
        if not given
        else f"at least {_allowed_character_count_text(details, 'min')} needed"
    ),
    "string_too_long": lambda details, _: f"at most {_allowed_character_count_text(details, 'max')} allowed",
    "literal_error": _allowed_values_text,
    "union_tag_invalid": lambda details, _: _unknown_setting_kind_text(details),
    "union_tag_not_found": lambda details, _: (
        f"the key {details['discriminator']} is needed: it decides which other keys there are"
    ),
}
"""Functions that make a message by type of error, from the error's details and the value."""

PYDANTIC_ERROR_TYPES_OF_NON_LISTS: Final = ("tuple_type", "list_type", "set_type", "frozen_set_type")
"""Types of error of a value that is not a list."""


class RefusedBooleanText(str):
    """Text "true" or "false" that replaces a Boolean where a number is expected, so that pydantic refuses it."""


class StrictModel(BaseModel):
    """Base class of settings read from files: unknown keys are refused, and instances are immutable.

    True and false are refused where a number is expected; pydantic alone would read them as 1 and 0.
    """

    # A misspelt key is an error. Immutable instances can be hashed, cached and shared between threads.
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _replace_booleans_in_number_fields(cls, unvalidated_content: Any) -> Any:
        """Replace true and false by texts if a number is needed, so that pydantic does not read them as 1 and 0."""
        if not isinstance(unvalidated_content, dict):
            return unvalidated_content
        numbers = _keys_whose_values_are_numbers(cls)
        return {
            key: _replace_booleans_by_texts(one) if key in numbers else one for key, one in unvalidated_content.items()
        }


@cache
def _keys_whose_values_are_numbers(model_class: type[BaseModel]) -> frozenset[str]:
    """Return the keys of a settings model whose values are numbers, or lists of numbers, and never Booleans."""
    types = {
        name: _types_of_setting_or_its_list_items(field.annotation) for name, field in model_class.model_fields.items()
    }
    return frozenset(name for name, own in types.items() if own & {int, float} and bool not in own)


def _types_of_setting_or_its_list_items(annotation: Any) -> set[type]:
    """Return the types of a setting's value, or of the values in its list, from its type annotation."""
    if isinstance(annotation, type) and not get_args(annotation):
        return {annotation}
    parts = () if get_origin(annotation) is Literal else get_args(annotation)
    return {each for part in parts for each in _types_of_setting_or_its_list_items(part)}


def _replace_booleans_by_texts(value: Any) -> Any:
    """Return a value in which True and False, also in lists, are replaced by the texts "true" and "false"."""
    if isinstance(value, list | tuple):
        return type(value)(map(_replace_booleans_by_texts, value)) if type(value) in (list, tuple) else value
    return RefusedBooleanText(str(value).lower()) if isinstance(value, bool) else value


def format_validation_error(error_entry: Any) -> str:
    """Return a message for one error in a pydantic ValidationError: the problem and the expected value."""
    kind, details, given = error_entry["type"], error_entry.get("ctx", {}), error_entry.get("input")
    if kind == "string_pattern_mismatch":
        return _allowed_characters_text(details["pattern"])
    if kind in PYDANTIC_ERROR_TYPES_OF_NON_LISTS:
        single = isinstance(given, str | int | float) and not isinstance(given, bool)
        return f"a list is needed: [{given}]" if single else "a list is needed, as in [first, second]"
    if kind in ("string_type", "string_sub_type", "string_unicode"):
        return "a text is needed" + ("; put it in quotes" if isinstance(given, bool | int | float) else "")
    if kind == "missing" and error_entry["loc"] and isinstance(error_entry["loc"][-1], int):
        return "a value is missing here"
    if kind in _MESSAGE_FUNCTIONS_BY_ERROR_TYPE:
        return _MESSAGE_FUNCTIONS_BY_ERROR_TYPE[kind](details, given)
    return _MESSAGES_BY_ERROR_TYPE.get(
        kind, str(error_entry["msg"]).removeprefix("Value error, ").replace("Input should be", "it should be")
    )


def _allowed_characters_text(pattern: str) -> str:
    """Return a message with the characters that a setting may contain, according to its regular expression."""
    if "[0-9a-f]" in pattern:
        return "64 digits of a SHA-256 are needed: 0 to 9 and a to f"
    if r"\S" in pattern:
        return f"a word without spaces is needed, of at most {re.findall(r'[0-9]+', pattern)[-1]} characters"
    signs = ", hyphens and underscores" if "_" in pattern else " and hyphens"
    most = "".join(f", at most {1 + int(number)} in all" for number in re.findall(r"\{0,([0-9]+)\}", pattern))
    return f"only small letters, digits{signs} are allowed, a letter or digit first{most}"


def _omit_redundant_length_errors(error_entries: Sequence[Any]) -> list[Any]:
    """Omit "list is too short" errors of lists that also contain an invalid value, whose own error is enough."""
    places = [tuple(fault["loc"]) for fault in error_entries]
    return [
        fault
        for fault, place in zip(error_entries, places, strict=True)
        if fault["type"] != "too_short" or not any(other[: len(place)] == place != other for other in places)
    ]


KeyPath = list[int | str]


def describe_invalid_keys(
    error: ValidationError,
    validated_model_or_type: Any,
    make_printed_key_path: Callable[[KeyPath], KeyPath] = list,
    name_of_value_without_key: str = "",
) -> list[str]:
    """Return a line for each invalid key of a file: the key, its value and the expected value.

    Parameters
    ----------
    error : ValidationError
        Error from the validation of `validated_model_or_type`.
    validated_model_or_type : type
        Model or type that was validated; it gives the known keys.
    make_printed_key_path : callable, optional
        Function from the path of a value (keys and list positions) to the path that is printed.
    name_of_value_without_key : str, optional
        Text printed in place of the key if the content of the file as a whole is wrong, such as "the study".
    """
    found: dict[tuple[str, str], list[str]] = {}
    for fault in _omit_redundant_length_errors(error.errors()):
        steps, forms = _key_path_of_error_and_models_defining_key(fault, validated_model_or_type)
        given, kind = fault["input"], fault["type"]
        message = format_validation_error(fault)
        if kind == "extra_forbidden":
            known = sorted({name for form in forms for name in form.model_fields})
            message += f"; {closest_name_hint(str(steps[-1]), known)}" if known else ""
        elif kind in ("model_type", "union_tag_not_found", "model_attributes_type") and forms:
            message = _message_on_value_given_instead_of_keys(steps, forms, given)
        elif kind == "literal_error" and forms:
            message += f", or keys with values: {', '.join(forms[0].model_fields)}"
        odd = kind == "extra_forbidden" and not _is_key_of_file(str(steps[-1]))  # not even similar to a key
        key = (
            short_text_of_value(steps[-1])
            if odd
            else ".".join(map(str, make_printed_key_path(steps))) or name_of_value_without_key
        )
        quiet = isinstance(given, BaseModel | dict) or kind in ("missing", "extra_forbidden")
        messages = found.setdefault((_shorten_text(key), "" if quiet else f"{short_text_of_value(given)} – "), [])
        messages += [message] if message not in messages else []
    # A value that fits no member of a union has one message per member.
    return [f"{f'{key}: ' if key else ''}{given}{'; or '.join(texts)}" for (key, given), texts in found.items()]


Model = TypeVar("Model", bound=BaseModel)


def make_constructor_raise_argument_errors(model_class: type[Model]) -> type[Model]:
    """Make the constructor of a pydantic model take positional values and raise ArgumentErrors; return the model.

    The error for an unknown keyword names the closest known one. Values that are validated as a part of another model,
    or by `model_validate`, raise pydantic's errors as usual. Subclasses inherit the constructor.
    """
    construct = model_class.__init__

    @wraps(construct)
    def init_with_argument_errors(self: Model, *arguments: Any, **keywords: Any) -> None:
        known = type(self).model_fields
        for name in keywords.keys() - known.keys():
            raise ArgumentError(f"{name}: no keyword of {type(self).__qualname__}; {closest_name_hint(name, known)}")
        try:
            construct(self, **dict(zip(known, arguments, strict=False)), **keywords)
        except ValidationError as error:
            raise ArgumentError(REASON_SEPARATOR.join(describe_invalid_keys(error, type(self)))) from None

    model_class.__init__ = init_with_argument_errors  # type: ignore[method-assign, assignment]
    # For help: the fields with their plain types, as parameters that may be positional.
    kinds, place = get_type_hints(model_class), Parameter.POSITIONAL_OR_KEYWORD
    fields = model_class.model_fields.items()
    parameters = [Parameter(name, place, default=field.default, annotation=kinds[name]) for name, field in fields]
    model_class.__signature__ = Signature(parameters)
    return model_class


def _key_path_of_error_and_models_defining_key(
    error_entry: Any, validated_model_or_type: Any
) -> tuple[KeyPath, list[type[BaseModel]]]:
    """Return the keys that lead to a wrong value, and the pydantic models in which its last key is defined.

    Names that pydantic adds for members of a union, and tags of models, are left out: they are not keys of the file.
    """
    steps: KeyPath = []
    forms = _pydantic_models_in_annotation(validated_model_or_type)
    for place, part in enumerate(error_entry["loc"]):
        last = place == len(error_entry["loc"]) - 1
        if isinstance(part, int) or (last and error_entry["type"] == "extra_forbidden"):
            steps.append(part)
        elif owner := next((form for form in forms if part in form.model_fields), None):
            steps.append(part)
            forms = _pydantic_models_in_annotation(owner.model_fields[part].annotation)
        elif tagged := [form for form in forms if part in _discriminator_key_and_values([form])[1]]:
            forms = tagged
        elif _is_key_of_file(part):
            steps.append(part)
    return steps, forms


def _pydantic_models_in_annotation(annotation: Any) -> list[type[BaseModel]]:
    """Return the pydantic models in a type annotation, also those inside lists and unions."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _pydantic_models_in_annotation(part)]


def _discriminator_key_and_values(union_models: Sequence[type[BaseModel]]) -> tuple[str, list[str]]:
    """Return the key whose value selects one of several pydantic models, and its possible values; else "" and []."""
    for name in union_models[0].model_fields if union_models else ():
        words = [form.model_fields[name].annotation for form in union_models if name in form.model_fields]
        if all(get_origin(word) is Literal for word in words):
            return name, [str(tag) for word in words for tag in get_args(word)]
    return "", []


def _is_key_of_file(error_location_part: str) -> bool:
    """True if a part of the location of a pydantic error is a key in the file, not a name added by pydantic."""
    members = {"float", "int", "str", "bool", "tuple", "list", "literal", "none"}
    return (
        error_location_part.replace("_", "").replace("-", "").isalnum()
        and error_location_part not in members
        and error_location_part[:12] != "constrained-"
    )


def _message_on_value_given_instead_of_keys(
    key_path: KeyPath, union_models: Sequence[type[BaseModel]], given_value: object
) -> str:
    """Return a message with the correct form of a setting that was given as one value instead of its own keys."""
    if len(union_models) > 1:
        key, known = _discriminator_key_and_values(union_models)
        if isinstance(given_value, str) and given_value in known:
            return f"write {{{key}: {given_value}}}"
        return f"the key {key} is needed, one of {', '.join(known)}"
    fields = union_models[0].model_fields
    first = _likely_key_of_value(fields, given_value)
    fits = isinstance(given_value, int | float) and not isinstance(given_value, bool)
    value = (
        f"{given_value:g}"
        if fits
        else (short_text_of_value(given_value).strip('"') if isinstance(given_value, str) and given_value else "…")
    )
    name = f"{key_path[-1]}: " if key_path and isinstance(key_path[-1], str) else ""
    return f"it has keys of its own; write {name}{{{first}: {value}}}; known: {', '.join(fields)}"


def _likely_key_of_value(model_fields: Mapping[str, Any], given_value: object) -> str:
    """Return the key to which a value that was given without a key probably belongs."""
    kinds = {int: (int, float), float: (float, int), str: (str,), list: (tuple,)}
    if type(given_value) in (int, float) and "step" in model_fields:
        return "step"
    for name, field in model_fields.items():
        if any(kind in _plain_python_types(field.annotation) for kind in kinds.get(type(given_value), ())):
            return name
    return next(iter(model_fields))


def _plain_python_types(annotation: Any) -> set[Any]:
    """Return the basic Python types that a type annotation allows: `tuple` for lists, `str` for literal words."""
    if (origin := get_origin(annotation)) is tuple:
        return {tuple}
    if origin is Literal:
        return {type(word) for word in get_args(annotation)}
    return {annotation, *(kind for part in get_args(annotation) for kind in _plain_python_types(part))}


def short_text_of_value(value: object) -> str:
    """Return the text of a value for messages, at most 60 characters and three nested levels long."""

    def shorten_nested(nested_value: object, nesting_levels_left: int) -> object:
        """Return a value with long texts cut; lists and dictionaries below the levels left become "…"."""
        if isinstance(nested_value, list | tuple):
            return (
                [shorten_nested(one, nesting_levels_left - 1) for one in nested_value[:20]]
                if nesting_levels_left
                else "…"
            )
        if isinstance(nested_value, RefusedBooleanText):
            return nested_value == "true"
        if isinstance(nested_value, dict):
            return (
                {str(key): shorten_nested(one, nesting_levels_left - 1) for key, one in nested_value.items()}
                if nesting_levels_left
                else "…"
            )
        return (
            nested_value
            if nested_value is None or isinstance(nested_value, bool | int | float)
            else str(nested_value)[:60]
        )

    return _shorten_text(json.dumps(shorten_nested(value, 3), ensure_ascii=False))


def _shorten_text(text: str) -> str:
    """Return a text of at most 60 characters; a longer one is cut and ends with "…"."""
    return text if len(text) <= 60 else text[:57] + "…"
