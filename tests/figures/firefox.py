"""Runs scripts inside pages in a headless Firefox: pages and answers go over a server on this machine."""

import json
import shutil
import subprocess
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

from tests.expect import lacking

PROGRAMS = ("firefox-esr", "firefox")
SECONDS = 90
CALLER = """<script>
const faults = [];
addEventListener("error", (event) => faults.push(event.message));
addEventListener("load", async () => {
  let said;
  try { said = await (async () => { SCRIPT })(); } catch (fault) { faults.push(String(fault)); }
  await fetch("/", {method: "POST", body: JSON.stringify({said, faults})});
  location.assign("/NEXT");
});
</script>"""


class _Server(HTTPServer):
    pages: list[str]
    said: list[dict[str, Any]]


class _Handler(BaseHTTPRequestHandler):
    server: _Server

    def do_GET(self) -> None:
        number = int(self.path[1:]) if self.path[1:].isdigit() else len(self.server.pages)
        there = number < len(self.server.pages)
        self.send_response(200 if there else 404)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.end_headers()
        if there:
            self.wfile.write(self.server.pages[number].encode())

    def do_POST(self) -> None:
        self.server.said.append(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
        self.send_response(204)
        self.end_headers()

    def log_message(self, *args: Any) -> None:
        pass


def answers(pages: dict[Path, str], profile: Path) -> list[Any]:
    """What async scripts return, each inside its page; the test is skipped where no Firefox is installed."""
    program = next((found for name in PROGRAMS if (found := shutil.which(name))), None)
    if program is None:
        lacking(f"needs one of {', '.join(PROGRAMS)}")
    profile.mkdir()
    with _Server(("127.0.0.1", 0), _Handler) as server:
        server.said, server.timeout = [], 1.0
        callers = (CALLER.replace("SCRIPT", one).replace("NEXT", str(n)) for n, one in enumerate(pages.values(), 1))
        texts = (page.read_text(encoding="utf-8") for page in pages)
        server.pages = [text.replace("<head>", f"<head>{one}", 1) for text, one in zip(texts, callers, strict=True)]
        address = f"http://127.0.0.1:{server.server_port}/0"
        process = subprocess.Popen(
            [program, "--headless", "--no-remote", "--profile", str(profile), address],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            for _ in range(SECONDS):
                server.handle_request()
                if len(server.said) == len(pages):
                    break
        finally:
            process.kill()
            process.wait()
    assert [one["faults"] for one in server.said] == [[]] * len(pages)
    return [one["said"] for one in server.said]
