"""Digest of source files: a change of the package makes the workflow run the steps again that depend on it.

Snakemake's own trigger looks at the command of a rule, not at the package that the command calls.
"""

import hashlib
from functools import cache
from pathlib import Path
from typing import Final

PACKAGE_FOLDER: Final = Path(__file__).parents[1]
_HASHED_FILE_SUFFIXES: Final = {".py", ".html", ".css", ".js", ".typ", ".j2", ".yaml"}


@cache
def package_source_hash(*folders_and_files: str) -> str:
    """Compute a hash of source files of this package: its top-level modules, and the given folders or files.

    Parameters
    ----------
    *folders_and_files : str
        Folders or files of the package, such as ``"dem"`` or ``"commands/workflow.py"``.

    Returns
    -------
    str
        16 hexadecimal digits.

    Raises
    ------
    FileNotFoundError
        If the package has no such folder or file.
    """
    found = set(PACKAGE_FOLDER.glob("*.py"))
    for place in folders_and_files:
        path = PACKAGE_FOLDER / place
        if not path.exists():
            raise FileNotFoundError(f"{place}: no folder or file of the package")
        found |= {path} if path.is_file() else {one for one in path.rglob("*") if one.suffix in _HASHED_FILE_SUFFIXES}
    digest = hashlib.sha256()
    for path in sorted(found):
        digest.update(path.relative_to(PACKAGE_FOLDER).as_posix().encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:16]
