"""Records from FDSN web services, through obspy: MiniSEED with the StationXML that belongs to it."""

import io
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from overturning.errors import ArgumentError, MissingDataError, RecordError
from overturning.files import atomic_write
from overturning.records.download import (
    CREDENTIALS_INSTRUCTION,
    call_with_retries,
    download_credentials_from_environment,
)
from overturning.records.formats.miniseed import read_obspy_stream
from overturning.records.formats.stationxml import read_stationxml_inventory
from overturning.records.source import SourceFile, is_web_page

SEED_CODE_NAMES = ("network", "station", "location", "channel")
DEFAULT_WINDOW_START_BEFORE_ORIGIN_S, DEFAULT_WINDOW_END_AFTER_ORIGIN_S = 30.0, 270.0
"""Default start and end of the window, s before and after the origin time of an event."""
MAX_UNREPORTED_GAP_AT_EITHER_WINDOW_END_S = 2.0
"""Longest missing part at either end of the window without a note, s."""


@dataclass(frozen=True)
class FdsnWaveformRequest:
    """Request to an FDSN server for waveforms: station, channels, and a time window or an earthquake."""

    server: str  # a short name that obspy knows, or the address of the services
    network: str  # SEED codes, down to the channel
    station: str
    location: str = "*"
    channel: str = "HN?"  # the three components of an accelerometer
    window_start_utc: str = ""  # ISO 8601 in UTC; empty with an event
    window_end_utc: str = ""
    event_id: str = ""  # event of the server's catalogue; the window is relative to its origin time
    before_origin_time_s: float | None = None  # start of the window; None: `DEFAULT_WINDOW_START_BEFORE_ORIGIN_S`
    after_origin_time_s: float | None = None  # end of the window; None: `DEFAULT_WINDOW_END_AFTER_ORIGIN_S`

    def __post_init__(self) -> None:
        for name in SEED_CODE_NAMES:
            if not re.fullmatch(r"[A-Za-z0-9?*-]{1,8}", getattr(self, name)):
                raise ArgumentError(f"{name}: {getattr(self, name)!r}; a SEED code has letters, digits, ? and *")
        if bool(self.event_id) == bool(self.window_start_utc or self.window_end_utc):
            raise ArgumentError("start, end: give both, or an event id instead")
        if not self.event_id and not (self.window_start_utc and self.window_end_utc):
            raise ArgumentError("start, end: give both")
        if not self.event_id and (self.before_origin_time_s, self.after_origin_time_s) != (None, None):
            raise ArgumentError("before, after: they count from an event's origin; leave them out with start and end")
        if "@" in self.server:
            raise ArgumentError(f"server: no credentials in an address; {CREDENTIALS_INSTRUCTION}")


