"""Row of a survey table: its columns, the rules between them, and what a row counts as in statistics."""

import json
import math
import re
from collections.abc import Callable, Iterator
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
    model_validator,
)

from overturning.model.cases import checked_stone_height
from overturning.surveys.notation import (
    COMPASS_POINTS_16,
    NO_DIRECTION,
    OCTANTS,
    OUTCOME_KINDS_NOT_COUNTED_AS_STANDING,
    UNKNOWN_VALUE_TEXTS,
    OutcomeKind,
    StatedDirection,
    StatedOutcome,
    make_shift_text_readable_as_float,
    normalise_degrees_text,
    normalise_number_text,
    parse_direction,
    parse_outcome,
)

_TEXTS_MEANING_YES, _TEXTS_MEANING_NO = ("yes", "fell", "true", "1", "y"), ("no", "stood", "false", "0", "n")


def _parse_yes_or_no(text: object) -> bool:
    """Convert the text of a table cell to True ("yes" or a synonym) or False ("no" or a synonym)."""
    if str(text).lower() not in _TEXTS_MEANING_YES + _TEXTS_MEANING_NO:
        unknown = (
            "; an unknown outcome belongs in the column outcome" if str(text).lower() in UNKNOWN_VALUE_TEXTS else ""
        )
        raise ValueError(f"write yes or no{unknown}")
    return str(text).lower() in _TEXTS_MEANING_YES


def _parse_octant_index(text: object) -> int:
    """Convert the name of a compass octant to its index, clockwise from 0 for north."""
    if str(text).upper() not in OCTANTS:
        finer = (
            "; one of 16 compass points belongs in the column azimuth_deg"
            if str(text).upper() in COMPASS_POINTS_16
            else ""
        )
        raise ValueError(f"use one of {' '.join(OCTANTS)}{finer}")
    return OCTANTS.index(str(text).upper())


def _normalise_count_and_refuse_point_or_comma(text: object) -> object:
    """Prepare the text of a number of stones for `int`; refuse a point or comma, which may separate thousands."""
    plain = normalise_number_text(text)
    if isinstance(plain, str) and re.fullmatch(r"[+-]?[\d.,]*[.,][\d.,]*", str(text).strip()):
        raise ValueError("write a whole number without point or comma, such as 1000")
    return plain


_NUMBER_TEXT_SCHEMA = {"type": "string", "pattern": r"^[+-]?(\d+([.,]\d*)?|[.,]\d+)$"}
_ANGLE_TEXT_SCHEMA = {"type": "string", "pattern": r"^[+-]?\d+([.,]\d*)?\s*([°º˚]|deg|degrees)?$"}
_DIRECTION_SCHEMA: dict[str, Any] = {
    "anyOf": [
        {"type": "number", "minimum": -360, "maximum": 360},
        _ANGLE_TEXT_SCHEMA,
        {"type": "string", "pattern": "^(?:" + "|".join(f"{one}|{one.lower()}" for one in COMPASS_POINTS_16) + ")$"},
        {"type": "string", "pattern": r"^[NSns]\s*\d+([.,]\d+)?\s*([°º˚]|deg)?\s*[EWew]$"},
    ]
}


def _json_schema_of_number_cell(
    smallest_number: float, largest_number: float, json_type_name: str = "number"
) -> WithJsonSchema:
    """Return the JSON schema of a survey cell that contains a number between two limits, possibly as text."""
    return WithJsonSchema(
        {
            "anyOf": [
                {"type": json_type_name, "minimum": smallest_number, "maximum": largest_number},
                _NUMBER_TEXT_SCHEMA,
            ]
        }
    )


_YES_OR_NO_SCHEMA = WithJsonSchema({"enum": [*_TEXTS_MEANING_YES, *_TEXTS_MEANING_NO, True, False]})
_AzimuthFromText = Annotated[StatedDirection, PlainValidator(parse_direction), WithJsonSchema(_DIRECTION_SCHEMA)]
_Number = Annotated[float, BeforeValidator(normalise_number_text)]
_Degrees = Annotated[float, BeforeValidator(normalise_degrees_text)]
_Shift = Annotated[float, BeforeValidator(make_shift_text_readable_as_float)]
_Slenderness = Annotated[_Number, Field(ge=0.01, le=5), _json_schema_of_number_cell(0.01, 5)]
_Coordinate = Annotated[_Number, Field(ge=-1e8, le=1e8), _json_schema_of_number_cell(-1e8, 1e8)]


