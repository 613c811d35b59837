"""Atomic writes: results that are either complete or not there, with a checksum; and files of keys and values."""

import errno
import hashlib
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any
from uuid import uuid4

from overturning.errors import ArgumentError, ConfigError


def check_output(path: Path | None, argument: str, *kinds: str) -> None:
    """Refuse a file that could not be written, before anything is computed for it; an `ArgumentError` says why.

    `kinds` are the endings, such as ``.svg``, that it may have where not any. Of no file nothing is refused.
    """
    if path is None:
        return
    if kinds and path.suffix.lower() not in kinds:
        raise ArgumentError(f"{argument} {path}: unknown kind of file; end it in {' or '.join(kinds)}")
    if not path.parent.is_dir():
        raise ArgumentError(f"{argument} {path}: there is no folder {path.parent}; make it first, or name another")
    why = "is a folder" if path.is_dir() else ""
    try:  # permissions alone do not tell: there are folders in which no file can be made
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError:
        why = f"cannot be written into {path.parent}"
    if why:
        raise ArgumentError(f"{argument} {path}: {why}; name another file")


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Yield another name in the folder to write to; move the complete file to ``path`` when the block is through.

    The folder is made where it is missing. If the block raises, nothing stays behind and an earlier file keeps its
    content. A NetCDF file is sealed (`seal`).
    """
    part = path.with_name(f".{path.name}.{uuid4().hex[:8]}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.touch(exist_ok=False)
    except OSError as error:  # of the file that is to be made, not of the other name
        raise OSError(error.errno, error.strerror, str(path)) from None
    try:
        yield part
        if path.suffix == ".nc":
            seal(part)
        part.replace(path)
    except (OSError, RuntimeError) as error:
        # A full disk reaches us without the file's name, and from NetCDF as an error that does not say so: one of its
        # own, or that the part, which was ours a moment ago, must not be written.
        odd = str(error).startswith("NetCDF: ") if isinstance(error, RuntimeError) else error.errno == errno.EACCES
        said = isinstance(error, OSError) and error.errno == errno.ENOSPC
        if said or (odd and shutil.disk_usage(path.parent).free < _LITTLE):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path)) from None
        raise
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file (UTF-8), as of `atomic_write`."""
    with atomic_write(path) as part:
        part.write_text(text, encoding="utf-8")


_MARK = b"\n# sha256 "
_SEAL = len(_MARK) + 65  # bytes: 64 digits and the end of the line


# What a user can do where a file cannot be written.
_REMEDIES = {
    **dict.fromkeys((errno.EACCES, errno.EPERM, errno.EROFS), "choose a folder that you may write to"),
    **dict.fromkeys(
        (errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EEXIST, errno.ENAMETOOLONG, errno.ELOOP),
        "name another file or folder",
    ),
    **dict.fromkeys((errno.ENOSPC, errno.EDQUOT), "free some space and run again; nothing half-written was kept"),
}


def os_error_message(error: OSError) -> str:
    """What is wrong with a file, and what to do; empty where nothing is known to do."""
    remedy = _REMEDIES.get(error.errno or 0)
    return f"{error.filename or 'a file'}: {str(error.strerror).lower()}; {remedy}" if remedy else ""


def seal(path: Path) -> None:
    """Append the SHA-256 of a file to it, as a line of its own.

    It is a comment in a table, and no reader of NetCDF or HDF5 looks behind the end that the file's own head states.
    """
    with path.open("r+b") as file:
        digest = hashlib.file_digest(file, "sha256")
        file.write(_MARK + digest.hexdigest().encode() + b"\n")


def checksum_matches(path: Path) -> bool | None:
    """Whether a file is as it was when it was sealed; None where it has no seal, or cannot be read."""
    digest = hashlib.sha256()
    try:
        with path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(size - _SEAL, 0))
            end = file.read()
            if not (end.startswith(_MARK) and len(end) == _SEAL):
                return None
            file.seek(0)
            left = size - _SEAL
            while left:
                block = file.read(min(left, _BLOCK))
                digest.update(block)
                left -= len(block)
    except OSError:
        return None
    return end[len(_MARK) : -1] == digest.hexdigest().encode()


