"""Download a file by URL and SHA-256: retried, resumed, checked, and never half there."""

import hashlib
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

from overturning.errors import ArgumentError, MissingDataError, RecordError
from overturning.records.source import is_web_page

USER: Final = "OVERTURNING_FETCH_USER"
PASSWORD: Final = "OVERTURNING_FETCH_PASSWORD"
"""Names of the environment variables with credentials; nothing else is asked, and nothing is written down."""

SET_CREDENTIALS: Final = f"set {USER} and {PASSWORD} in the environment"

BLOCK: Final = 1 << 16


def credentials() -> tuple[str, str] | None:
    """User and password from the environment, if both are set."""
    user, password = os.environ.get(USER), os.environ.get(PASSWORD)
    return (user, password) if user and password else None


def retried(action: Callable[[], Any], what: str, tries: int, wait: float, kept: str = "nothing was kept") -> Any:
    """Result of an action, tried again after trouble on the way, with a pause of ``wait`` s that doubles each time.

    Wrong arguments and missing data are final; a RecordError says so where the last try has failed too.
    """
    last = ""
    for attempt in range(tries):
        if attempt:
            time.sleep(wait * 2.0 ** (attempt - 1))
        try:
            return action()
        except (ArgumentError, MissingDataError):
            raise
        except Exception as problem:  # urllib, http, socket, requests, obspy: each a kind of its own
            # The text of others' errors may hold the address with a query.
            last = str(problem) if isinstance(problem, RecordError) else type(problem).__name__
    raise RecordError(f"{what}: not to be had in {tries} tries ({last}); {kept}: try again later")


def fetch_url(
    url: str,
    sha256: str,
    folder: Path | str,
    *,
    name: str | None = None,
    tries: int = 4,
    timeout: float = 30.0,
    wait: float = 1.0,
) -> Path:
    """Get a file by http or https, or find it in the folder already, which is made if missing.

    What has come of a broken download stays beside the target as ``.NAME.part`` and is continued; the target itself
    appears only whole and with the right SHA-256. Its name is the last part of the URL's path where not given. Tried in
    all `tries` times, with a pause of `wait` s that doubles; `timeout` is the longest silence of the server, s.

    Raises
    ------
    ArgumentError
        If URL, hash or name are unusable.
    MissingDataError
        If the server needs an account that is not there (NIED), refuses it, or has no such file.
    RecordError
        If the file cannot be had, or has another hash.
    """
    target, folder = _checked(url, sha256, name), Path(folder)
    path, part = folder / target, folder / f".{target}.part"
    folder.mkdir(parents=True, exist_ok=True)
    if path.is_file() and _sha256(path) == sha256.lower():
        return path
    kept = "what has come is kept and continued next time"
    retried(lambda: _continued(url, part, timeout), shown(url), tries, wait, kept)
    wrong = ""
    with part.open("rb") as file:
        if is_web_page(file.read(400)):
            wrong = "the server sent a web page instead of the file; sign in there, or check the address"
    if not wrong and _sha256(part) != sha256.lower():
        whose = f"the file from {urlsplit(url).hostname} has another SHA-256 than {sha256[:12]}…"
        wrong = f"{whose}; nothing was kept: check address and hash"
    if wrong:
        part.unlink()
        raise RecordError(f"{target}: {wrong}")
    os.replace(part, path)
    return path


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _checked(url: str, sha256: str, name: str | None) -> str:
    """File name of a download whose address, hash and name can be used."""
    parts = urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise ArgumentError(f"url: {shown(url)!r}; give an http or https address")
    if parts.username or parts.password:
        raise ArgumentError(f"url: credentials do not belong in an address; {SET_CREDENTIALS}")
    if parts.hostname.endswith("bosai.go.jp"):
        raise MissingDataError(
            f"{parts.hostname}: NIED gives records to registered users only; download them in a browser "
            "(www.kyoshin.bosai.go.jp, free account) and put them into the study's data folder"
        )
    if len(sha256) != 64 or set(sha256.lower()) - set("0123456789abcdef"):
        raise ArgumentError(f"sha256: {sha256!r}; it has 64 hexadecimal digits")
    target = name or Path(parts.path).name
    if not target or Path(target).name != target or target.startswith("."):
        raise ArgumentError(f"name: {target!r}; give a plain file name")
    return target


def shown(url: str) -> str:
    """An address as a message may show it: without user, password, query and fragment."""
    parts = urlsplit(url)
    return f"{parts.scheme}://{parts.hostname or ''}{parts.path}"


def _continued(url: str, part: Path, timeout: float) -> None:
    """Bring the part to its full length, continuing where the last try broke off; a RecordError where this one does."""
    import requests

    have = part.stat().st_size if part.exists() else 0
    # Encoded bodies have another length than the file, so none are asked for.
    headers = {"Accept-Encoding": "identity"} | ({"Range": f"bytes={have}-"} if have else {})
    with requests.get(url, headers=headers, timeout=timeout, stream=True, auth=credentials()) as answer:
        status, content_range = answer.status_code, answer.headers.get("Content-Range", "")
        if status in (401, 403):
            raise MissingDataError(f"{shown(url)}: the server wants an account (status {status}); {SET_CREDENTIALS}")
        if status in (404, 410):
            raise MissingDataError(f"{shown(url)}: there is no such file (status {status}); check the address")
        if status == 416 and content_range.rpartition("/")[2] == str(have):
            return  # nothing left to send: the part is whole
        if status == 416:
            part.unlink()  # it is not of this file
        if status not in (200, 206):
            raise RecordError(f"status {status}")
        continued = status == 206 and content_range.startswith(f"bytes {have}-")
        length = answer.headers.get("Content-Length", "")
        with part.open("ab" if continued else "wb") as out:
            for block in answer.iter_content(BLOCK):
                out.write(block)
    if length.isdigit() and part.stat().st_size != int(length) + (have if continued else 0):
        raise RecordError("the connection broke off")
