"""Sort components into records by what their files state."""

from collections.abc import Iterable, Sequence

from overturning.records.assembly import MAX_SPREAD_S
from overturning.records.component import Component, seed_sensor


def group_components(components: Iterable[Component]) -> list[list[Component]]:
    """Sort components into records, in the order of first appearance.

    Components of one record have the same format, station, place, event, sensor with its SEED band (HN of HNE) and
    location, and starts at most 0.5 s apart. Components without metadata (declared columns) belong to one record if
    they are in one file.
    """
    groups: list[list[Component]] = []
    for component in components:
        home = next((g for g in groups if in_one_record(g, component)), None)
        if home is None:
            groups.append([component])
        else:
            home.append(component)
    return groups


def in_one_record(group: Sequence[Component], component: Component) -> bool:
    """Return True if a component belongs to the record of a group, by what their files state."""
    first = group[0]
    if first.location and component.location and first.location != component.location:
        return False
    if (
        len({seed_sensor(first), seed_sensor(component)} - {""}) > 1
    ):  # Two bands of one sensor (BN, HN), or two sensors.
        return False
    if first.file == component.file and first.sha256 == component.sha256:
        # The second occurrence of an axis in one file begins another record.
        return first.sensor == component.sensor and not any(
            c.axis == component.axis and c.start == component.start for c in group
        )
    if component.sisters and component.sisters == first.sisters:
        return all(c.axis != component.axis for c in group)
    if not (component.station or component.event):
        return False
    alike = ("format", "station", "event", "latitude", "longitude", "sensor", "processed")
    if first.start is None or component.start is None:
        near = first.start is component.start
    else:
        near = abs((first.start - component.start).total_seconds()) <= MAX_SPREAD_S
    same = all(getattr(first, name) == getattr(component, name) for name in alike)
    return same and near and all(c.axis != component.axis for c in group)
