"""Download a file by URL and SHA-256, with retries and resumption; an incomplete file never becomes the target."""

import hashlib
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

from overturning.errors import ArgumentError, MissingDataError, RecordError
from overturning.records.source import is_web_page

USER_ENVIRONMENT_VARIABLE: Final = "OVERTURNING_FETCH_USER"
PASSWORD_ENVIRONMENT_VARIABLE: Final = "OVERTURNING_FETCH_PASSWORD"
"""Environment variables with the credentials, which are not stored anywhere."""

CREDENTIALS_INSTRUCTION: Final = (
    f"set {USER_ENVIRONMENT_VARIABLE} and {PASSWORD_ENVIRONMENT_VARIABLE} in the environment"
)

BLOCK_SIZE_BYTES: Final = 1 << 16


def download_credentials_from_environment() -> tuple[str, str] | None:
    """Return user name and password for downloads from the environment variables; None unless both are set."""
    user, password = os.environ.get(USER_ENVIRONMENT_VARIABLE), os.environ.get(PASSWORD_ENVIRONMENT_VARIABLE)
    return (user, password) if user and password else None


def call_with_retries(
    send_request: Callable[[], Any],
    request_label: str,
    max_tries: int,
    first_pause_s: float,
    partial_data_note: str = "nothing was kept",
) -> Any:
    """Call `send_request` until it succeeds, at most `max_tries` times, and return its result; pauses (s) double.

    ArgumentError and MissingDataError are raised at once. Raises a RecordError after the last try.
    """
    last = ""
    for attempt in range(max_tries):
        if attempt:
            time.sleep(first_pause_s * 2.0 ** (attempt - 1))
        try:
            return send_request()
        except (ArgumentError, MissingDataError):
            raise
        except Exception as problem:  # urllib, http, socket, requests and obspy have unrelated errors.
            # Messages of other libraries may contain the address with its query.
            last = str(problem) if isinstance(problem, RecordError) else type(problem).__name__
    raise RecordError(f"{request_label}: failed in {max_tries} tries ({last}); {partial_data_note}: try again later")


def fetch_url(
    url: str,
    sha256: str,
    folder: Path | str,
    *,
    name: str | None = None,
    max_tries: int = 4,
    timeout_s: float = 30.0,
    first_pause_s: float = 1.0,
) -> Path:
    """Download a file by http or https into a folder, unless the folder has it already; return its path.

    The folder is created if missing. A partial download stays in the folder as ``.NAME.part`` and is resumed; the file
    gets its name only when it is complete and has the right SHA-256. By default, `name` is the last part of the URL's
    path. There are at most `max_tries` tries. The pause between them is first `first_pause_s` and doubles each time.
    `timeout_s` is the longest time, s, for which the server may send nothing.

    Raises
    ------
    ArgumentError
        If URL, hash or name are unusable.
    MissingDataError
        If the server needs an account (NIED), refuses the given one, or has no such file.
    RecordError
        If the download fails or the file has another hash.
    """
    target, folder = _checked_download_file_name(url, sha256, name), Path(folder)
    path, part = folder / target, folder / f".{target}.part"
    folder.mkdir(parents=True, exist_ok=True)
    if path.is_file() and _file_sha256(path) == sha256.lower():
        return path
    kept = "the part that was received is kept and resumed next time"
    call_with_retries(
        lambda: _resume_download(url, part, timeout_s),
        url_without_credentials_query_and_fragment(url),
        max_tries,
        first_pause_s,
        kept,
    )
    wrong = ""
    with part.open("rb") as file:
        if is_web_page(file.read(400)):
            wrong = "the server sent a web page instead of the file; sign in there, or check the address"
    if not wrong and _file_sha256(part) != sha256.lower():
        whose = f"the file from {urlsplit(url).hostname} has another SHA-256 than {sha256[:12]}…"
        wrong = f"{whose}; nothing was kept: check address and hash"
    if wrong:
        part.unlink()
        raise RecordError(f"{target}: {wrong}")
    os.replace(part, path)
    return path


def _file_sha256(path: Path) -> str:
    """Return the SHA-256 of a file as hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _checked_download_file_name(url: str, expected_sha256: str, requested_file_name: str | None) -> str:
    """Return the requested file name, or the last part of the URL; raise an error for an unusable URL, hash or name."""
    parts = urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise ArgumentError(f"url: {url_without_credentials_query_and_fragment(url)!r}; give an http or https address")
    if parts.username or parts.password:
        raise ArgumentError(f"url: credentials do not belong in an address; {CREDENTIALS_INSTRUCTION}")
    if parts.hostname.endswith("bosai.go.jp"):
        raise MissingDataError(
            f"{parts.hostname}: NIED gives records to registered users only; download them in a browser "
            "(www.kyoshin.bosai.go.jp, free account) and put them into the study's data folder"
        )
    if len(expected_sha256) != 64 or set(expected_sha256.lower()) - set("0123456789abcdef"):
        raise ArgumentError(f"sha256: {expected_sha256!r}; it has 64 hexadecimal digits")
    target = requested_file_name or Path(parts.path).name
    if not target or Path(target).name != target or target.startswith("."):
        raise ArgumentError(f"name: {target!r}; give a plain file name")
    return target


def url_without_credentials_query_and_fragment(url: str) -> str:
    """Return a URL without user, password, query and fragment, for messages."""
    parts = urlsplit(url)
    return f"{parts.scheme}://{parts.hostname or ''}{parts.path}"


def _resume_download(url: str, partial_file: Path, timeout_s: float) -> None:
    """Download the missing rest of a partial file; raise a RecordError if the connection breaks off."""
    import requests

    have = partial_file.stat().st_size if partial_file.exists() else 0
    # Request an unencoded body: an encoded one has another length than the file.
    headers = {"Accept-Encoding": "identity"} | ({"Range": f"bytes={have}-"} if have else {})
    with requests.get(
        url, headers=headers, timeout=timeout_s, stream=True, auth=download_credentials_from_environment()
    ) as answer:
        status, content_range = answer.status_code, answer.headers.get("Content-Range", "")
        if status in (401, 403):
            raise MissingDataError(
                f"{url_without_credentials_query_and_fragment(url)}: the server wants an account (status {status}); "
                f"{CREDENTIALS_INSTRUCTION}"
            )
        if status in (404, 410):
            raise MissingDataError(
                f"{url_without_credentials_query_and_fragment(url)}: there is no such file (status {status}); check "
                f"the address"
            )
        if status == 416 and content_range.rpartition("/")[2] == str(have):
            return  # The partial file is complete.
        if status == 416:
            partial_file.unlink()  # It belongs to another file.
        if status not in (200, 206):
            raise RecordError(f"status {status}")
        continued = status == 206 and content_range.startswith(f"bytes {have}-")
        length = answer.headers.get("Content-Length", "")
        with partial_file.open("ab" if continued else "wb") as out:
            for block in answer.iter_content(BLOCK_SIZE_BYTES):
                out.write(block)
    if length.isdigit() and partial_file.stat().st_size != int(length) + (have if continued else 0):
        raise RecordError("the connection broke off")
