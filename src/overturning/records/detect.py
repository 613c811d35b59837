"""Which format a file has, by its content."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from overturning.errors import RecordError
from overturning.records.component import Component
from overturning.records.formats import knet
from overturning.records.source import SourceFile


@dataclass(frozen=True)
class Format:
    """A file format: how to recognise it and how to read it."""

    name: str
    title: str
    detect: Callable[[SourceFile], bool]
    read: Callable[[SourceFile], list[Component]]


FORMATS: Final = (Format(knet.NAME, "K-NET / KiK-net ASCII", knet.detect, knet.read),)
"""In the order in which they are tried; the first that recognises a file reads it."""


def detect_format(source: SourceFile) -> Format:
    """The format of a file.

    Raises
    ------
    RecordError
        If no format recognises it.
    """
    for form in FORMATS:
        if form.detect(source):
            return form
    beginning = source.data[:200].lstrip()[:1]
    hint = "it is a web page, not data: " if beginning == b"<" else ""
    raise RecordError(
        f"{source.name}: {hint}the format is not recognised; known are {', '.join(f.name for f in FORMATS)} "
        "(docs/formats.md): convert it, or get it again"
    )
