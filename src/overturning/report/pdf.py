"""The report as PDF, by typst. No words of the report stand here; all text reaches typst as data, never as markup."""

import json
import shutil
import tempfile
from dataclasses import fields, is_dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from overturning.errors import ResultError
from overturning.report.blocks import Figure, Film, Paragraph, Report


def paper_data(part: Any, files: dict[Path, str]) -> Any:
    """A report, or a part of it, as plain data for typst: each block with its class as ``kind``, a film as its strip.

    A short name stands for the path of a figure; ``files`` receives it.
    """
    if isinstance(part, Film):
        part = Paragraph(part.text) if part.strip is None else Figure(part.strip, part.text, part.text)
    if is_dataclass(part):
        kind = type(part).__name__.lower()
        return {"kind": kind} | {field.name: paper_data(getattr(part, field.name), files) for field in fields(part)}
    if isinstance(part, tuple):
        return [paper_data(one, files) for one in part if getattr(one, "medium", "") != "page"]
    return files.setdefault(part, f"{len(files)}{part.suffix}") if isinstance(part, Path) else part


def render_pdf(report: Report) -> bytes:
    """The pages, the same bytes each time.

    Raises
    ------
    ResultError
        If a figure cannot be read.
    """
    import typst

    files: dict[Path, str] = {}
    data = json.dumps(paper_data(report, files), ensure_ascii=False)
    with tempfile.TemporaryDirectory() as name, resources.as_file(resources.files("overturning")) as package:
        folder = Path(name)
        shutil.copyfile(package / "report" / "templates" / "report.typ", folder / "report.typ")
        (folder / "data.json").write_text(data, encoding="utf-8")
        for path, file in files.items():
            shutil.copyfile(path, folder / file)
        try:
            # Only the fonts that come with typst, and no clock: the same pages on every machine.
            pages: bytes = typst.compile(
                folder / "report.typ", root=folder, format="pdf", ignore_system_fonts=True, font_paths=[], timestamp=0
            )
        except typst.TypstError as error:
            reason = str(error).splitlines()[0]
            raise ResultError(f"the PDF of the report cannot be made ({reason}); draw the figures again") from None
    return pages
