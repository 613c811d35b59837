"""A small web server on the loopback address: files, FDSN-like services, and every kind of trouble."""

import hashlib
import io
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import numpy as np
import obspy

from tests.records.seed_writers import START, trace_of_samples, write_stationxml_of_channels

SERVED_FILE_CONTENT = bytes(range(256)) * 2000
HASH = hashlib.sha256(SERVED_FILE_CONTENT).hexdigest()
CHANNEL_SAMPLES_IN_COUNTS = [np.arange(-500, 500, dtype=np.int32) * k for k in (1, 2, 3)]


def miniseed_bytes_of_three_channels() -> bytes:
    """Return the bytes of a miniSEED file of three channels."""
    stream = obspy.Stream(
        [trace_of_samples(c, code) for c, code in zip(CHANNEL_SAMPLES_IN_COUNTS, ("HNN", "HNE", "HNZ"), strict=True)]
    )
    buffer = io.BytesIO()
    stream.write(buffer, format="MSEED")
    return buffer.getvalue()


WADL = (
    '<application xmlns="http://wadl.dev.java.net/2009/02"><resources base="{}"><resource path="query">'
    '<method name="GET" id="query"><request>{}</request></method></resource></resources></application>'
)
AREA_PARAMETERS = "minlatitude maxlatitude minlongitude maxlongitude"
FDSN_PARAMETERS = {
    "dataselect": "network station location channel starttime endtime",
    "station": f"network station location channel starttime endtime level {AREA_PARAMETERS}",
    "event": f"eventid starttime endtime {AREA_PARAMETERS} mindepth maxdepth minmagnitude maxmagnitude orderby",
}


class ServerWithPlannedFailures(ThreadingHTTPServer):
    """Server on this machine that delivers a file and FDSN data, with planned failures of the transfer."""

    daemon_threads = True

    def __init__(self, folder: Path) -> None:
        super().__init__(("127.0.0.1", 0), HandlerWithPlannedFailures)
        self.seen: list[tuple[str, str]] = []
        self.mode: dict[str, list[str]] = {}
        self.files = {
            "dataselect": miniseed_bytes_of_three_channels(),
            "station": write_stationxml_of_channels(
                folder / "s.xml", {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0), "HNZ": (0.0, -90.0)}
            ).read_bytes(),
        }
        event = obspy.core.event.Event(origins=[obspy.core.event.Origin(time=START + 2)])
        buffer = io.BytesIO()
        obspy.core.event.Catalog([event]).write(buffer, format="QUAKEML")
        self.files["event"] = buffer.getvalue()
        self.released = threading.Event()

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}"

    def take_next_behaviour_of_service(self, service: str) -> str:
        """Remove and return the next behaviour planned for a service, such as "503"; "good" if none is."""
        modes = self.mode.get(service, [])
        return modes.pop(0) if modes else "good"


class HandlerWithPlannedFailures(BaseHTTPRequestHandler):
    """Request handler that sends the file or FDSN data with the failures planned for the server."""

    server: ServerWithPlannedFailures
    protocol_version = "HTTP/1.1"

    def log_message(self, *args: object) -> None:
        pass

    def do_GET(self) -> None:
        parts = urlsplit(self.path)
        self.server.seen.append((parts.path, self.headers.get("Range", "")))
        if not parts.path.startswith("/fdsnws/"):
            self.send_body_with_behaviour(self.server.take_next_behaviour_of_service("file"), SERVED_FILE_CONTENT)
            return
        _, _, service, _, method = parts.path.split("/")
        if method == "application.wadl":
            names = FDSN_PARAMETERS[service].split()
            self.send_whole_body(
                200,
                WADL.format(
                    service, "".join(f'<param name="{n}" style="query" type="xs:string"/>' for n in names)
                ).encode(),
            )
        elif method == "query":
            assert parse_qs(parts.query)
            self.send_body_with_behaviour(
                self.server.take_next_behaviour_of_service(service), self.server.files[service]
            )
        else:
            self.send_whole_body(
                200, b"<Catalogs></Catalogs>" if method == "catalogs" else b"<Contributors></Contributors>"
            )

    def send_body_with_behaviour(self, mode: str, body: bytes) -> None:
        """Send a body as `mode` says: whole ("good"), cut, stalled, replaced, or with an HTTP error status ("503")."""
        first = 0
        if mode != "no ranges" and (wanted := self.headers.get("Range")):
            first = int(wanted.removeprefix("bytes=").removesuffix("-"))
        match mode:
            case "good" | "no ranges":
                self.send_whole_body(
                    206 if first else 200,
                    body[first:],
                    {"Content-Range": f"bytes {first}-{len(body) - 1}/{len(body)}"} if first else {},
                )
            case "503" | "500" | "404" | "401" | "403" | "204" | "400":
                self.send_whole_body(int(mode), b"" if mode == "204" else b"trouble")
            case "cut" | "stall":
                self.send_response(206 if first else 200)
                self.send_header("Content-Length", str(len(body) - first))
                if first:
                    self.send_header("Content-Range", f"bytes {first}-{len(body) - 1}/{len(body)}")
                self.end_headers()
                self.wfile.write(body[first : first + (len(body) - first) // 2])
                self.wfile.flush()
                if mode == "stall":
                    self.server.released.wait(5)
                self.close_connection = True
            case "cut without length":
                self.send_response(200)
                self.send_header("Connection", "close")
                self.end_headers()
                self.wfile.write(body[: len(body) // 2 - 7])
                self.close_connection = True
            case "page":
                self.send_whole_body(200, b"<!DOCTYPE html><html>Please sign in</html>")
            case "lie":
                self.send_whole_body(200, body[::-1])
            case "empty":
                self.send_whole_body(200, b"")

    def send_whole_body(self, status: int, body: bytes, headers: dict[str, str] | None = None) -> None:
        """Send a whole response with its length."""
        self.send_response(status)
        if status != 204:
            self.send_header("Content-Length", str(len(body)))
        for name, value in (headers or {}).items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)
