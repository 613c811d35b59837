"""Atomic writes with a checksum, checks of output paths, and reading of YAML mappings."""

import errno
import hashlib
import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any
from uuid import uuid4

from overturning.errors import ArgumentError, ConfigError


def check_output_path(path: Path | None, argument_name: str, *suffixes: str) -> None:
    """Raise an `ArgumentError` if an output file cannot be written or has a wrong suffix.

    `suffixes` are the accepted extensions, such as ``.svg``; without them, any extension is accepted. A `path` of None
    stands for no output file and raises no error.
    """
    if path is None:
        return
    if suffixes and path.suffix.lower() not in suffixes:
        raise ArgumentError(f"{argument_name} {path}: unknown kind of file; use the extension {' or '.join(suffixes)}")
    if not path.parent.is_dir():
        raise ArgumentError(
            f"{argument_name} {path}: there is no folder {path.parent}; create it first, or name another"
        )
    why = "is a folder" if path.is_dir() else ""
    try:  # permissions are not sufficient: some folders are read-only in spite of them
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError:
        why = f"cannot be written into {path.parent}"
    if why:
        raise ArgumentError(f"{argument_name} {path}: {why}; name another file")


def check_outputs_are_separate_files(
    output_paths_by_option: Mapping[str, Path | None], input_paths: Iterable[Path | None]
) -> None:
    """Raise an `ArgumentError` if an output of a command is one of its input files, or two outputs are one file.

    `output_paths_by_option` has the output paths by the name of their option; None stands for no file.
    """
    read, written = {path.resolve() for path in input_paths if path is not None}, dict[Path, str]()
    for option, path in output_paths_by_option.items():
        if path is None:
            continue
        if path.resolve() in read:
            raise ArgumentError(
                f"{option} {path}: an input of the command, which must not be replaced; name another file"
            )
        if other := written.get(path.resolve()):
            raise ArgumentError(f"{option} {path}: the file of {other}, too; name another file")
        written[path.resolve()] = option


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Context manager: write to a temporary file, which replaces ``path`` at the end of the block if no error occurs.

    A missing folder is created. If the block raises an exception, the temporary file is removed and an existing file
    keeps its content. A checksum is appended to NetCDF files (see `append_checksum`).
    """
    part = path.with_name(f".{path.name}.{uuid4().hex[:8]}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.touch(exist_ok=False)
    except OSError as error:  # name the requested file, not the temporary one
        raise OSError(error.errno, error.strerror, str(path)) from None
    try:
        yield part
        if path.suffix == ".nc":
            append_checksum(part)
        part.replace(path)
    except (OSError, RuntimeError) as error:
        # The error for a full disk does not name the file. NetCDF raises another error: its own, or "permission denied"
        # for the temporary file, although it was writable before.
        netcdf = str(error).startswith("NetCDF: ") if isinstance(error, RuntimeError) else error.errno == errno.EACCES
        full = isinstance(error, OSError) and error.errno == errno.ENOSPC
        if full or (netcdf and shutil.disk_usage(path.parent).free < _MAX_FREE_BYTES_OF_FULL_DISK):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path)) from None
        raise
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file (UTF-8) with `atomic_write`."""
    with atomic_write(path) as part:
        part.write_text(text, encoding="utf-8")


_CHECKSUM_LINE_PREFIX = b"\n# sha256 "
_CHECKSUM_LINE_BYTES = len(_CHECKSUM_LINE_PREFIX) + 65  # bytes: 64 digits and the end of the line


# Remedies by error number.
_REMEDY_BY_ERROR_NUMBER = {
    **dict.fromkeys((errno.EACCES, errno.EPERM, errno.EROFS), "choose a folder that you may write to"),
    **dict.fromkeys(
        (errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EEXIST, errno.ENAMETOOLONG, errno.ELOOP),
        "name another file or folder",
    ),
    **dict.fromkeys((errno.ENOSPC, errno.EDQUOT), "free some space and run again; nothing half-written was kept"),
}


def os_error_message_or_empty_without_remedy(error: OSError) -> str:
    """Return a message for an operating-system error, with file and remedy; "" if no remedy is known."""
    remedy = _REMEDY_BY_ERROR_NUMBER.get(error.errno or 0)
    return f"{error.filename or 'a file'}: {str(error.strerror).lower()}; {remedy}" if remedy else ""


def append_checksum(path: Path) -> None:
    """Append the SHA-256 checksum of a file to the file itself, as a separate line.

    The line begins with #, so that it is a comment in a table. Readers of NetCDF and HDF5 ignore data after the end of
    file stated in the header.
    """
    with path.open("r+b") as file:
        digest = hashlib.file_digest(file, "sha256")
        file.write(_CHECKSUM_LINE_PREFIX + digest.hexdigest().encode() + b"\n")


def checksum_at_end_matches(path: Path) -> bool | None:
    """True if the checksum at the end of a file matches; None if it has no checksum or cannot be read."""
    digest = hashlib.sha256()
    try:
        with path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(size - _CHECKSUM_LINE_BYTES, 0))
            end = file.read()
            if not (end.startswith(_CHECKSUM_LINE_PREFIX) and len(end) == _CHECKSUM_LINE_BYTES):
                return None
            file.seek(0)
            left = size - _CHECKSUM_LINE_BYTES
            while left:
                block = file.read(min(left, _READ_CHUNK_BYTES))
                digest.update(block)
                left -= len(block)
    except OSError:
        return None
    return end[len(_CHECKSUM_LINE_PREFIX) : -1] == digest.hexdigest().encode()


