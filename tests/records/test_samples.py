"""Real files, if available, are read to the values of their headers and README."""

import os
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

from overturning.motion.motion import Motion
from overturning.motion.spectra import housner_spectrum_intensity
from overturning.records.catalogue import RecordTableRow
from overturning.records.check import check_records_in_files, format_record_check
from overturning.records.processing import process_record
from overturning.records.read import read_record, read_record_without_processing
from overturning.records.source import has_non_record_name
from overturning.records.steps import RemoveMean

ROOT = Path(__file__).parents[2]
SAMPLE_RECORD_FOLDER = Path(os.environ.get("OVERTURNING_SAMPLE_RECORDS", ROOT.parent / "shared" / "records"))
pytestmark = pytest.mark.skipif(
    not SAMPLE_RECORD_FOLDER.is_dir(), reason=f"no folder of sample records ({SAMPLE_RECORD_FOLDER})"
)


def test_the_geonet_te_mara_record_has_its_published_peaks():
    """Kaikoura 2016, WTMC: axes N28W and S62W, 974 and 797 Gal."""
    record = read_record_without_processing(SAMPLE_RECORD_FOLDER / "20161113_110259_WTMC_20.V2A")
    motion = Motion.of(record)
    assert np.abs(motion.acceleration_along(332)).max() * 100 == pytest.approx(973.31, abs=0.01)
    assert np.abs(motion.acceleration_along(242)).max() * 100 == pytest.approx(796.64, abs=0.01)
    assert np.abs(motion.acceleration_along(62)).max() * 100 == pytest.approx(796.64, abs=0.01)
    # the signed peak of N28W is −9733.1 mm/s² at 44.88 s of the buffer, before which 250 samples are put: the sense
    # is kept
    assert motion.acceleration_along(332)[250 + round(44.88 / 0.02)] * 1000 == pytest.approx(-9733.1, abs=0.05)
    assert record.start == "2016-11-13T11:02:14.715Z"


def test_raw_and_processed_geonet_records_correlate_at_equal_times():
    raw = read_record_without_processing(SAMPLE_RECORD_FOLDER / "20161113_110313_THZ_20.V1A")
    done = read_record_without_processing(SAMPLE_RECORD_FOLDER / "20161113_110313_THZ_20.V2A")
    assert np.abs(raw.east).max() * 100 == pytest.approx(39.97, abs=0.01)
    assert np.abs(done.east).max() * 100 == pytest.approx(35.78, abs=0.01)
    ahead = (datetime.fromisoformat(str(raw.start)) - datetime.fromisoformat(str(done.start))).total_seconds()
    assert ahead == 5.0
    later = done.east[round(ahead / done.sampling_interval) :]
    assert np.corrcoef(raw.east[::4][: later.size], later)[0, 1] > 0.97


def test_three_smc_files_become_one_record():
    record = read_record_without_processing(SAMPLE_RECORD_FOLDER / "0111a.smc")
    assert record.up is not None
    assert np.abs(record.north).max() * 100 == pytest.approx(104.41, abs=0.01)
    assert np.abs(record.east).max() * 100 == pytest.approx(70.44, abs=0.01)


def test_csmip_channels_of_different_length_are_cut():
    record = read_record_without_processing(SAMPLE_RECORD_FOLDER / "CICLC.v1")
    assert record.north.size == 31932
    assert record.processing[0]["left_out_s"] == pytest.approx(2.58)
    assert "trusted" not in record.extra
    # values in the headers of the files, .3442498 and .5107992 g
    assert np.abs(record.east).max() / 9.80665 == pytest.approx(0.3442498, rel=1e-5)
    assert np.abs(record.north).max() / 9.80665 == pytest.approx(0.5107992, rel=1e-5)


def test_records_check_gives_a_record_or_a_reason_for_every_example_file():
    files = sorted(p for p in SAMPLE_RECORD_FOLDER.iterdir() if p.is_file() and not has_non_record_name(p))
    findings = check_records_in_files(files)
    named = {name for finding in findings for name in finding.file_names}
    assert named == {p.name for p in files}
    for finding in findings:
        assert (finding.unprocessed_record is None) == bool(finding.refusal_or_skip_reason)
        assert finding.file_names[0] in format_record_check(finding)
    read = {name for f in findings if f.unprocessed_record for name in f.file_names}
    assert {"0111a.smc", "0111b.smc", "0111c.smc", "20161113_110259_WTMC_20.V2A"} <= read


TTRH02_FILES = [
    p for folder in (SAMPLE_RECORD_FOLDER, ROOT / "resources" / "records") for p in folder.glob("TTRH020010061330*")
]

if TTRH02_FILES:

    def test_the_ttrh02_record_has_its_published_spectrum_intensity():
        """KiK-net TTRH02, 2000-10-06, surface, NS: SI (h = 0.2) 113 cm/s. NIED's files are not here."""
        entry = RecordTableRow(id="ttrh02", format="kik-net", source="TTRH020010061330")
        record = process_record(read_record(entry, TTRH02_FILES[0].parent), [RemoveMean()])
        assert housner_spectrum_intensity(Motion.of(record), [0])[0] * 100 == pytest.approx(113, abs=1)
