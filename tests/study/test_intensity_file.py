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
def table(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    folder = tmp_path_factory.mktemp("intensity")
    study = study_from_content({"name": "x", "records": {"use": ["sine", "three"]}, "azimuth": {"step": 30}}, "x.yaml")
    sine = record_of_pulse(parse_pulse("sine amplitude_gal=300 period_s=1 azimuth_deg=60"), "sine")
    three = Record("three", sine.north, sine.east, 0.5 * sine.north, sine.sampling_interval)
    records = [sine, process_record(three, [Highpass(corner_hz=0.2)])]
    for name in ("one.nc", "two.nc"):
        write_intensity_measures(study, records, folder / name)
    assert (folder / "one.nc").read_bytes() == (folder / "two.nc").read_bytes()
    return xr.open_dataset(folder / "one.nc")


def test_measures_by_azimuth_and_of_whole_records(table: xr.Dataset) -> None:
    assert float(table.pga.isel(record=0).sel(azimuth=60)) == pytest.approx(3.0)
    assert float(table.pga.isel(record=0).sel(azimuth=150)) < 1e-12
    np.testing.assert_allclose(table.pga_rotd.isel(record=0), [0, 3 / np.sqrt(2), 3], atol=0.03)
    assert table.psa_rotd.sizes == {"record": 2, "percentile": 3, "period": 61}
    assert np.isnan(table.jma_intensity[0])
    assert 4.5 < float(table.jma_intensity[1]) < 6.5
    assert table.record_id.values.tolist() == ["sine", "three"]
    # Twenty per decade of periods from 0.01 to 10 s, and of frequencies from 0.1 to 50 Hz.
    for axis, ends in ((table.period, [0.01, 10.0]), (table.frequency, [0.1, 50.0])):
        np.testing.assert_allclose(axis[[0, -1]], ends)
        np.testing.assert_allclose(axis.values[1:] / axis.values[:-1], 10**0.05, rtol=1e-4)


def test_the_periods_of_a_population_are_among_those_of_the_spectra(tmp_path: Path) -> None:
    """An oscillator of another period than the ground's has its closed form in the tests of the spectra."""
    given = {"name": "x", "records": {"use": ["sine"]}, "azimuth": {"step": 90}, "population": {"period": ["0.5 s", 1]}}
    sine = record_of_pulse(parse_pulse("sine amplitude_gal=300 period_s=1 azimuth_deg=60"), "sine")
    write_intensity_measures(study_from_content(given, "x.yaml"), [sine], tmp_path / "one.nc")
    with xr.open_dataset(tmp_path / "one.nc") as table:
        assert table.period.size == 62  # 1 s is one of the twenty per decade
        (psa,) = rotd_percentile_measures(Motion.of(sine), [0.5], percentiles=[50])["psa"]
        assert table.psa_rotd.sel(percentile=50, period=0.5).values == pytest.approx(psa)


def test_the_file_has_peaks_before_and_after_processing(table: xr.Dataset) -> None:
    assert np.isnan(table.pgd_processed[0])
    # one cycle of a sine from rest leaves a drift of A T²/2π per period, which the filter takes away
    assert float(table.pgd_processed[1]) < 0.7 * float(table.pgd_unprocessed[1])


def test_the_file_passes_the_checker_of_its_convention(table: xr.Dataset) -> None:
    program = Path(sys.executable).with_name("compliance-checker")
    path = table.encoding["source"]
    done = subprocess.run(
        [program, "--test", "cf:1.11", "--criteria", "lenient", path], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-1500:]