def path_in_working_folder_or_package(relative_path: Path) -> Path:
    """Find a project file, such as ``config/records.tsv``, in the working folder or else in the package.

    A wheel contains the project files inside the package, a checkout has them around it.
    """
    if relative_path.exists() or relative_path.is_absolute():
        return relative_path
    here = next(
        (
            root / relative_path
            for root in folders_of_shipped_files_in_wheel_and_checkout()
            if (root / relative_path).exists()
        ),
        None,
    )
    return relative_path if here is None else here


def folders_of_shipped_files_in_wheel_and_checkout() -> list[Path]:
    """Return the folders in which files of the project may lie: in the package (wheel) and around it (checkout)."""
    package = Path(__file__).resolve().parent
    return [package / "project", package.parents[1]]


MAX_YAML_FILE_BYTES = 500_000
"""Largest size of a YAML file, bytes; reading a larger one takes too long."""

_MAX_FREE_BYTES_OF_FULL_DISK = 1_000_000  # bytes; a disk with less free space counts as full
_READ_CHUNK_BYTES = 1 << 20  # bytes read at a time


def convert_argument_to_path(
    argument_name: str, value: Any, description_of_valid_argument: str = "the path of a file"
) -> Path:
    """Convert the argument `argument_name` of a public function to a path.

    Raise an `ArgumentError` that asks for `description_of_valid_argument` if the argument is not a path.
    """
    if not isinstance(value, str | os.PathLike):
        raise ArgumentError(f"{argument_name}: a {type(value).__name__}; give {description_of_valid_argument}")
    return Path(os.fsdecode(value))


def file_name_if_absolute_else_path(path_text: str) -> str:
    """Return a path as results store it: only the file name of an absolute path, a relative path unchanged."""
    path = Path(path_text)
    return path.name if path.is_absolute() else path.as_posix()


@cache
def _strict_yaml_loader_class() -> Any:
    """Return a class for reading YAML that refuses duplicate keys and ambiguous numbers, such as base 60."""
    import yaml

    class StrictYamlLoader(yaml.SafeLoader):
        """YAML loader that rejects repeated keys, and numbers that are not decimal (octal, hexadecimal, base 60)."""

    def construct_mapping(yaml_loader: Any, yaml_node: Any) -> Iterator[dict[Any, Any]]:
        """Return an iterator by which PyYAML builds the mapping of a YAML node; raise an error for a repeated key."""
        seen = set()
        for key, _ in yaml_node.value:
            if (name := key.value if isinstance(key, yaml.ScalarNode) else key) in seen:
                raise yaml.MarkedYAMLError(problem=f"{name} is given twice; keep one", problem_mark=key.start_mark)
            seen.add(name)
        return yaml_loader.construct_yaml_map(yaml_node)

    def construct_plain_decimal_number(yaml_loader: Any, yaml_node: Any) -> float:
        """Return the number of a YAML node; raise an error if it is octal (leading zero) or in base 60 (colons)."""
        octal = re.match(r"[-+]?0[0-9_]+$", yaml_node.value)
        found: float = (
            yaml_loader.construct_yaml_int(yaml_node)
            if "." not in yaml_node.value
            else yaml_loader.construct_yaml_float(yaml_node)
        )
        if octal or ":" in yaml_node.value:
            what = (
                f"YAML reads {yaml_node.value} as {found:g}; write it without {'leading zeros' if octal else 'colons'}"
            )
            raise yaml.MarkedYAMLError(problem=what, problem_mark=yaml_node.start_mark)
        return found

    StrictYamlLoader.add_constructor("tag:yaml.org,2002:map", construct_mapping)
    StrictYamlLoader.add_constructor("tag:yaml.org,2002:int", construct_plain_decimal_number)
    StrictYamlLoader.add_constructor("tag:yaml.org,2002:float", construct_plain_decimal_number)
    return StrictYamlLoader


def read_yaml_mapping(
    path: Path,
    file_description: str,
    documentation_hint: str,
    remedy_if_unreadable: str = "check its name and permissions",
) -> dict[str, Any]:
    """Read the keys and values of a YAML file.

    Parameters
    ----------
    path : Path
        The file.
    file_description, documentation_hint, remedy_if_unreadable : str
        For messages: the kind of file, a reference to its description, and the remedy if it cannot be read.

    Raises
    ------
    ConfigError
        If the file cannot be read, is not a mapping of keys to values, has a duplicate key, or a number that YAML reads
        differently (045 as 37). The message names the file and, for invalid YAML, the line.
    """
    import yaml

    try:
        if path.stat().st_size > MAX_YAML_FILE_BYTES:
            raise ConfigError(
                f"{path}: larger than {MAX_YAML_FILE_BYTES} bytes; "
                f"a {file_description} is smaller: {documentation_hint}"
            )
        data = yaml.load(path.read_text(encoding="utf-8-sig"), _strict_yaml_loader_class())
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}); {remedy_if_unreadable}") from None
    except ConfigError:
        raise
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: not a UTF-8 text; save it as UTF-8") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line, why = f", line {mark.line + 1}" if mark else "", getattr(error, "problem", None) or "unreadable"
        raise ConfigError(f"{path}{line}: {why if mark and '; ' in why else f'not valid YAML ({why})'}") from None
    except RecursionError:
        raise ConfigError(f"{path}: nested too deeply; {documentation_hint}") from None
    except (ValueError, KeyError, AttributeError, TypeError) as error:
        # For example an invalid date (2001-02-30), a number with 5000 digits, or a tag that does not fit the value.
        raise ConfigError(f"{path}: not valid YAML ({error})") from None
    if not isinstance(data, dict):
        raise ConfigError(f"{path}: a {file_description} is a mapping of keys to values; {documentation_hint}")
    return data
