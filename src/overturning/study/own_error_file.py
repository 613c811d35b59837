"""The outcome of a study's repetition as a file: written, read, and refused where it is torn or old."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, Discriminator, Field, Tag, ValidationError

from overturning.errors import ResultError
from overturning.files import atomic_write


def write_verification(found: Mapping[str, Any], path: Path) -> None:
    """Write the outcome of `repeat_sample` as JSON."""
    with atomic_write(path) as part:
        part.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


class _Outcome(BaseModel):
    element: str
    cases: int
    flags: int
    flags_undivided: int
    fallen: int
    sides: int
    unanswered: int


class _Repeated(BaseModel):
    block_steps: int
    outcomes: list[_Outcome] = Field(min_length=1)


class _Refused(BaseModel):
    refused: str


class _Settling(BaseModel):
    changed: int
    looked_at: int
    settled: int
    chaotic: int
    block_steps: int


def _kind(part: Any) -> str:
    return "refused" if isinstance(part, dict) and "refused" in part else "repeated"


_Repetition = Annotated[
    Annotated[_Repeated, Tag("repeated")] | Annotated[_Refused, Tag("refused")], Discriminator(_kind)
]


class _Found(BaseModel):
    """What `repeat_sample` makes and the report reads."""

    seed: int
    wanted: int
    chosen: int
    at_rest: int
    cells: int
    study_block_steps: int
    cost: float
    finer_by: int
    stiffer_by: float
    finer: _Repetition
    stiffer: _Repetition
    settling: _Settling


def read_verification(path: Path) -> dict[str, Any]:
    """Read what `write_verification` wrote.

    Raises
    ------
    ResultError
        If the file is missing or torn, or was written by a version that said less.
    """
    remedy = "run the study again, which makes the verification anew"
    try:
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        raise ResultError(f"{path}: no outcome of a verification; {remedy}") from None
    try:
        _Found.model_validate(found)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"] if part not in ("repeated", "refused"))
        wrong = "is missing" if first["type"] == "missing" else first["msg"].lower()
        raise ResultError(f"{path}: {f'{key} ' if key else ''}{wrong}; written by another version: {remedy}") from None
    return found
