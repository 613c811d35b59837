import dataclasses

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from overturning.errors import ResultError
from overturning.records.record import Record
from overturning.records.store import (
    read_record_from_motion_file,
    round_samples_to_stored_decimals,
    write_record_to_motion_file,
)

sample_array_strategy = arrays(np.float64, 40, elements=st.floats(-50, 50))
text_strategy = st.text(st.characters(blacklist_categories=("Cs", "Cc")), max_size=12)


def assert_same_record(a: Record, b: Record) -> None:
    """Check that all fields of two records are equal."""
    for field in dataclasses.fields(Record):
        left, right = getattr(a, field.name), getattr(b, field.name)
        if isinstance(left, np.ndarray):
            np.testing.assert_array_equal(left, right, err_msg=field.name)
        else:
            assert left == right, field.name


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    sample_array_strategy,
    sample_array_strategy,
    st.one_of(st.none(), sample_array_strategy),
    text_strategy,
    st.floats(0.0005, 0.1),
    st.one_of(st.none(), st.floats(0, 359)),
)
def test_a_record_written_to_a_motion_file_is_read_back_equal(tmp_path, north, east, up, event, interval, strike):
    record = Record(
        "x-1",
        north,
        east,
        up,
        interval,
        start="2001-02-03T04:05:06.5Z",
        event=event,
        sha256="ab" * 32,
        fault_strike_deg=strike,
        latitude=-41.5,
        component_azimuths_deg=(32.0, 122.0),
        processing=({"step": "detrend", "order": 1, "effect": {"pga": [1.0, 2.0]}},),
        extra={"axes": ["N28W", "S62W"], "pulse": True},
    )
    write_record_to_motion_file(record, tmp_path / "motion.nc")
    back = read_record_from_motion_file(tmp_path / "motion.nc")
    assert_same_record(round_samples_to_stored_decimals(record), back)
    np.testing.assert_allclose(back.north, north, atol=5.1e-10)


def test_a_motion_file_has_the_same_bytes_each_time_without_leftover_files(tmp_path):
    record = Record("x", np.sin(np.arange(500.0)), np.cos(np.arange(500.0)), None, 0.01, extra={"b": 1, "a": 2})
    write_record_to_motion_file(record, tmp_path / "one.nc")
    write_record_to_motion_file(
        dataclasses.replace(record, extra={"a": 2, "b": 1}), tmp_path / "two.nc"
    )  # whichever key came first
    assert (tmp_path / "one.nc").read_bytes() == (tmp_path / "two.nc").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["one.nc", "two.nc"]


def test_the_error_names_a_damaged_missing_or_foreign_motion_file(tmp_path):
    record = Record("x", np.zeros(9), np.zeros(9), None, 0.01)
    write_record_to_motion_file(record, tmp_path / "motion.nc")
    whole = (tmp_path / "motion.nc").read_bytes()
    (tmp_path / "cut.nc").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "text.nc").write_text("hello")
    for name in ("cut.nc", "text.nc", "none.nc"):
        with pytest.raises(ResultError, match=name):
            read_record_from_motion_file(tmp_path / name)


def test_a_failed_write_leaves_the_old_motion_file(tmp_path, monkeypatch):
    import netCDF4

    record = Record("x", np.zeros(9), np.zeros(9), None, 0.01)
    write_record_to_motion_file(record, tmp_path / "motion.nc")
    before = (tmp_path / "motion.nc").read_bytes()

    def raise_disk_is_full(*args, **kwargs):
        raise OSError("no space left on device")

    monkeypatch.setattr(netCDF4.Dataset, "createVariable", raise_disk_is_full)
    with pytest.raises(OSError, match="no space"):
        write_record_to_motion_file(dataclasses.replace(record, station="other"), tmp_path / "motion.nc")
    assert (tmp_path / "motion.nc").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["motion.nc"]
