"""Downloads from a server on the loopback address that also fails, stalls and sends wrong data."""

import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from overturning.errors import ArgumentError, MissingDataError, RecordError
from overturning.records import download
from overturning.records.download import fetch_url
from overturning.records.fdsn import FdsnWaveformRequest, fetch_fdsn_record
from overturning.records.read import read_record_without_processing
from tests.records.loopback_server import (
    CHANNEL_SAMPLES_IN_COUNTS,
    HASH,
    SERVED_FILE_CONTENT,
    ServerWithPlannedFailures,
)
from tests.records.seed_writers import START


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerWithPlannedFailures]:
    """A running server on this machine that delivers files and FDSN data, with faults on request."""
    (tmp_path / "server").mkdir()
    one = ServerWithPlannedFailures(tmp_path / "server")
    thread = threading.Thread(target=one.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True)
    thread.start()
    yield one
    one.released.set()
    one.shutdown()
    one.server_close()
    thread.join(5)


def fetch_file(server: ServerWithPlannedFailures, folder: Path, **more):
    """Download the file of the test server into a folder, with short pauses between tries."""
    options = {"timeout_s": 0.4, "first_pause_s": 0.001} | more
    return fetch_url(f"{server.address}/a/x.bin", HASH, folder, **options)


def file_names(folder: Path) -> list[str]:
    """Return the sorted names of the files in a folder; empty if it does not exist."""
    return sorted(p.name for p in folder.iterdir()) if folder.exists() else []


def test_a_file_is_downloaded_whole_and_only_once(server, tmp_path):
    folder = tmp_path / "got"
    path = fetch_file(server, folder)
    assert path.read_bytes() == SERVED_FILE_CONTENT
    assert fetch_file(server, folder) == path
    assert len(server.seen) == 1
    assert file_names(folder) == ["x.bin"]


@pytest.mark.parametrize("trouble", [*(("503",) * 2, ("500",) * 2, ("cut",) * 2, ("stall",) * 2), ("cut", "no ranges")])
def test_a_failed_download_is_tried_again(server, tmp_path, trouble):
    server.mode["file"] = [*trouble]
    assert fetch_file(server, tmp_path / "got").read_bytes() == SERVED_FILE_CONTENT
    assert len(server.seen) == 2 + (trouble[-1] != "no ranges")


def test_a_download_that_breaks_off_is_resumed_near_its_break(server, tmp_path):
    server.mode["file"] = ["cut", "cut"]
    fetch_file(server, tmp_path / "got")
    begins = [int(r.removeprefix("bytes=").removesuffix("-") or 0) for _, r in server.seen]
    # Up to one block of received data may be lost with the connection.
    assert begins[0] == 0 < len(SERVED_FILE_CONTENT) // 2 - download.BLOCK_SIZE_BYTES <= begins[1] < begins[2]


def test_a_later_run_resumes_a_partial_download(server, tmp_path):
    server.mode["file"] = ["cut"]
    with pytest.raises(RecordError, match="resumed next time"):
        fetch_file(server, tmp_path / "got", max_tries=1)
    assert file_names(tmp_path / "got") == [".x.bin.part"]
    assert fetch_file(server, tmp_path / "got").read_bytes() == SERVED_FILE_CONTENT
    assert server.seen[-1][1] not in ("", "bytes=0-")
    assert file_names(tmp_path / "got") == ["x.bin"]


@pytest.mark.parametrize(
    ("trouble", "word"),
    [("lie", "another SHA-256"), ("cut without length", "another SHA-256"), ("page", "web page")],
)
def test_a_download_with_a_wrong_hash_is_refused_and_deleted(server, tmp_path, trouble, word):
    server.mode["file"] = [trouble]
    with pytest.raises(RecordError, match=word):
        fetch_file(server, tmp_path / "got")
    assert file_names(tmp_path / "got") == []


def test_a_changed_local_file_is_downloaded_again(server, tmp_path):
    path = fetch_file(server, tmp_path / "got")
    path.write_bytes(b"spoilt")
    assert fetch_file(server, tmp_path / "got").read_bytes() == SERVED_FILE_CONTENT