class SurveyRow(BaseModel):
    """Validated row of a survey table, with a field for each column; an empty cell means the default."""

    model_config = ConfigDict(title="Row of a survey of gravestones")

    site: str = Field("", description="cemetery")
    stone: str = Field("", description="name or number of the stone")
    kind: str = Field("", description="kind of stone, such as a three-tier grave or a lantern")
    outcome: Annotated[
        StatedOutcome,
        PlainValidator(parse_outcome),
        WithJsonSchema({"type": "string", "examples": ["fell", "stands", "shifted 3 cm", "twisted -10", "broken"]}),
    ] = Field(
        StatedOutcome(),
        description="what happened: `fell`, `fell direction unknown`, `stands`, `shifted 3 cm`, `twisted 10` (degrees, "
        "clockwise positive), `broken`, `repaired`, `fixed` (to its base) or `unknown`; several are "
        "separated by a comma",
    )
    fell: Annotated[bool | None, BeforeValidator(_parse_yes_or_no), _YES_OR_NO_SCHEMA] = Field(
        None,
        description="`yes` or `no`, instead of `outcome`; may be empty if a direction is given. `yes` without a "
        "direction: the direction is unknown",
    )
    azimuth_deg: _AzimuthFromText = Field(
        NO_DIRECTION,
        description="direction towards which the stone fell: degrees clockwise from north (not radians, not gon), one "
        "of the 16 compass points (`SSE`), or a quadrant bearing (`S40E`)",
    )
    octant: Annotated[
        int | None,
        BeforeValidator(_parse_octant_index),
        WithJsonSchema({"enum": [*OCTANTS, *(one.lower() for one in OCTANTS)]}),
    ] = Field(None, description="direction of the fall as N, NE, E, SE, S, SW, W or NW, instead of `azimuth_deg`")
    count: Annotated[
        int,
        BeforeValidator(_normalise_count_and_refuse_point_or_comma),
        Field(ge=1, le=1_000_000),
        _json_schema_of_number_cell(1, 1_000_000, "integer"),
    ] = Field(1, description="number of stones of this row; default 1")
    b_over_h: _Slenderness = Field(
        math.nan, description="width over height in the plane through the normal of the front face"
    )
    b_over_h_side: _Slenderness = Field(
        math.nan, description="the same in the plane at right angles; default: a square footprint"
    )
    face_azimuth_deg: _AzimuthFromText = Field(
        NO_DIRECTION, description="azimuth that the front face faces, written like `azimuth_deg`"
    )
    magnetic_declination_deg: Annotated[_Degrees, Field(ge=-180, le=180), _json_schema_of_number_cell(-180, 180)] = (
        Field(
            0.0,
            description="magnetic declination, degrees, east positive, added to both directions of the row; empty for "
            "directions from true north. For an octant at most 11.25° (also named `declination`)",
        )
    )
    height_m: Annotated[_Number, AfterValidator(checked_stone_height), _json_schema_of_number_cell(0.01, 50)] = Field(
        math.nan,
        description="height of the stone, m; for the computed share of falls and for `overturning backwards`",
    )
    round: Annotated[bool, BeforeValidator(_parse_yes_or_no), _YES_OR_NO_SCHEMA] = Field(
        False, description="`yes` for a column, which can fall in any plane; only for `overturning backwards`"
    )
    shift_cm: Annotated[_Shift, Field(ge=0, le=1000), _json_schema_of_number_cell(0, 1000)] = Field(
        math.nan, description="shift of the base of a stone that stands, cm"
    )
    shift_mm: Annotated[_Shift, Field(ge=0, le=10_000), _json_schema_of_number_cell(0, 10_000)] = Field(
        math.nan, description="the same in mm, instead of `shift_cm`"
    )
    twist_deg: Annotated[_Degrees, Field(ge=-180, le=180), _json_schema_of_number_cell(-180, 180)] = Field(
        math.nan,
        description="rotation about the vertical of a stone that stands, degrees; clockwise from above is positive",
    )
    lat: Annotated[_Degrees, Field(ge=-90, le=90), _json_schema_of_number_cell(-90, 90)] = Field(
        math.nan, description="latitude, decimal degrees, north positive"
    )
    lon: Annotated[_Degrees, Field(ge=-180, le=180), _json_schema_of_number_cell(-180, 180)] = Field(
        math.nan, description="longitude, decimal degrees, east positive"
    )
    x: _Coordinate = Field(math.nan, description="coordinate to the east in a plan or projection, m")
    y: _Coordinate = Field(math.nan, description="coordinate to the north in a plan or projection, m")
    note: str = Field("", description="a remark")
    photo: str = Field("", description="name or address of a photograph")

    @model_validator(mode="after")
    def _check_columns_do_not_contradict(self, info: ValidationInfo) -> "SurveyRow":
        """Raise a ValueError with a line for each contradiction between columns of this row."""
        context = info.context or {}
        faults = [
            message
            for columns, message in self._column_contradictions()
            if not columns & context.get("faulty", set()) and not ("fell" in columns and context.get("no_outcome"))
        ]
        if faults:
            raise ValueError("\n".join(faults))
        return self

    def _column_contradictions(self) -> Iterator[tuple[set[str], str]]:
        """Yield the columns and a message for each contradiction between columns of this row."""
        exact, outcome = math.isfinite(self.azimuth_deg.azimuth_deg), self.outcome
        directed = exact or self.octant is not None
        if exact and self.octant is not None:
            named = f"azimuth_deg {self.azimuth_deg.azimuth_deg:g} and octant {OCTANTS[self.octant]}"
            yield {"azimuth_deg", "octant"}, f"{named}: give azimuth_deg or octant, not both"
        if directed and math.isfinite(outcome.fall_direction.azimuth_deg):
            yield (
                {"azimuth_deg", "octant", "outcome"},
                "outcome: names a direction, and so does azimuth_deg or octant; give it once",
            )
        if directed and outcome.states_unknown_fall_direction:
            yield (
                {"azimuth_deg", "octant", "outcome"},
                "outcome: the direction is not known, but azimuth_deg or octant gives one; empty one of them",
            )
        if not (self.stated_outcomes or directed):
            yield (
                {"fell", "outcome", "azimuth_deg", "octant", "shift_cm", "shift_mm", "twist_deg"},
                "fell: empty, and no direction; write no for a stone that stood, yes for one that fell in an unknown "
                "direction",
            )
        if self.fell is not None and outcome.kinds and self.fell != ("fell" in outcome.kinds):
            said = "yes" if self.fell else "no"
            yield {"fell", "outcome"}, f"fell: {said}, but outcome {', '.join(outcome.kinds)}; give one of them"
        elif directed and (self.fell is False or "stands" in outcome.kinds):
            yield (
                {"fell", "outcome", "azimuth_deg", "octant"},
                "fell: a stone that stood has no fall direction; empty azimuth_deg and octant",
            )
        yield from self._half_given_position_or_repeated_shift_messages()

    def _half_given_position_or_repeated_shift_messages(self) -> Iterator[tuple[set[str], str]]:
        """Yield the columns and a message for each incomplete position, and each shift or twist that is given twice."""
        for first, second in (("lat", "lon"), ("x", "y")):
            given = [name for name in (first, second) if math.isfinite(getattr(self, name))]
            if len(given) == 1:
                other = second if given[0] == first else first
                yield {first, second}, f"{given[0]}: without {other}; give both coordinates or none"
        shifts = [one for one in (self.shift_cm, self.shift_mm, self.outcome.shift_m) if math.isfinite(one)]
        if len(shifts) > 1:
            yield {"shift_cm", "shift_mm", "outcome"}, "shift: given more than once; give it in one column"
        if math.isfinite(self.twist_deg) and math.isfinite(self.outcome.clockwise_twist_deg):
            yield {"twist_deg", "outcome"}, "twist_deg: outcome gives the twist as well; give it once"
        if self.outcome.twist_sense_if_angle_not_stated and self.twist_deg < 0:
            yield (
                {"twist_deg", "outcome"},
                "twist_deg: has a sign, and outcome states clockwise or anticlockwise; give one of them",
            )

    @property
    def stated_outcomes(self) -> tuple[OutcomeKind, ...]:
        """Outcomes of the stone in this row, such as "fell" or "shifted", from all columns that state one."""
        unmoved = {"shifted": self.shift_m == 0.0, "twisted": self.clockwise_twist_deg == 0.0}
        kinds: list[OutcomeKind] = [kind for kind in self.outcome.kinds if not unmoved.get(kind)]
        if self.outcome.kinds and not kinds:
            kinds = ["stands"]
        if self.fell is not None and not kinds:
            kinds = ["fell" if self.fell else "stands"]
        if self.shift_cm > 0 or self.shift_mm > 0:
            kinds.append("shifted")
        if abs(self.twist_deg) > 0:
            kinds.append("twisted")
        if not kinds and math.isfinite(min(self.shift_cm, self.shift_mm, abs(self.twist_deg), key=math.isnan)):
            kinds = ["stands"]  # a shift or twist of 0
        if not kinds and (math.isfinite(self.azimuth_deg.azimuth_deg) or self.octant is not None):
            kinds = ["fell"]
        return tuple(dict.fromkeys(kinds))

    @property
    def counted_as(self) -> Literal["fell", "stands", "not counted"]:
        """Class of the stone in statistics: "fell", "stands" or "not counted".

        A stone that is fixed to its base does not count. Any other stone that fell counts as fallen, also if it broke
        or was repaired later. Otherwise broken and repaired stones do not count, and shifted and twisted ones stand.
        """
        if "fixed" not in self.stated_outcomes and "fell" in self.stated_outcomes:
            return "fell"
        return "not counted" if set(self.stated_outcomes) & set(OUTCOME_KINDS_NOT_COUNTED_AS_STANDING) else "stands"

    @property
    def fall_direction(self) -> StatedDirection:
        """Direction of the fall as the table states it, before adding the declination; NaN if not stated."""
        if self.octant is not None:
            return StatedDirection(45.0 * self.octant, 2 * self.octant)
        given = self.azimuth_deg
        return given if math.isfinite(given.azimuth_deg) else self.outcome.fall_direction

    @property
    def shift_m(self) -> float:
        """Shift of the base, m; NaN if not given."""
        shifts = (self.shift_cm / 100, self.shift_mm / 1000, self.outcome.shift_m)
        return next((one for one in shifts if math.isfinite(one)), math.nan)

    @property
    def clockwise_twist_deg(self) -> float:
        """Rotation of the stone about the vertical, degrees, clockwise seen from above positive; NaN if not stated."""
        sense = self.outcome.twist_sense_if_angle_not_stated or 1
        return sense * self.twist_deg if math.isfinite(self.twist_deg) else self.outcome.clockwise_twist_deg

    @classmethod
    def validate_cells(
        cls,
        cell_text_by_column: dict[str, str],
        format_error_messages: Callable[[ValidationError, type[BaseModel], dict[str, str]], list[str]],
        *,
        requires_outcome: bool = True,
    ) -> tuple["SurveyRow | None", list[str]]:
        """Validate the cells of a survey row; return the row (None if invalid) and all error messages.

        If one cell is wrong, the rules that relate the other columns to each other are still checked. If
        `requires_outcome` is False, a row without any outcome is no error.
        """
        context: dict[str, Any] = {"no_outcome": not requires_outcome}
        adapter = TypeAdapter(cls)
        try:
            return adapter.validate_python(cell_text_by_column, context=context), []
        except ValidationError as problem:
            messages = format_error_messages(problem, cls, cell_text_by_column)
            faulty = {str(one["loc"][0]) for one in problem.errors() if one["loc"]}
        if faulty:
            context["faulty"] = faulty
            sound = {column: cell for column, cell in cell_text_by_column.items() if column not in faulty}
            try:
                adapter.validate_python(sound, context=context)
            except ValidationError as problem:
                messages += format_error_messages(problem, cls, sound)
        return None, messages


SURVEY_COLUMNS = tuple(SurveyRow.model_fields)
"""Columns a survey may have; one of ``azimuth_deg``, ``octant``, ``fell`` and ``outcome`` is needed."""


def survey_row_json_schema_text() -> str:
    """Return the JSON schema of a row of a survey table as text, with the columns as keys."""
    schema = SurveyRow.model_json_schema(mode="validation")
    for column in schema["properties"].values():
        column.pop("default", None)  # an empty cell, which a JSON object leaves out
        column.pop("title", None)
    schema["additionalProperties"] = {"type": ["string", "number", "boolean", "null"]}
    schema["description"] = "Columns of a survey table for `overturning survey`. Other columns are not used."
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