def fetch_fdsn_record(
    request: FdsnWaveformRequest,
    folder: Path | str,
    *,
    max_tries: int = 3,
    timeout_s: float = 60.0,
    first_pause_s: float = 1.0,
    report_missing_window_part: Callable[[str], Any] = lambda _: None,
) -> list[Path]:
    """Download a MiniSEED file and its StationXML from an FDSN server into a folder; return their paths.

    Existing files are not downloaded again. A missing folder is created. Each answer is parsed before it is saved, so
    an incomplete or wrong answer leaves no file. ``max_tries``, ``timeout_s`` and ``first_pause_s`` apply to each
    request, see `fetch_url`. ``report_missing_window_part`` is called with a message for each channel that does not
    fill the time window.

    Raises
    ------
    ArgumentError
        If server, codes or times are unusable.
    MissingDataError
        If the server has no such data, or needs an account.
    RecordError
        If no complete, readable answer arrives.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    what = f"{request.server} {request.network}.{request.station}"

    def send_with_retries(send_request: Callable[[], Any]) -> Any:
        """Send a request to the server, and repeat it after connection errors."""
        return call_with_retries(lambda: _send_fdsn_request(send_request, what), what, max_tries, first_pause_s)

    client = send_with_retries(lambda: _connect_to_fdsn_server(request.server, timeout_s))
    start, end = _requested_time_window(
        request, lambda event_id: send_with_retries(lambda: client.get_events(eventid=event_id))
    )
    codes = {name: getattr(request, name) for name in SEED_CODE_NAMES}
    stem = ".".join([*codes.values(), start.strftime("%Y%m%dT%H%M%S"), f"{end - start:.0f}s"])
    stem = re.sub(r"[?*]", "x", stem)
    waves, metadata = folder / f"{stem}.mseed", folder / f"{stem}.xml"
    window = {"starttime": start, "endtime": end}
    if not metadata.exists():
        get = partial(client.get_stations, **codes, **window, level="response")
        send_with_retries(
            lambda: _download_and_save_checked(
                metadata, "StationXML", get, lambda file: read_stationxml_inventory([file])
            )
        )
    if not waves.exists():
        get = partial(client.get_waveforms, **codes, **window)
        send_with_retries(
            lambda: _download_and_save_checked(
                waves, "MiniSEED", get, lambda file: _check_waveform_is_complete_and_ends_as_requested(file, start, end)
            )
        )
    for note in _notes_on_channels_not_filling_time_window(SourceFile(waves.name, waves.read_bytes()), start, end):
        report_missing_window_part(note)
    return [waves, metadata]


def _notes_on_channels_not_filling_time_window(
    waveform_file: SourceFile, requested_start_utc: Any, requested_end_utc: Any
) -> Iterator[str]:
    """Yield a note for each channel that begins or ends more than 2 s inside the requested window."""
    found = read_obspy_stream(waveform_file, "MSEED")
    for channel in dict.fromkeys(trace.id for trace in found):
        pieces = [trace.stats for trace in found if trace.id == channel]
        ends = (
            min(one.starttime for one in pieces) - requested_start_utc,
            requested_end_utc - max(one.endtime for one in pieces),
        )
        lost = [
            f"{word} {s:.0f} s"
            for word, s in zip(("first", "last"), ends, strict=True)
            if s > MAX_UNREPORTED_GAP_AT_EITHER_WINDOW_END_S
        ]
        if lost:
            name = waveform_file.name
            yield f"{name}: of the requested window, the {' and the '.join(lost)} of {channel} are not there"


def _connect_to_fdsn_server(server: str, timeout_s: float) -> Any:
    """Return an obspy client of an FDSN server; raise an ArgumentError for an unknown server."""
    from obspy.clients.fdsn import Client

    account = download_credentials_from_environment()
    extra = {"user": account[0], "password": account[1]} if account else {}
    try:
        return Client(server, timeout=timeout_s, user_agent="overturning", **extra)
    except ValueError as problem:
        raise ArgumentError(f"server: {server!r} ({problem}); give its address, or a name that obspy knows") from None


def _requested_time_window(request: FdsnWaveformRequest, fetch_events_by_id: Callable[[str], Any]) -> tuple[Any, Any]:
    """Return start and end of the requested time window; ``fetch_events_by_id`` finds an earthquake by its id."""
    import obspy

    if request.event_id:
        try:
            event = fetch_events_by_id(request.event_id)[0]
            origin = (event.preferred_origin() or event.origins[0]).time
        except IndexError:
            why = f"event {request.event_id!r} has no origin; give start and end"
            raise MissingDataError(f"{request.server}: {why}") from None
        before, after = request.before_origin_time_s, request.after_origin_time_s
        start = origin - (DEFAULT_WINDOW_START_BEFORE_ORIGIN_S if before is None else before)
        end = origin + (DEFAULT_WINDOW_END_AFTER_ORIGIN_S if after is None else after)
    else:
        try:
            start, end = obspy.UTCDateTime(request.window_start_utc), obspy.UTCDateTime(request.window_end_utc)
        except (ValueError, TypeError):
            said = f"{request.window_start_utc!r}, {request.window_end_utc!r}"
            raise ArgumentError(f"start, end: {said}; times read like 2016-11-13T11:02:00") from None
    if not 0 < end - start <= 86400:
        which = "before, after" if request.event_id else "start, end"
        raise ArgumentError(f"{which}: {end - start:g} s apart; a window is longer than nothing and at most a day")
    return start, end


def _send_fdsn_request(send_request: Callable[[], Any], request_label: str) -> Any:
    """Send a request to an FDSN server; raise an ArgumentError or MissingDataError if a retry would fail again."""
    from obspy.clients.fdsn import header

    nothing = MissingDataError(f"{request_label}: the server has no such data; check codes, time window and event")
    try:
        return send_request()
    except header.FDSNNoDataException:
        raise nothing from None
    except (header.FDSNUnauthorizedException, header.FDSNForbiddenException):
        raise MissingDataError(f"{request_label}: the server wants an account; {CREDENTIALS_INSTRUCTION}") from None
    except header.FDSNBadRequestException:
        raise ArgumentError(
            f"{request_label}: the server does not understand the request; check codes and times"
        ) from None
    except header.FDSNNoServiceException:
        raise RecordError("no FDSN services at that address") from None
    except header.FDSNException as problem:
        raise (nothing if "404" in str(problem).partition("\n")[0] else problem) from None


def _download_and_save_checked(
    path: Path,
    expected_format_name: str,
    download_into_open_file: Callable[..., Any],
    raise_if_answer_is_unusable: Callable[[SourceFile], Any],
) -> None:
    """Save a server's answer, if it is usable, to a file; raise a RecordError if it is empty or a web page.

    ``raise_if_answer_is_unusable`` gets the answer as a file in memory, and raises an error if its content is wrong.
    """
    answer = io.BytesIO()
    download_into_open_file(filename=answer)
    data = answer.getvalue()
    if not data or is_web_page(data):
        raise RecordError(f"{'a web page' if data else 'an empty answer'} instead of {expected_format_name}")
    raise_if_answer_is_unusable(SourceFile(expected_format_name, data))
    with atomic_write(path) as part:
        part.write_bytes(data)


def _check_waveform_is_complete_and_ends_as_requested(
    waveform_file: SourceFile, requested_start_utc: Any, requested_end_utc: Any
) -> None:
    """Raise a RecordError if a MiniSEED file is incomplete, or ends too far from the requested end.

    A trace may end 60 s plus half of the requested window before or after the requested end.
    """
    if len(waveform_file.data) % 128:
        raise RecordError(
            f"MiniSEED of {len(waveform_file.data)} bytes, no whole number of records: the answer was cut"
        )
    if any(
        abs(t.stats.endtime - requested_end_utc) > 60 + 0.5 * (requested_end_utc - requested_start_utc)
        for t in read_obspy_stream(waveform_file, "MSEED")
    ):
        raise RecordError("MiniSEED of another time than asked for")