def project_file(path: Path) -> Path:
    """A file of the project's, such as ``config/records.tsv``: that in the working folder, else that of the package.

    In a checkout the package is surrounded by its project; a wheel carries it inside.
    """
    if path.exists() or path.is_absolute():
        return path
    here = next((root / path for root in project_folders() if (root / path).exists()), None)
    return path if here is None else here


def project_folders() -> list[Path]:
    """Where the project's files may be: in a wheel inside the package, in a checkout around it."""
    package = Path(__file__).resolve().parent
    return [package / "project", package.parents[1]]


MOST_SETTINGS = 500_000
"""Bytes of a file of keys and values; reading more takes longer than a user waits."""

_LITTLE = 1_000_000  # bytes; a disk with less is full
_BLOCK = 1 << 20  # bytes read at a time


def portable_name(name: str) -> str:
    """A path as a result may state it: an absolute one, which only this machine has, keeps its last part."""
    path = Path(name)
    return path.name if path.is_absolute() else path.as_posix()


@cache
def _loader() -> Any:
    """A safe loader of YAML that refuses what others take for something else than is written, in silence."""
    import yaml

    class Loader(yaml.SafeLoader):
        """Keys stand once in a mapping; numbers are decimal."""

    def mapping(loader: Any, node: Any) -> Iterator[dict[Any, Any]]:
        seen = set()
        for key, _ in node.value:
            if (name := key.value if isinstance(key, yaml.ScalarNode) else key) in seen:
                raise yaml.MarkedYAMLError(problem=f"{name} stands twice; keep one", problem_mark=key.start_mark)
            seen.add(name)
        return loader.construct_yaml_map(node)

    def number(loader: Any, node: Any) -> float:
        octal = re.match(r"[-+]?0[0-9_]+$", node.value)
        found: float = loader.construct_yaml_int(node) if "." not in node.value else loader.construct_yaml_float(node)
        if octal or ":" in node.value:
            what = f"YAML takes {node.value} for {found:g}; write it without {'leading zeros' if octal else 'colons'}"
            raise yaml.MarkedYAMLError(problem=what, problem_mark=node.start_mark)
        return found

    Loader.add_constructor("tag:yaml.org,2002:map", mapping)
    Loader.add_constructor("tag:yaml.org,2002:int", number)
    Loader.add_constructor("tag:yaml.org,2002:float", number)
    return Loader


def read_mapping(path: Path, what: str, about: str, remedy: str = "check its name and permissions") -> dict[str, Any]:
    """Keys and values of a YAML file.

    Parameters
    ----------
    path : Path
        The file.
    what, about, remedy : str
        What it holds, where that is described, and what to do where it cannot be read, for the messages.

    Raises
    ------
    ConfigError
        If it cannot be read or is no mapping of keys to values, has a key twice, or a number that YAML takes for
        another than it seems, 045 for 37; names the file and, of wrong YAML, the line.
    """
    import yaml

    try:
        if path.stat().st_size > MOST_SETTINGS:
            raise ConfigError(f"{path}: larger than {MOST_SETTINGS} bytes; a {what} is smaller: {about}")
        data = yaml.load(path.read_text(encoding="utf-8-sig"), _loader())
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}); {remedy}") from None
    except ConfigError:
        raise
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: not a UTF-8 text; save it as UTF-8") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line, why = f", line {mark.line + 1}" if mark else "", getattr(error, "problem", None) or "unreadable"
        raise ConfigError(f"{path}{line}: {why if mark and '; ' in why else f'not valid YAML ({why})'}") from None
    except RecursionError:
        raise ConfigError(f"{path}: nested too deeply; {about}") from None
    except (ValueError, KeyError, AttributeError, TypeError) as error:
        # A date such as 2001-02-30, a number of five thousand digits, a tag that the value does not fit.
        raise ConfigError(f"{path}: not valid YAML ({error})") from None
    if not isinstance(data, dict):
        raise ConfigError(f"{path}: a {what} is a mapping of keys to values; {about}")
    return data
