"""docs/formats.md names every format, column, processing step and pulse."""

import re
from pathlib import Path
from typing import get_args

from overturning.records.catalogue import RecordTableRow
from overturning.records.formats.table import RECORD_FILE_FORMATS
from overturning.records.processing import Step
from overturning.records.pulses import PULSE_SHAPES, Pulse
from overturning.units import ACCELERATION_UNITS_IN_M_S2

FORMATS_PAGE = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")


def member_types_of_union(union: object) -> tuple[type, ...]:
    """Return the member types (pydantic models) of an annotated union type."""
    return get_args(get_args(union)[0])


NAMES_TO_DOCUMENT = {
    *(form.name for form in RECORD_FILE_FORMATS),
    "fema-p695",
    "synthetic",
    *RecordTableRow.model_fields,
    *PULSE_SHAPES,
    *(model.model_fields["step"].default for model in member_types_of_union(Step)),
    *(
        name
        for model in (*member_types_of_union(Step), *member_types_of_union(Pulse))
        for name in model.model_fields
        if name not in ("step", "shape")
    ),
}


def test_the_formats_page_lists_every_format_name_and_unit():
    rows = set(re.findall(r"^\| `([^`]+)` \|", FORMATS_PAGE, flags=re.MULTILINE))
    assert {form.name for form in RECORD_FILE_FORMATS} - rows == set()
    assert {name for name in NAMES_TO_DOCUMENT if f"`{name}`" not in FORMATS_PAGE} == set()
    assert {unit for unit in ACCELERATION_UNITS_IN_M_S2 if unit not in FORMATS_PAGE} == set()