@pytest.mark.parametrize(
    ("status", "kind"), [("404", MissingDataError), ("401", MissingDataError), ("403", MissingDataError)]
)
def test_a_permanent_http_error_is_not_retried(server, tmp_path, status, kind):
    server.mode["file"] = [status] * 5
    with pytest.raises(kind, match=status):
        fetch_file(server, tmp_path / "got")
    assert len(server.seen) == 1


def test_a_download_from_a_dead_server_ends_with_an_error(tmp_path):
    with pytest.raises(RecordError, match=r"127\.0\.0\.1/x\.bin: failed in 2 tries"):
        fetch_url("http://127.0.0.1:19/x.bin", HASH, tmp_path, max_tries=2, timeout_s=0.5, first_pause_s=0.001)


def test_download_credentials_come_from_the_environment_and_are_never_shown(
    server, tmp_path, monkeypatch, caplog, capsys
):
    monkeypatch.setenv(download.USER_ENVIRONMENT_VARIABLE, "somebody")
    monkeypatch.setenv(download.PASSWORD_ENVIRONMENT_VARIABLE, "s3cret-w0rd")
    with caplog.at_level("DEBUG"):
        fetch_file(server, tmp_path / "got")
        server.mode["file"] = ["401"]
        with pytest.raises(MissingDataError) as problem:
            fetch_url(f"{server.address}/y.bin?token=abc123", HASH, tmp_path / "got", first_pause_s=0.001)
    shown = str(problem.value) + caplog.text + "".join(capsys.readouterr())
    shown += "".join(p.read_text("latin-1") for p in (tmp_path / "got").iterdir())
    assert "s3cret-w0rd" not in shown
    assert "token=abc123" not in str(problem.value)


@pytest.mark.parametrize(
    ("kind", "word", "url", "more"),
    [
        (ArgumentError, "http", "ftp://example.org/x", {}),
        (ArgumentError, "http", "x.bin", {}),
        (ArgumentError, "credentials", "https://me:pw@example.org/x.bin", {}),
        (ArgumentError, "64", "http://127.0.0.1/x", {"sha256": "abc"}),
        (ArgumentError, "plain file name", "http://127.0.0.1/", {}),
        (ArgumentError, "plain file name", "http://127.0.0.1/x", {"name": "../x"}),
        (MissingDataError, "registered users", "https://www.kyoshin.bosai.go.jp/x.tar.gz", {}),
    ],
)
def test_the_error_names_an_unusable_download_argument(tmp_path, kind, word, url, more):
    with pytest.raises(kind, match=word):
        fetch_url(url, **({"sha256": HASH, "folder": tmp_path} | more))


def waveform_request(server: ServerWithPlannedFailures, **more) -> FdsnWaveformRequest:
    """Return a request for 10 s of the test station, or for the window around an event."""
    window = {} if "event_id" in more else {"window_start_utc": str(START), "window_end_utc": str(START + 10)}
    return FdsnWaveformRequest(server.address, "XX", "TST1", **(window | more))


def fetch_waveforms(server: ServerWithPlannedFailures, folder: Path, **more):
    """Fetch waveforms and metadata of the test station into a folder, with short pauses between tries."""
    return fetch_fdsn_record(waveform_request(server, **more), folder, max_tries=3, timeout_s=0.4, first_pause_s=0.001)


def test_fdsn_waveforms_and_metadata_become_a_record(server, tmp_path):
    folder = tmp_path / "got"
    paths = fetch_waveforms(server, folder)
    stem = "XX.TST1.x.HNx.20010203T040506.10s"
    assert file_names(folder) == [f"{stem}.mseed", f"{stem}.xml"]
    record = read_record_without_processing(paths)
    np.testing.assert_allclose(record.north, CHANNEL_SAMPLES_IN_COUNTS[0] / 400_000)
    np.testing.assert_allclose(record.up, CHANNEL_SAMPLES_IN_COUNTS[2] / 400_000)
    asked = len([p for p, _ in server.seen if p.endswith("query")])
    fetch_waveforms(server, folder)
    assert len([p for p, _ in server.seen if p.endswith("query")]) == asked == 2
    for other in ({"channel": "HHZ"}, {"location": "20"}):  # another sensor is not a duplicate
        fetch_waveforms(server, folder, **other)
    assert len([p for p, _ in server.seen if p.endswith("query")]) == 6


