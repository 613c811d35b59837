import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from overturning.motion.motion import Motion
from overturning.motion.spectra import rotd_percentile_measures
from overturning.records.processing import process_record
from overturning.records.pulses import parse_pulse, record_of_pulse
from overturning.records.record import Record
from overturning.records.steps import Highpass
from overturning.study.intensity import write_intensity_measures
from overturning.study.load import study_from_content

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def intensity_measures(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """Intensity measures of a sine pulse and of a record with a vertical component, as written to a file."""
    folder = tmp_path_factory.mktemp("intensity")
    study = study_from_content({"name": "x", "records": {"use": ["sine", "three"]}, "azimuth": {"step": 30}}, "x.yaml")
    sine = record_of_pulse(parse_pulse("sine amplitude_gal=300 period_s=1 azimuth_deg=60"), "sine")
    three = Record("three", sine.north, sine.east, 0.5 * sine.north, sine.sampling_interval)
    records = [sine, process_record(three, [Highpass(corner_hz=0.2)])]
    for name in ("one.nc", "two.nc"):
        write_intensity_measures(study, records, folder / name)
    assert (folder / "one.nc").read_bytes() == (folder / "two.nc").read_bytes()
    return xr.open_dataset(folder / "one.nc")


def test_the_intensity_file_has_measures_by_azimuth_and_of_whole_records(intensity_measures: xr.Dataset) -> None:
    assert float(intensity_measures.pga.isel(record=0).sel(azimuth=60)) == pytest.approx(3.0)
    assert float(intensity_measures.pga.isel(record=0).sel(azimuth=150)) < 1e-12
    np.testing.assert_allclose(intensity_measures.pga_rotd.isel(record=0), [0, 3 / np.sqrt(2), 3], atol=0.03)
    assert intensity_measures.psa_rotd.sizes == {"record": 2, "percentile": 3, "period": 61}
    assert np.isnan(intensity_measures.jma_intensity[0])
    assert 4.5 < float(intensity_measures.jma_intensity[1]) < 6.5
    assert intensity_measures.record_id.values.tolist() == ["sine", "three"]
    # Twenty per decade of periods from 0.01 to 10 s, and of frequencies from 0.1 to 50 Hz.
    for axis, ends in ((intensity_measures.period, [0.01, 10.0]), (intensity_measures.frequency, [0.1, 50.0])):
        np.testing.assert_allclose(axis[[0, -1]], ends)
        np.testing.assert_allclose(axis.values[1:] / axis.values[:-1], 10**0.05, rtol=1e-4)


def test_the_spectra_include_the_periods_of_a_population(tmp_path: Path) -> None:
    """The spectra have their own 61 periods, and 0.5 s, a period in the key `population` of the study.

    The PSA at this period is that which the spectra module computes.
    """
    given = {"name": "x", "records": {"use": ["sine"]}, "azimuth": {"step": 90}, "population": {"period": ["0.5 s", 1]}}
    sine = record_of_pulse(parse_pulse("sine amplitude_gal=300 period_s=1 azimuth_deg=60"), "sine")
    write_intensity_measures(study_from_content(given, "x.yaml"), [sine], tmp_path / "one.nc")
    with xr.open_dataset(tmp_path / "one.nc") as table:
        assert table.period.size == 62  # 1 s is one of the twenty per decade
        (psa,) = rotd_percentile_measures(Motion.of(sine), [0.5], percentiles_over_azimuths=[50])["psa"]
        assert table.psa_rotd.sel(percentile=50, period=0.5).values == pytest.approx(psa)


def test_the_intensity_file_has_peaks_before_and_after_processing(intensity_measures: xr.Dataset) -> None:
    assert np.isnan(intensity_measures.pgd_processed[0])
    # one cycle of a sine from rest leaves a drift of A T²/2π per period, which the filter takes away
    assert float(intensity_measures.pgd_processed[1]) < 0.7 * float(intensity_measures.pgd_unprocessed[1])


def test_the_intensity_file_passes_the_cf_convention_checker(intensity_measures: xr.Dataset) -> None:
    program = Path(sys.executable).with_name("compliance-checker")
    path = intensity_measures.encoding["source"]
    done = subprocess.run(
        [program, "--test", "cf:1.11", "--criteria", "lenient", path], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-1500:]
