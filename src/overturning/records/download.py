"""Download a file by URL and SHA-256: retried, resumed, checked, and never half there (pooch keeps the cache)."""

import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Final
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


def attempts(tries: int, wait: float) -> Iterator[int]:
    """Numbers of the tries, from 0, with a pause before each but the first: ``wait`` seconds, doubled each time."""
    for attempt in range(tries):
        if attempt:
            time.sleep(wait * 2.0 ** (attempt - 1))
        yield attempt


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
    """Get a file, or find it in the folder already.

    What has come of a broken download stays beside the target as ``.NAME.part`` and is continued; the target itself
    appears only whole and with the right hash.

    Parameters
    ----------
    url : str
        http or https, without credentials.
    sha256 : str
        Expected hash of the file, 64 hexadecimal digits.
    folder : path
        Where it goes; made if missing.
    name : str, optional
        File name; default: the last part of the URL's path.
    tries, timeout, wait : int, float, float
        Attempts in all, longest silence of the server, and pause before the second try, s; doubled each time.

    Raises
    ------
    ArgumentError
        If URL, hash or name are unusable.
    MissingDataError
        If the server needs an account that is not there (NIED), or refuses it.
    RecordError
        If the file cannot be had, or has another hash.
    """
    import pooch

    target = _checked(url, sha256, name)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)

    def download(address: str, output: str, _pooch: object) -> None:
        _continued(address, folder / f".{target}.part", tries, timeout, wait)
        os.replace(folder / f".{target}.part", output)
        with open(output, "rb") as file:
            if is_web_page(file.read(400)):
                raise RecordError(
                    f"{target}: the server sent a web page instead of the file; sign in there, or check the address"
                )

    pooch.get_logger().setLevel("WARNING")
    try:
        path = pooch.retrieve(
            url, known_hash=f"sha256:{sha256.lower()}", fname=target, path=folder, downloader=download
        )
    except ValueError as problem:
        if isinstance(problem, RecordError | ArgumentError):
            raise
        raise RecordError(
            f"{target}: the file from {urlsplit(url).hostname} has another SHA-256 than {sha256[:12]}…; nothing was "
            "kept: check address and hash"
        ) from None
    return Path(path)


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


def _continued(url: str, part: Path, tries: int, timeout: float, wait: float) -> None:
    """Bring the part to its full length, continuing where the last try broke off."""
    import requests

    last = ""
    for _ in attempts(tries, wait):
        try:
            if _once(url, part, timeout):
                return
            last = "the connection broke off"
        except requests.RequestException as problem:
            last = type(problem).__name__  # its text may hold the address with a query
    raise RecordError(
        f"{shown(url)}: not to be had in {tries} tries ({last}); what has come is kept and continued next time: try "
        "again later"
    )


def _once(url: str, part: Path, timeout: float) -> bool:
    """One try; True when the file is whole."""
    import requests

    have = part.stat().st_size if part.exists() else 0
    headers = {"Range": f"bytes={have}-"} if have else {}
    # Encoded bodies have another length than the file, so none are asked for.
    headers["Accept-Encoding"] = "identity"
    with requests.get(url, headers=headers, timeout=timeout, stream=True, auth=credentials()) as answer:
        content_range = answer.headers.get("Content-Range", "")
        if answer.status_code == 416:  # nothing left to send: the part is whole, or not of this file
            if content_range.rpartition("/")[2] == str(have):
                return True
            part.unlink()
            return False
        if answer.status_code in (401, 403):
            raise MissingDataError(
                f"{shown(url)}: the server wants an account (status {answer.status_code}); {SET_CREDENTIALS}"
            )
        if answer.status_code in (404, 410):
            raise RecordError(f"{shown(url)}: there is no such file (status {answer.status_code}); check the address")
        if answer.status_code not in (200, 206):
            answer.raise_for_status()
            return False
        continued = answer.status_code == 206 and content_range.startswith(f"bytes {have}-")
        length = answer.headers.get("Content-Length", "")
        expected = int(length) + (have if continued else 0) if length.isdigit() else None
        with part.open("ab" if continued else "wb") as out:
            try:
                for block in answer.iter_content(BLOCK):
                    out.write(block)
            except requests.RequestException:
                return False
    return expected is None or part.stat().st_size == expected