def test_fdsn_reports_missing_parts_of_the_window(server, tmp_path):
    """Regression: the server has 10 s of the requested window, and the missing part was not reported."""
    told = []
    length = CHANNEL_SAMPLES_IN_COUNTS[0].size / 100
    later = {"window_start_utc": str(START - 7), "window_end_utc": str(START + length + 4)}
    fetch_fdsn_record(
        waveform_request(server, **later), tmp_path / "got", timeout_s=0.6, report_missing_window_part=told.append
    )
    assert len(told) == 3
    assert all("of the requested window, the first 7 s and the last 4 s of XX.TST1..HN" in each for each in told)
    told.clear()
    whole = {"window_start_utc": str(START), "window_end_utc": str(START + length)}
    fetch_fdsn_record(
        waveform_request(server, **whole), tmp_path / "whole", timeout_s=0.6, report_missing_window_part=told.append
    )
    assert told == []


def test_an_fdsn_request_may_ask_for_the_window_around_an_event(server, tmp_path):
    paths = fetch_waveforms(server, tmp_path / "got", event_id="abc", before_origin_time_s=2, after_origin_time_s=8)
    assert read_record_without_processing(paths).start == "2001-02-03T04:05:06.5Z"


@pytest.mark.parametrize("service", ["dataselect", "station"])
@pytest.mark.parametrize("trouble", ["503", "cut", "stall", "page", "empty", "lie", "cut without length"])
def test_fdsn_errors_are_retried_and_leave_no_partial_file(server, tmp_path, service, trouble):
    server.mode[service] = [trouble]
    np.testing.assert_allclose(
        read_record_without_processing(fetch_waveforms(server, tmp_path / "got")).north,
        CHANNEL_SAMPLES_IN_COUNTS[0] / 400_000,
    )
    server.mode[service] = [trouble] * 3
    with pytest.raises((RecordError, MissingDataError), match=r"XX\.TST1"):
        fetch_waveforms(server, tmp_path / "other")
    left = file_names(tmp_path / "other")
    assert left == ([] if service == "station" else [n for n in left if n.endswith(".xml")])


@pytest.mark.parametrize(
    ("status", "kind", "word"),
    [
        ("204", MissingDataError, "no such data"),
        ("404", MissingDataError, "no such data"),
        ("401", MissingDataError, "account"),
        ("403", MissingDataError, "account"),
        ("400", ArgumentError, "does not understand"),
    ],
)
def test_a_permanent_fdsn_error_is_not_retried(server, tmp_path, status, kind, word):
    server.mode["station"] = [status] * 3
    with pytest.raises(kind, match=word):
        fetch_waveforms(server, tmp_path / "got")
    assert len([p for p, _ in server.seen if p.endswith("station/1/query")]) == 1


def test_the_error_names_an_address_without_an_fdsn_server(tmp_path):
    with pytest.raises(RecordError, match="failed in"):
        fetch_fdsn_record(
            FdsnWaveformRequest(
                "http://127.0.0.1:19", "XX", "TST1", window_start_utc="2001-01-01", window_end_utc="2001-01-02"
            ),
            tmp_path,
            max_tries=1,
            timeout_s=1,
        )


@pytest.mark.parametrize(
    "fields",
    [
        {"network": "X X"},
        {"window_start_utc": "2001-01-01"},
        {"window_start_utc": "a", "window_end_utc": "b", "event_id": "c"},
        {},
        {"server": "http://me@host", "window_start_utc": "a", "window_end_utc": "b"},
        {"window_start_utc": "2001-01-01", "window_end_utc": "2001-01-02", "before_origin_time_s": 10.0},
        {"window_start_utc": "2001-01-01", "window_end_utc": "2001-01-02", "after_origin_time_s": 0.0},
    ],
)
def test_invalid_fdsn_requests_are_refused(fields):
    with pytest.raises(ArgumentError):
        FdsnWaveformRequest(**({"server": "http://127.0.0.1", "network": "XX", "station": "TST1"} | fields))
