"""Intensity measures of every record of a study along every azimuth: intensity.nc."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from overturning.arrays import FloatArray
from overturning.files import atomic_write
from overturning.motion.fourier import amplitude_spectrum, konno_ohmachi
from overturning.motion.intensity import PEAKS, intensity_by_azimuth, record_measures
from overturning.motion.motion import Motion
from overturning.motion.spectra import rotd
from overturning.records.record import Record
from overturning.study.config import Study
from overturning.study.grid import grid_of

PERCENTILES = (0.0, 50.0, 100.0)
SPECTRUM_PERIODS = np.geomspace(0.01, 10.0, 61)
"""Periods of the spectra in the file, s: twenty per decade."""

FREQUENCIES = np.geomspace(0.1, 50.0, 55)
"""Frequencies of the smoothed Fourier spectra, Hz: twenty per decade."""


def write_intensity(study: Study, records: Sequence[Record], path: Path) -> None:
    """Write the intensity measures of all processed records, in the order of the cube, along the study's azimuths.

    The file (NetCDF) holds the measures by azimuth (``record, azimuth``), those of whole records (JMA intensity, RotD of PGA
    and PGV, peaks before and after processing), and RotD spectra and Fourier amplitude spectra (``record, period`` and
    ``record, frequency``).
    """
    import xarray as xr

    azimuth = grid_of(study).azimuth
    measures = [intensity_by_azimuth(Motion.of(record), azimuth) for record in records]
    table = xr.concat(measures, dim="record", combine_attrs="override", coords="minimal", compat="override")
    table = table.assign_coords(
        record=("record", np.arange(len(records), dtype=np.int32), {"long_name": "number of the record"}),
        record_id=("record", [record.record_id for record in records], {"long_name": "identifier of the record"}),
    )
    table = table.assign(_of_records(records))
    table.attrs = {"Conventions": "CF-1.11", "title": f"{study.title or study.name}: intensity by azimuth"}
    # A coordinate has no missing values, and CF forbids it to say what they would look like.
    for name in table.coords:
        table[name].encoding["_FillValue"] = None
    with atomic_write(path) as part:
        table.to_netcdf(part, engine="netcdf4")


def _of_records(records: Sequence[Record]) -> dict[str, Any]:
    """Variables of whole records; missing (not a number) where a record has no such measure."""
    columns = [record_measures(Motion.of(record), record.processing) for record in records]

    def column(name: str) -> FloatArray:
        return np.array([np.nan if one[name] is None else one[name] for one in columns], dtype=np.float64)

    variables: dict[str, Any] = {
        "jma_intensity": (
            "record",
            column("jma_intensity"),
            {"units": "1", "long_name": "JMA instrumental intensity; missing without a vertical component"},
        ),
        "percentile": (
            "percentile",
            np.array(PERCENTILES),
            {"units": "percent", "long_name": "percentile over azimuths"},
        ),
        "period": ("period", SPECTRUM_PERIODS, {"units": "s", "long_name": "period of the oscillator"}),
        "frequency": ("frequency", FREQUENCIES, {"units": "Hz", "long_name": "frequency"}),
    }
    for name, (unit, long_name) in PEAKS.items():
        for when, words in (("unprocessed", "before processing"), ("processed", "after processing")):
            variables[f"{name}_{when}"] = (
                "record",
                column(f"{name}_{when}"),
                {
                    "units": unit,
                    "long_name": f"{long_name}, larger of north and east, {words}; missing where left alone",
                },
            )
    spectra = [rotd(Motion.of(record), SPECTRUM_PERIODS, percentiles=PERCENTILES) for record in records]
    for name, unit in (("pga", "m s-2"), ("pgv", "m s-1")):
        values = np.stack([one[name] for one in spectra])
        about = {"units": unit, "long_name": f"{PEAKS[name][1]}, RotD"}
        variables[f"{name}_rotd"] = (("record", "percentile"), values, about)
    variables["psa_rotd"] = (
        ("record", "percentile", "period"),
        np.stack([one["psa"] for one in spectra]),
        {"units": "m s-2", "long_name": "pseudo-acceleration, damping ratio 0.05, RotD"},
    )
    for name in ("north", "east"):
        variables[f"fourier_{name}"] = (
            ("record", "frequency"),
            np.stack([_smoothed(getattr(record, name), record.sampling_interval) for record in records]),
            {"units": "m s-1", "long_name": f"Fourier amplitude of {name}, smoothed after Konno and Ohmachi, b = 40"},
        )
    return variables


def _smoothed(samples: FloatArray, interval: float) -> FloatArray:
    """Smoothed Fourier amplitude at the common frequencies; not a number beyond the record's Nyquist frequency."""
    frequency, amplitude = amplitude_spectrum(samples, interval)
    inside = frequency[-1] >= FREQUENCIES
    values = np.full(FREQUENCIES.size, np.nan)
    values[inside] = konno_ohmachi(frequency, amplitude, FREQUENCIES[inside])
    return values
