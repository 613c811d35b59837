"""Files in the folder of a record that may hold its vertical component."""

import os.path
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from overturning.records.component import Component, is_vertical_of_unknown_sense

MOST_BESIDE: Final = 6
"""Files that are looked at, those whose names are most alike."""

LARGEST_BESIDE: Final = 10_000_000
"""Size of the largest file that is looked at, bytes."""


def is_vertical(component: Component) -> bool:
    """Return True if a component points up, down, or along a vertical axis of unknown sense."""
    return bool(component.vertical) or is_vertical_of_unknown_sense(component.axis)


def most_alike(paths: Sequence[Path]) -> list[Path]:
    """Other small files of the folder, with the extension or the stem of the first one, most alike first."""
    first, names = paths[0], {path.name for path in paths}
    others = [
        other
        for other in sorted(first.parent.iterdir())
        if (other.suffix.lower() == first.suffix.lower() or other.stem == first.stem) and other.name not in names
    ]
    # Of names, not of paths: as many letters as they have in common.
    others.sort(key=lambda other: -len(os.path.commonprefix([other.name, first.name])))  # noqa: RUF071
    return [p for p in others[:MOST_BESIDE] if p.is_file() and p.stat().st_size <= LARGEST_BESIDE]
