"""Intensity measures of every record of a study along every azimuth: intensity.nc."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from overturning.arrays import FloatArray, keep_xarray_from_importing_dask
from overturning.files import atomic_write
from overturning.motion.fourier import fourier_amplitude_spectrum, konno_ohmachi_smoothed_amplitude
from overturning.motion.heading import azimuths_of_peak_acceleration_and_velocity, strongest_pulse_axis_deg_and_period_s
from overturning.motion.intensity import (
    PEAK_UNITS_AND_LONG_NAMES,
    intensity_dataset_by_azimuth,
    jma_intensity_and_raw_and_processed_peaks,
)
from overturning.motion.motion import Motion
from overturning.motion.spectra import rotd_percentile_measures
from overturning.records.earthquakes import assign_records_to_earthquakes
from overturning.records.record import Record
from overturning.study.scenes import directions_as_int16_if_whole
from overturning.study.schema import Study

ROTD_PERCENTILES = (0.0, 50.0, 100.0)
SPECTRUM_PERIODS_S = np.geomspace(0.01, 10.0, 61)
"""Periods of the spectra in the file, s, 20 per decade; periods of a population are added."""

FOURIER_SPECTRUM_FREQUENCIES_HZ = np.geomspace(0.1, 50.0, 55)
"""Frequencies of the smoothed Fourier spectra, Hz, 20 per decade."""


def write_intensity_measures(study: Study, records: Sequence[Record], output_path: Path) -> None:
    """Compute intensity measures, such as PGA, of all records along a study's azimuths; write them as NetCDF.

    The file holds the measures by azimuth (``record, azimuth``), those of whole records (JMA intensity, RotD
    of PGA and PGV, peaks before and after processing), and RotD spectra and Fourier amplitude spectra
    (``record, period`` and ``record, frequency``).
    """
    import xarray as xr

    keep_xarray_from_importing_dask()
    azimuth = directions_as_int16_if_whole(study.azimuth.expand_azimuths())
    measures = [intensity_dataset_by_azimuth(Motion.of(record), azimuth) for record in records]
    table = xr.concat(measures, dim="record", combine_attrs="override", coords="minimal", compat="override")
    table = table.assign_coords(
        record=("record", np.arange(len(records), dtype=np.int32), {"long_name": "number of the record"}),
        record_id=("record", [record.record_id for record in records], {"long_name": "identifier of the record"}),
        event=(
            "record",
            list(assign_records_to_earthquakes(records).earthquake_labels_in_record_order),
            {"long_name": "earthquake, one name for each"},
        ),
    )
    own = study.population.period if study.population else ()
    table = table.assign(_azimuth_independent_measure_variables(records, np.unique([*SPECTRUM_PERIODS_S, *own])))
    table.attrs = {"Conventions": "CF-1.11", "title": f"{study.title or study.name}: intensity by azimuth"}
    # CF forbids a fill value for coordinates.
    for name in table.coords:
        table[name].encoding["_FillValue"] = None
    with atomic_write(output_path) as part:
        table.to_netcdf(part, engine="netcdf4")


def _azimuth_independent_measure_variables(
    records: Sequence[Record], oscillator_periods_s: FloatArray
) -> dict[str, Any]:
    """Compute the intensity measures that do not depend on azimuth; return dataset variables by name."""
    motions = [Motion.of(record) for record in records]
    columns = [
        jma_intensity_and_raw_and_processed_peaks(motion, record.processing)
        for motion, record in zip(motions, records, strict=True)
    ]
    spectra = [
        rotd_percentile_measures(motion, oscillator_periods_s, percentiles_over_azimuths=ROTD_PERCENTILES)
        for motion in motions
    ]
    variables: dict[str, Any] = {}

    def add_variable(
        measure_name: str, space_separated_dimension_names: str, measure_values: Any, units: str, long_name: str
    ) -> None:
        """Add an intensity measure with its unit and description; dimension names are separated by blanks."""
        variables[measure_name] = (
            space_separated_dimension_names.split(),
            np.asarray(measure_values),
            {"units": units, "long_name": long_name},
        )

    def add_measure_by_record(measure_name: str, units: str, long_name: str) -> None:
        """Add an intensity measure with one value per record; NaN where it is undefined."""
        add_variable(
            measure_name,
            "record",
            [np.nan if one[measure_name] is None else one[measure_name] for one in columns],
            units,
            long_name,
        )

    add_measure_by_record("jma_intensity", "1", "JMA instrumental intensity; missing without a vertical component")
    add_measure_by_record(
        "jma_intensity_horizontal", "1", "JMA instrumental intensity of the horizontal components alone"
    )
    for name, long_name in (("pga", "acceleration"), ("pgv", "velocity")):
        towards = [azimuths_of_peak_acceleration_and_velocity(motion)[name] for motion in motions]
        add_variable(
            f"{name}_azimuth", "record", towards, "degree", f"azimuth to which the peak horizontal {long_name} points"
        )
    vertical = [np.nan if motion.up is None else np.max(np.abs(motion.up)) for motion in motions]
    add_variable(
        "pga_vertical", "record", vertical, "m s-2", "peak vertical acceleration; missing without a vertical component"
    )
    axes, of_pulse = zip(*map(strongest_pulse_axis_deg_and_period_s, motions), strict=True)
    add_variable("pulse_axis", "record", axes, "degree", "axis of the strongest velocity pulse")
    add_variable("pulse_period", "record", of_pulse, "s", "period of the strongest velocity pulse")
    add_variable("percentile", "percentile", ROTD_PERCENTILES, "percent", "percentile over azimuths")
    add_variable("period", "period", oscillator_periods_s, "s", "period of the oscillator")
    add_variable("frequency", "frequency", FOURIER_SPECTRUM_FREQUENCIES_HZ, "Hz", "frequency")
    for name, (units, long_name) in PEAK_UNITS_AND_LONG_NAMES.items():
        larger = f"{long_name}, larger of north and east"
        for when in ("before", "after"):
            state = "unprocessed" if when == "before" else "processed"
            add_measure_by_record(f"{name}_{state}", units, f"{larger}, {when} processing; missing where left alone")
    for name, units in (("pga", "m s-2"), ("pgv", "m s-1")):
        add_variable(
            f"{name}_rotd",
            "record percentile",
            [one[name] for one in spectra],
            units,
            f"{PEAK_UNITS_AND_LONG_NAMES[name][1]}, RotD",
        )
    psa = "pseudo-acceleration, damping ratio 0.05, RotD"
    add_variable("psa_rotd", "record percentile period", [one["psa"] for one in spectra], "m s-2", psa)
    for name in ("north", "east"):
        values = [_smoothed_fourier_amplitude(getattr(record, name), record.sampling_interval) for record in records]
        smoothed = f"Fourier amplitude of {name}, smoothed after Konno and Ohmachi, b = 40"
        untold = "missing where the record is too short to tell, and beyond its Nyquist frequency"
        add_variable(f"fourier_{name}", "record frequency", values, "m s-1", f"{smoothed}; {untold}")
    return variables


def _smoothed_fourier_amplitude(acceleration_samples_m_s2: FloatArray, sampling_interval_s: float) -> FloatArray:
    """Return Konno–Ohmachi Fourier amplitudes at `FOURIER_SPECTRUM_FREQUENCIES_HZ`, m/s; NaN above Nyquist."""
    frequency, amplitude = fourier_amplitude_spectrum(acceleration_samples_m_s2, sampling_interval_s)
    inside = frequency[-1] >= FOURIER_SPECTRUM_FREQUENCIES_HZ
    values = np.full(FOURIER_SPECTRUM_FREQUENCIES_HZ.size, np.nan)
    values[inside] = konno_ohmachi_smoothed_amplitude(frequency, amplitude, FOURIER_SPECTRUM_FREQUENCIES_HZ[inside])
    return values
