"""Runs scripts inside pages in headless browsers: pages and answers go over a server on this machine."""

import json
import shutil
import subprocess
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

from tests.expect import skip_test_unless_skipping_is_forbidden

TIMEOUT_SECONDS = 90
BROWSER_PROGRAMS = {
    "chromium": (
        ("chromium", "chromium-browser", "google-chrome"),
        "--headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking --disable-sync "
        "--disable-component-update --remote-debugging-port=0 --window-size=1200,900 --user-data-dir=",
    ),
    "firefox": (("firefox-esr", "firefox"), "--headless --no-remote --width 1200 --height 900 --profile "),
}
SCRIPT_RUNNER_HTML_TEMPLATE = """<script>
const faults = [];
addEventListener("error", (event) => faults.push(event.message));
for (const kind of ["error", "warn"]) console[kind] = (...words) => faults.push(words.join(" "));
const until = async (holds) => {
  for (let i = 0; i < 2000 && !holds(); i++) await new Promise((done) => setTimeout(done, 10));
  if (!holds()) throw new Error(`did not come true: ${holds}`); };
const press = (on, key) => on.dispatchEvent(new KeyboardEvent("keydown", {key, bubbles: true, cancelable: true}));
const set = (box, value, kind) => { box.value = value; box.dispatchEvent(new Event(kind)); };
const onPhone = async (look, before = () => {}, address = "") => {
  const frame = document.createElement("iframe");
  Object.assign(frame, {width: 390, height: 800, src: location.pathname + "?plain" + address});
  frame.style = "border: 0; padding: 0; position: fixed; left: 0";
  document.body.append(frame);
  await new Promise((done) => frame.addEventListener("load", done));
  const page = frame.contentDocument;
  before(page);
  return {wide: page.documentElement.scrollWidth, seen: look(page)}; };
addEventListener("load", async () => {
  let said;
  try { said = await (async () => { SCRIPT })(); } catch (fault) { faults.push(String(fault)); }
  await fetch(location.pathname, {method: "POST", body: JSON.stringify({said, faults})});
  location.assign("/NEXT");
});
</script>"""


class _PageServerCollectingScriptResults(HTTPServer):
    """HTTP server that sends pages to a browser and collects the results of their scripts by page number."""

    pages: list[tuple[str, str]]
    script_results_by_page: dict[int, dict[str, Any]]


class _PageHandlerStoringScriptResults(BaseHTTPRequestHandler):
    """Request handler that serves pages with a script and stores the results which the scripts post."""

    server: _PageServerCollectingScriptResults

    def do_GET(self) -> None:
        """Send the page whose number is in the address, with its script unless the address ends in a query."""
        name, _, plain = self.path[1:].partition("?")
        there = name.isdigit() and int(name) < len(self.server.pages)
        self.send_response(200 if there else 404)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.end_headers()
        if there:
            page, caller = self.server.pages[int(name)]
            self.wfile.write((page if plain else page.replace("<head>", f"<head>{caller}", 1)).encode())

    def do_POST(self) -> None:
        # By page: a browser may load one twice.
        """Store the first result that the script of a page posts."""
        said = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.server.script_results_by_page.setdefault(int(self.path[1:].partition("?")[0]), said)
        self.send_response(204)
        self.end_headers()

    def log_message(self, *args: Any) -> None:
        """Print nothing."""


def run_scripts_in_browser(kind: str, pages: dict[str, tuple[str, str]], profile: Path) -> dict[str, Any]:
    """Run the async script of each page in a browser; return results by page name; skip the test without a browser."""
    programs, options = BROWSER_PROGRAMS[kind]
    program = next((found for name in programs if (found := shutil.which(name))), None)
    if program is None:
        skip_test_unless_skipping_is_forbidden(f"needs one of {', '.join(programs)}")
    profile.mkdir()
    with _PageServerCollectingScriptResults(("127.0.0.1", 0), _PageHandlerStoringScriptResults) as server:
        server.script_results_by_page, server.timeout = {}, 1.0
        scripts = (script for _, script in pages.values())
        callers = [
            SCRIPT_RUNNER_HTML_TEMPLATE.replace("SCRIPT", one).replace("NEXT", str(n))
            for n, one in enumerate(scripts, 1)
        ]
        server.pages = [(page, caller) for (page, _), caller in zip(pages.values(), callers, strict=True)]
        command = [program, *f"{options}{profile}".split(), f"http://127.0.0.1:{server.server_port}/0"]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            for _ in range(TIMEOUT_SECONDS):
                server.handle_request()
                if len(server.script_results_by_page) == len(pages):
                    break
        finally:
            process.terminate()
            process.wait()
    said = {name: server.script_results_by_page[number] for number, name in enumerate(pages)}
    assert {name: one["faults"] for name, one in said.items()} == {name: [] for name in pages}
    return {name: one.get("said") for name, one in said.items()}
