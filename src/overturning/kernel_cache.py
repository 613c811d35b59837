"""Cache of compiled functions on disk, in a folder named after a digest of all sources: an edit compiles them again."""

import hashlib
import logging
import os
import pickle
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba.core.runtime import rtsys

_LOG = logging.getLogger(__name__)
_PACKAGE_FOLDER = Path(__file__).parent
_SOURCE_PATHS_IN_KERNEL_DIGEST = (
    _PACKAGE_FOLDER / "units.py",
    Path(__file__),
    *(path for room in ("dem", "model") for path in (_PACKAGE_FOLDER / room).rglob("*.py")),
)
"""Modules whose functions or constants are compiled into the kernels, and this one."""


def sources_digest(kernel_source_folder: Path) -> str:
    """Return a digest (16 hex digits) of all source files on which the compiled kernels of a folder depend."""
    digest = hashlib.sha256()
    for path in sorted({*_SOURCE_PATHS_IN_KERNEL_DIGEST, *kernel_source_folder.rglob("*.py")}):
        digest.update(
            path.relative_to(_PACKAGE_FOLDER if path.is_relative_to(_PACKAGE_FOLDER) else kernel_source_folder)
            .as_posix()
            .encode()
        )
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


_CHECKSUM_SIZE_BYTES = 32  # bytes

_DEFAULT_KERNEL_SOURCE_FOLDER = _PACKAGE_FOLDER / "dem"
_SOURCES_DIGEST_AT_IMPORT_BY_FOLDER = {_DEFAULT_KERNEL_SOURCE_FOLDER: sources_digest(_DEFAULT_KERNEL_SOURCE_FOLDER)}
"""Digest of the kernels' sources at import time; this module is imported before all that is compiled."""


def kernel_cache_directory(kernel_source_folder: Path | None = None) -> Path:
    """Return the cache folder for the compiled kernels of a source folder, by default that of the package `dem`.

    Numba checks for changes only the file of the function that it loads, not the files of called functions or of
    compiled-in constants. The folder is therefore named after the digest of all these files (`sources_digest`). It
    lies below ``NUMBA_CACHE_DIR`` if that is set, otherwise below the user's cache folder.
    """
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base is None:
        import platformdirs

        base = str(Path(platformdirs.user_cache_dir("overturning")) / "kernels")
    return Path(base) / f"overturning-{sources_digest(kernel_source_folder or _DEFAULT_KERNEL_SOURCE_FOLDER)}"


def subpackage_folder_of_module(module_path: Path) -> Path:
    """Return the folder of the subpackage (such as `dem`) that contains a module.

    For a module outside the package, it is the folder of the module.
    """
    if module_path.is_relative_to(_PACKAGE_FOLDER):
        return _PACKAGE_FOLDER / module_path.relative_to(_PACKAGE_FOLDER).parts[0]
    return module_path.parent


def _make_cache_file_use_checksums(numba_cache_file: Any) -> None:
    """Make a Numba cache-file object append a SHA-256 checksum to files that it saves, and verify it before loading."""
    dump, load_index, load_data = numba_cache_file._dump, numba_cache_file._load_index, numba_cache_file._load_data

    def serialise_with_checksum(object_to_serialise: Any) -> bytes:
        data: bytes = dump(object_to_serialise)  # unpickling ignores the digest that follows
        return data + hashlib.sha256(data).digest()

    def verify_checksum(data_with_checksum: bytes) -> None:
        if (
            hashlib.sha256(data_with_checksum[:-_CHECKSUM_SIZE_BYTES]).digest()
            != data_with_checksum[-_CHECKSUM_SIZE_BYTES:]
        ):
            raise ValueError("damaged")

    def verify_checksum_and_load_index() -> Any:
        with suppress(FileNotFoundError), open(numba_cache_file._index_path, "rb") as index:
            pickle.load(index)  # Numba's version, written before the sealed content
            verify_checksum(index.read())
        return load_index()

    def load_checked_data(machine_code_file_name: str) -> Any:
        verify_checksum(Path(numba_cache_file._data_path(machine_code_file_name)).read_bytes())
        return load_data(machine_code_file_name)

    numba_cache_file._dump, numba_cache_file._load_index, numba_cache_file._load_data = (
        serialise_with_checksum,
        verify_checksum_and_load_index,
        load_checked_data,
    )


def cache_compiled_kernel(numba_dispatcher: Any) -> Any:
    """Let Numba cache the machine code of a compiled function in `kernel_cache_directory`; return the same function.

    The function is declared without ``cache=True``, since caching is enabled here.

    With a damaged index or code file, Numba alone raises an error in every run, or runs damaged code. Here such files
    are removed and the function compiled again. If the folder is not writable, every process compiles the function.
    """
    try:
        numba_dispatcher.enable_caching()
    except RuntimeError:  # Numba finds no writable folder
        return numba_dispatcher
    cache = numba_dispatcher._cache
    file = cache._cache_file
    layer = subpackage_folder_of_module(Path(numba_dispatcher.py_func.__code__.co_filename))
    folder, imported = (
        kernel_cache_directory(layer),
        _SOURCES_DIGEST_AT_IMPORT_BY_FOLDER.get(layer) or sources_digest(layer),
    )
    cache._cache_path = file._cache_path = str(folder)
    name = Path(file._index_path).stem
    file._source_stamp = folder.name  # contents, not the time at which the file was checked out
    cache._impl.locator.get_cache_path = lambda: str(folder)
    # Not `load_overload`, which first prepares compilation (imports scipy.linalg): half of the loading time.
    load, save = cache._load_overload, cache.save_overload

    def set_cache_file_names_for_kernel_input_type(numba_argument_types: Any) -> None:
        # One index per model, by the type of the kernel input: unpickling an index imports the modules of its models.
        model = getattr(next(iter(numba_argument_types), None), "instance_class", None)
        base = f"{name}.{model.__name__}" if model else name
        file._index_path, file._data_name_pattern = str(folder / f"{base}.nbi"), f"{base}.{{number:d}}.nbc"

    def load_kernel_or_none(numba_argument_types: Any, target_context: Any) -> Any:
        try:
            set_cache_file_names_for_kernel_input_type(numba_argument_types)
            rtsys.initialize(target_context)
            return load(numba_argument_types, target_context)
        except Exception:  # unpickling a torn file can raise nearly anything
            _LOG.debug("cached kernel %s cannot be loaded and is compiled again", file._index_path, exc_info=True)
            for path in folder.glob(f"{Path(file._index_path).stem}.*"):
                path.unlink(missing_ok=True)
            return None

    def save_kernel_unless_sources_changed(numba_argument_types: Any, numba_compile_result: Any) -> None:
        # Sources edited after import are compiled in their old state; do not cache that under the new digest.
        if sources_digest(layer) == imported:
            set_cache_file_names_for_kernel_input_type(numba_argument_types)
            with suppress(OSError):
                save(numba_argument_types, numba_compile_result)

    _make_cache_file_use_checksums(file)
    cache.load_overload = load_kernel_or_none
    cache.save_overload = save_kernel_unless_sources_changed
    return numba_dispatcher
