"""Which files and components make one record."""

from collections.abc import Iterable, Sequence
from datetime import datetime
from pathlib import Path

from overturning.records.assembly import MAXIMUM_SPREAD
from overturning.records.component import Component


def group_components(components: Iterable[Component]) -> list[list[Component]]:
    """Sort components into records, in the order of first appearance.

    Those of one record have the same format, station, place, event and sensor, and starts at most 0.5 s apart. Components
    that say nothing about themselves (declared columns) belong together when they are of one file.
    """
    groups: list[list[Component]] = []
    for component in components:
        home = next((g for g in groups if _together(g, component)), None)
        if home is None:
            groups.append([component])
        else:
            home.append(component)
    return groups


def _together(group: Sequence[Component], component: Component) -> bool:
    first = group[0]
    if first.file == component.file and first.sha256 == component.sha256:
        # In one file an axis that comes twice begins another record, except another sensor's.
        return first.sensor == component.sensor and not any(
            c.axis == component.axis and c.start == component.start for c in group
        )
    if not (component.station or component.event):
        return False
    same = all(
        getattr(first, name) == getattr(component, name)
        for name in ("format", "station", "event", "latitude", "longitude", "sensor", "processed")
    )
    return same and _near(first.start, component.start) and all(c.axis != component.axis for c in group)


def _near(first: datetime | None, second: datetime | None) -> bool:
    if first is None or second is None:
        return first is second
    return abs((first - second).total_seconds()) <= MAXIMUM_SPREAD


def sisters(path: Path) -> list[Path]:
    """Files that may hold the other components of a one-component file, by name, the file itself first.

    They lie in the same folder, and have the same stem with another extension, or a name of the same length that differs in
    one stretch of at most three characters (``0111a.smc``, ``RSN1063_NORTHR_RRS228.AT2``).
    """
    files = [path]
    for other in sorted(path.parent.iterdir()):
        if other == path or not other.is_file():
            continue
        same_stem = other.stem == path.stem and len(other.suffix) <= 5
        if same_stem or _differs_in_one_stretch(path.name, other.name):
            files.append(other)
    return files


def _differs_in_one_stretch(first: str, second: str) -> bool:
    if len(first) != len(second) or Path(first).suffix.lower() != Path(second).suffix.lower():
        return False
    differing = [i for i, (a, b) in enumerate(zip(first, second, strict=True)) if a != b]
    return bool(differing) and differing[-1] - differing[0] < 3
