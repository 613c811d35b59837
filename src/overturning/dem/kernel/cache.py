"""Where compiled kernels are kept, so that an edited kernel is never answered by a stale one."""

import hashlib
import os
import pickle
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba.core.runtime import rtsys

_PACKAGE = Path(__file__).parents[2]
_COMPILED = (_PACKAGE / "units.py", *(path for room in ("dem", "model") for path in (_PACKAGE / room).rglob("*.py")))
"""Modules of which something is compiled into the kernels."""


def sources_digest(folder: Path) -> str:
    """First 16 hex digits of the SHA-256 over names and contents of `_COMPILED` and of all modules of a folder."""
    digest = hashlib.sha256()
    for path in sorted({*_COMPILED, *folder.rglob("*.py")}):
        digest.update(path.relative_to(_PACKAGE if path.is_relative_to(_PACKAGE) else folder).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


_DIGEST = 32  # bytes

_IMPORTED = {Path(__file__).parents[1]: sources_digest(Path(__file__).parents[1])}
"""Digest of this layer as it is imported: this module comes before all that is compiled."""


def cache_directory(sources: Path | None = None) -> Path:
    """Folder of the compiled kernels of the layer in the folder `sources`; `dem` where not given.

    Numba looks only at the file of the function that it loads; a function that changed in another file goes unnoticed.
    The folder is therefore named after a hash of every module of the layer, with those of its subfolders: they share
    functions, and constants are compiled in, too. It lies below ``NUMBA_CACHE_DIR`` where that is set, else below the
    user's cache folder.
    """
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base is None:
        import platformdirs

        base = str(Path(platformdirs.user_cache_dir("overturning")) / "kernels")
    return Path(base) / f"overturning-{sources_digest(sources or Path(__file__).parents[1])}"


def layer_of(module: Path) -> Path:
    """Folder of the package's layer that a module is in, with all that it may be compiled with; else its own folder."""
    return _PACKAGE / module.relative_to(_PACKAGE).parts[0] if module.is_relative_to(_PACKAGE) else module.parent


def _seal(file: Any) -> None:
    """Let a cache of Numba's check the SHA-256 of what it loads: with another byte in it, code computes anything."""
    dump, load_index, load_data = file._dump, file._load_index, file._load_data

    def sealed(content: Any) -> bytes:
        data: bytes = dump(content)  # what is unpickled ends where it ends; the rest is not looked at
        return data + hashlib.sha256(data).digest()

    def check(data: bytes) -> None:
        if hashlib.sha256(data[:-_DIGEST]).digest() != data[-_DIGEST:]:
            raise ValueError("damaged")

    def checked_index() -> Any:
        with suppress(FileNotFoundError), open(file._index_path, "rb") as index:
            pickle.load(index)  # the version, ahead of what was sealed
            check(index.read())
        return load_index()

    def checked_data(name: str) -> Any:
        check(Path(file._data_path(name)).read_bytes())
        return load_data(name)

    file._dump, file._load_index, file._load_data = sealed, checked_index, checked_data


def keep_compiled(dispatcher: Any) -> Any:
    """Let a function jitted without ``cache=True`` keep its code in `cache_directory`; returns the same function.

    Numba answers a damaged index or code file with an error that persists, or runs it. Here such a file is removed and
    the kernel compiled again; a folder that cannot be written costs the compilation, not the answer.
    """
    try:
        dispatcher.enable_caching()
    except RuntimeError:  # no place that Numba thinks writable
        return dispatcher
    cache = dispatcher._cache
    file = cache._cache_file
    layer = layer_of(Path(dispatcher.py_func.__code__.co_filename))
    folder, imported = cache_directory(layer), _IMPORTED.get(layer) or sources_digest(layer)
    cache._cache_path = file._cache_path = str(folder)
    name = Path(file._index_path).stem
    file._source_stamp = folder.name  # contents, not the time at which the file was checked out
    cache._impl.locator.get_cache_path = lambda: str(folder)
    # Not `load_overload`, which first makes ready to compile, with scipy.linalg: half of the time that loading takes.
    load, save = cache._load_overload, cache.save_overload

    def keep_apart(signature: Any) -> None:
        # A model's own index, by the type of its rules: to read what it names imports the modules of all models in it.
        model = getattr(next(iter(signature), None), "instance_class", None)
        base = f"{name}.{model.__name__}" if model else name
        file._index_path, file._data_name_pattern = str(folder / f"{base}.nbi"), f"{base}.{{number:d}}.nbc"

    def load_or_miss(signature: Any, target_context: Any) -> Any:
        try:
            keep_apart(signature)
            rtsys.initialize(target_context)
            return load(signature, target_context)
        except Exception:  # unpickling a torn file can raise nearly anything
            for path in folder.glob(f"{Path(file._index_path).stem}.*"):
                path.unlink(missing_ok=True)
            return None

    def save_if_possible(signature: Any, data: Any) -> None:
        # What was edited after it was imported is compiled as it was; kept, it would answer for what it is now.
        if sources_digest(layer) == imported:
            keep_apart(signature)
            with suppress(OSError):
                save(signature, data)

    _seal(file)
    cache.load_overload = load_or_miss
    cache.save_overload = save_if_possible
    return dispatcher
