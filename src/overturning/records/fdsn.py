"""Records from FDSN web services, through obspy: MiniSEED with the StationXML that belongs to it."""

import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from overturning.errors import ArgumentError, MissingDataError, RecordError
from overturning.files import atomic_write
from overturning.records.download import SET_CREDENTIALS, attempts, credentials
from overturning.records.source import SourceFile, is_web_page


@dataclass(frozen=True)
class Request:
    """What to ask a server for: a window, or an event of its catalogue."""

    server: str  # a short name that obspy knows, or the address of the services
    network: str  # SEED codes, down to the channel
    station: str
    location: str = "*"
    channel: str = "HN?"  # the three components of an accelerometer
    start: str = ""  # ISO 8601 in UTC; empty with an event
    end: str = ""
    event_id: str = ""  # the window is then counted from its origin time
    before_s: float = 30.0
    after_s: float = 270.0

    def __post_init__(self) -> None:
        for name in ("network", "station", "location", "channel"):
            if not re.fullmatch(r"[A-Za-z0-9?*-]{1,8}", getattr(self, name)):
                raise ArgumentError(f"{name}: {getattr(self, name)!r}; a SEED code has letters, digits, ? and *")
        if bool(self.event_id) == bool(self.start or self.end):
            raise ArgumentError("start, end: give both, or an event id instead")
        if not self.event_id and not (self.start and self.end):
            raise ArgumentError("start, end: give both")
        if "@" in self.server:
            raise ArgumentError(f"server: no credentials in an address; {SET_CREDENTIALS}")


def fetch_fdsn(
    request: Request, folder: Path | str, *, tries: int = 3, timeout: float = 60.0, wait: float = 1.0
) -> list[Path]:
    """Get a MiniSEED and its StationXML file, or find them in the folder, which is made if missing.

    Both files are read before they are moved into place, so a cut or foreign answer never becomes one. ``tries``,
    ``timeout`` and ``wait`` are as in `fetch_url`, per file.

    Raises
    ------
    ArgumentError
        If server, codes or times are unusable.
    MissingDataError
        If the server has no such data, or wants an account.
    RecordError
        If no whole, readable answer came.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    client = _retried(lambda: _client(request.server, timeout), request, tries, wait)
    start, end = _window(client, request, tries, wait)
    stem = ".".join([request.network, request.station, start.strftime("%Y%m%dT%H%M%S"), f"{end - start:.0f}s"])
    stem = re.sub(r"[?*]", "x", stem)
    waves, metadata = folder / f"{stem}.mseed", folder / f"{stem}.xml"
    codes = (request.network, request.station, request.location, request.channel)
    if not metadata.exists():
        _retried(lambda: _stations(client, codes, start, end, metadata), request, tries, wait)
    if not waves.exists():
        _retried(lambda: _waveforms(client, codes, start, end, waves), request, tries, wait)
    return [waves, metadata]


def _client(server: str, timeout: float) -> Any:
    from obspy.clients.fdsn import Client

    account = credentials()
    extra = {"user": account[0], "password": account[1]} if account else {}
    try:
        return Client(server, timeout=timeout, user_agent="overturning", **extra)
    except ValueError as problem:
        raise ArgumentError(f"server: {server!r} ({problem}); give its address, or a name that obspy knows") from None


def _window(client: Any, request: Request, tries: int, wait: float) -> tuple[Any, Any]:
    import obspy

    if request.event_id:
        catalogue = _retried(lambda: client.get_events(eventid=request.event_id), request, tries, wait)
        try:
            origin = (catalogue[0].preferred_origin() or catalogue[0].origins[0]).time
        except IndexError:
            raise MissingDataError(
                f"{request.server}: event {request.event_id!r} has no origin; give start and end"
            ) from None
        return origin - request.before_s, origin + request.after_s
    try:
        start, end = obspy.UTCDateTime(request.start), obspy.UTCDateTime(request.end)
    except (ValueError, TypeError):
        raise ArgumentError(
            f"start, end: {request.start!r}, {request.end!r}; times read like 2016-11-13T11:02:00"
        ) from None
    if not 0 < end - start <= 86400:
        raise ArgumentError(f"start, end: {end - start:g} s apart; a window is longer than nothing and at most a day")
    return start, end


def _retried(action: Any, request: Request, tries: int, wait: float) -> Any:
    """Do it, again after trouble on the way; what the server says for certain is not asked twice."""
    from obspy.clients.fdsn import header

    what = f"{request.server} {request.network}.{request.station}"
    nothing = MissingDataError(f"{what}: the server has no such data; check codes, time window and event")
    last = ""
    for _ in attempts(tries, wait):
        try:
            return action()
        except (ArgumentError, MissingDataError):
            raise
        except header.FDSNNoDataException:
            raise nothing from None
        except (header.FDSNUnauthorizedException, header.FDSNForbiddenException):
            raise MissingDataError(f"{what}: the server wants an account; {SET_CREDENTIALS}") from None
        except header.FDSNBadRequestException:
            raise ArgumentError(f"{what}: the server does not understand the request; check codes and times") from None
        except header.FDSNNoServiceException:
            last = "no FDSN services at that address"
        except RecordError as problem:
            last = str(problem)
        except Exception as problem:  # urllib, http, socket, obspy: each a kind of its own
            if isinstance(problem, header.FDSNException) and "404" in str(problem).partition("\n")[0]:
                raise nothing from None
            last = type(problem).__name__
    raise RecordError(f"{what}: not to be had in {tries} tries ({last}); nothing was kept: try again later")


def _stations(client: Any, codes: tuple[str, ...], start: Any, end: Any, path: Path) -> None:
    from overturning.records.formats.miniseed import read_inventory

    answer = io.BytesIO()
    named = dict(zip(("network", "station", "location", "channel"), codes, strict=True))
    client.get_stations(**named, starttime=start, endtime=end, level="response", filename=answer)
    data = _checked(answer, "StationXML")
    read_inventory([SourceFile("StationXML", data)])
    with atomic_write(path) as part:
        part.write_bytes(data)


def _waveforms(client: Any, codes: tuple[str, ...], start: Any, end: Any, path: Path) -> None:
    import obspy

    answer = io.BytesIO()
    client.get_waveforms(*codes, start, end, filename=answer)
    data = _checked(answer, "MiniSEED")
    if len(data) % 128:
        raise RecordError(f"MiniSEED of {len(data)} bytes, no whole number of records: the answer was cut")
    try:
        stream = obspy.read(io.BytesIO(data), format="MSEED")
    except Exception as problem:
        raise RecordError(f"no readable MiniSEED ({type(problem).__name__})") from None
    if any(abs(t.stats.endtime - end) > 60 + 0.5 * (end - start) for t in stream):
        raise RecordError("MiniSEED of another time than asked for")
    with atomic_write(path) as part:
        part.write_bytes(data)


def _checked(answer: io.BytesIO, what: str) -> bytes:
    """The bytes of an answer that is neither empty nor a web page."""
    data = answer.getvalue()
    if not data:
        raise RecordError(f"an empty answer instead of {what}")
    if is_web_page(data):
        raise RecordError(f"a web page instead of {what}")
    return data
