"""Intensity measures of every record of a study along every azimuth: intensity.nc."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from overturning.files import whole
from overturning.motion.intensity import intensity_by_azimuth
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.study.config import Study
from overturning.study.grid import Grid


def write_intensity(study: Study, records: Sequence[Record], path: Path) -> None:
    """Write the intensity measures of all records along the study's azimuths.

    Parameters
    ----------
    study : Study
        The study; only its azimuths matter.
    records : sequence of Record
        The processed records, in the order of the cube.
    path : Path
        NetCDF file to make, dimensions ``record, azimuth``.
    """
    import xarray as xr

    azimuth = Grid.of(study).azimuth
    measures = [intensity_by_azimuth(Motion.of(record), azimuth) for record in records]
    table = xr.concat(measures, dim="record", combine_attrs="override", coords="minimal", compat="override")
    table = table.assign_coords(
        record=("record", np.arange(len(records), dtype=np.int32), {"long_name": "number of the record"}),
        record_id=("record", [record.record_id for record in records], {"long_name": "identifier of the record"}),
    )
    table.attrs = {"Conventions": "CF-1.11", "title": f"{study.title or study.name}: intensity by azimuth"}
    with whole(path) as part:
        table.to_netcdf(part, engine="netcdf4")
