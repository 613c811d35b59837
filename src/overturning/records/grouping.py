"""Sort components into records by what their files state."""

from collections.abc import Iterable, Sequence

from overturning.records.component import RecordComponent, seed_band_and_instrument_code
from overturning.records.window import MAX_START_OR_DURATION_DIFFERENCE_S


def group_components_by_record(components: Iterable[RecordComponent]) -> list[list[RecordComponent]]:
    """Group components by record; return a list of components per record, in order of first appearance.

    Components of different files belong to one record if they have equal format, network, station, coordinates, event,
    processing state, sensor (surface or borehole), sensor location and SEED band and instrument (HN of HNE), and start
    at most 0.5 s apart; or, for declared columns, if their file names have the same key. In one file, format,
    coordinates, event, processing and start may differ. The second occurrence of an axis begins another record.
    """
    groups: list[list[RecordComponent]] = []
    for component in components:
        home = next((g for g in groups if belongs_to_record(g, component)), None)
        if home is None:
            groups.append([component])
        else:
            home.append(component)
    return groups


def belongs_to_record(record_components: Sequence[RecordComponent], component: RecordComponent) -> bool:
    """Return True if a component belongs to the record of other components, according to their files' metadata."""
    first = record_components[0]
    if first.sensor_location and component.sensor_location and first.sensor_location != component.sensor_location:
        return False
    if len({seed_band_and_instrument_code(first), seed_band_and_instrument_code(component)} - {""}) > 1:
        return False  # two bands of one sensor (BN, HN), or two sensors
    if any(c.axis_name_in_file == component.axis_name_in_file for c in record_components):
        return False
    if first.file_name == component.file_name and first.sha256 == component.sha256:
        alike = first.sensor_position == component.sensor_position and first.station == component.station
        return alike and not _have_different_networks(first, component)
    if (
        component.shared_key_of_record_files
        and component.shared_key_of_record_files == first.shared_key_of_record_files
    ):
        return True
    return bool(component.station or component.event) and _have_equal_record_metadata(first, component)


def _have_equal_record_metadata(first_component: RecordComponent, second_component: RecordComponent) -> bool:
    """Return True if two components agree in the metadata of their record, and start at most 0.5 s apart.

    The metadata are format, network, station, its coordinates, event, sensor (surface or borehole) and processing.
    """
    alike = (
        "format_name",
        "station",
        "event",
        "station_latitude_deg",
        "station_longitude_deg",
        "sensor_position",
        "is_already_corrected",
    )
    if any(getattr(first_component, name) != getattr(second_component, name) for name in alike):
        return False
    if _have_different_networks(first_component, second_component):
        return False
    if first_component.start_time_utc is None or second_component.start_time_utc is None:
        return first_component.start_time_utc is second_component.start_time_utc
    return (
        abs((first_component.start_time_utc - second_component.start_time_utc).total_seconds())
        <= MAX_START_OR_DURATION_DIFFERENCE_S
    )


def _have_different_networks(first_component: RecordComponent, second_component: RecordComponent) -> bool:
    """Return True if two components state different networks; codes of stations are unique only within a network."""
    return len({one.extra_metadata.get("network", "") for one in (first_component, second_component)} - {""}) > 1
