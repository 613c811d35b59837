"""Results that are stored as JSON: dataclasses or pydantic models, written and read in one way."""

import math
from pathlib import Path
from typing import Annotated, Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, PlainSerializer, PlainValidator, TypeAdapter, ValidationError

from overturning.errors import ResultError
from overturning.files import write_text
from overturning.validation import format_validation_error

StoredFloatOrNan = Annotated[float, BeforeValidator(lambda value: math.nan if value is None else value)]
"""A number that may be NaN, which JSON stores as null."""
StoredFloatOrInfinity = Annotated[
    StoredFloatOrNan, PlainSerializer(lambda value: str(value) if math.isinf(value) else value, when_used="json")
]
"""A number that may be NaN or infinite; JSON stores an infinite one as the text "inf" or "-inf"."""

_SERIALIZE_ARRAY_AS_LIST: Final = PlainSerializer(lambda values: values.tolist())
StoredFloatArray = Annotated[
    NDArray[np.float64], PlainValidator(lambda values: np.array(values, np.float64)), _SERIALIZE_ARRAY_AS_LIST
]
"""An array of numbers, stored as lists."""
StoredIntegerArray = Annotated[
    NDArray[np.int64], PlainValidator(lambda values: np.array(values, np.int64)), _SERIALIZE_ARRAY_AS_LIST
]
"""An array of whole numbers, stored as lists."""

Result = TypeVar("Result")


def write_result_as_json(result: Any, path: Path, *, indent: int | None = 1) -> None:
    """Write a dataclass or pydantic model, or a list of them, as JSON; on one line if `indent` is None."""
    kind: Any = list[type(result[0])] if isinstance(result, list) and result else type(result)  # type: ignore[misc]
    write_text(path, TypeAdapter(kind).dump_json(result, indent=indent).decode() + "\n")


def read_json_result(result_type: type[Result], path: Path, result_name: str) -> Result:
    """Read a JSON file from `write_result_as_json`; a `ResultError` if it is missing, damaged, or from another version.

    Parameters
    ----------
    result_type : type
        Class of the result, or ``list[…]`` of it.
    path : Path
        The file.
    result_name : str
        Name of the result in messages, such as "convergence check".
    """
    try:
        return TypeAdapter(result_type).validate_json(path.read_bytes())
    except OSError:
        raise ResultError(f"{path}: no result of the {result_name}; run the study again to create it") from None
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        why = f"{place}: {format_validation_error(first)}" if place else format_validation_error(first)
        raise ResultError(
            f"{path}: {why}; written by another version, or damaged; run the study again to recreate the {result_name}"
        ) from None
