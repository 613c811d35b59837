"""Files in the folder of a record that may hold its vertical component."""

import os.path
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from overturning.records.axis_direction import is_vertical_axis_name_without_up_or_down
from overturning.records.component import RecordComponent

MAX_FILES_SEARCHED_FOR_VERTICAL_COMPONENT: Final = 6
"""Largest number of files that are searched, most similar names first."""

MAX_SEARCHED_FILE_BYTES: Final = 10_000_000
"""Size of the largest file that is searched, bytes."""


def is_vertical_component(component: RecordComponent) -> bool:
    """Return True if a component points up, down, or along a vertical axis of unknown sense."""
    return bool(component.vertical_sense) or is_vertical_axis_name_without_up_or_down(component.axis_name_in_file)


def find_nearby_files_by_name_similarity(paths_of_one_record: Sequence[Path]) -> list[Path]:
    """Return files next to a record's file with the same extension or stem, the most similar names first."""
    first, names = paths_of_one_record[0], {path.name for path in paths_of_one_record}
    others = [
        other
        for other in sorted(first.parent.iterdir())
        if (other.suffix.lower() == first.suffix.lower() or other.stem == first.stem) and other.name not in names
    ]
    # Similarity is the length of the common prefix of two names (not paths).
    others.sort(key=lambda other: -len(os.path.commonprefix([other.name, first.name])))  # noqa: RUF071
    return [
        p
        for p in others[:MAX_FILES_SEARCHED_FOR_VERTICAL_COMPONENT]
        if p.is_file() and p.stat().st_size <= MAX_SEARCHED_FILE_BYTES
    ]
