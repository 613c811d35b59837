"""docs/formats.md names every format, column, step and pulse that there is."""

from pathlib import Path
from typing import get_args

import pytest

from overturning.records.catalogue import RecordEntry
from overturning.records.detect import FORMATS
from overturning.records.options import UNITS
from overturning.records.processing import Step
from overturning.records.pulses import SHAPES, Pulse

TEXT = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")


def models(union: object) -> tuple[type, ...]:
    return get_args(get_args(union)[0])


NAMES = {
    *(form.name for form in FORMATS),
    "fema-p695",
    "synthetic",
    *RecordEntry.model_fields,
    *SHAPES,
    *(model.model_fields["step"].default for model in models(Step)),
    *(
        name
        for model in (*models(Step), *models(Pulse))
        for name in model.model_fields
        if name not in ("step", "shape")
    ),
}


@pytest.mark.parametrize("name", sorted(NAMES))
def test_the_documentation_names_it(name):
    assert f"`{name}`" in TEXT


def test_the_documentation_has_a_row_per_format_and_every_unit():
    rows = [line for line in TEXT.splitlines() if line.startswith("| `")]
    for form in FORMATS:
        assert any(row.startswith(f"| `{form.name}` |") for row in rows), form.name
    for unit in UNITS:
        assert unit in TEXT
