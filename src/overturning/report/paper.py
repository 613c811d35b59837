"""The report as PDF, by typst: tokens of its Markdown as data, so that no text is read as markup."""

import json
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from importlib import resources
from itertools import chain
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote
from xml.etree import ElementTree

from markdown_it.tree import SyntaxTreeNode

from overturning.errors import ResultError
from overturning.report.drawings import PHONE_FIGURE_PREFIX
from overturning.report.render import markdown_container_name_and_text, parse_markdown_line, single_image_of_paragraph
from overturning.translation.texts import (
    check_font_is_installed,
    font_language_of_text,
    installed_fonts_of_language,
    read_label_translations,
)

MARKDOWN_CONTAINERS_LEFT_OUT_OF_PDF: Final = ("fold", "page")
"""Containers that paper does not show."""


def compile_report_pdf(
    markdown_tree: SyntaxTreeNode, document_title: str, language: str, figure_path_by_name: Mapping[str, Path]
) -> bytes:
    """Return the report as the bytes of a PDF file; equal inputs give equal bytes.

    Parameters
    ----------
    markdown_tree : SyntaxTreeNode
        Text of the report, from `render.parse_markdown_and_number_figures_and_tables`.
    document_title : str
        Title of the document.
    language : str
        Code of the language.
    figure_path_by_name : mapping of str to Path
        Files of the figures by the names that the text uses.

    Raises
    ------
    ResultError
        If a figure cannot be read.
    MissingDataError
        If there is no font of the language.
    """
    import typst

    files: dict[str, str] = {}
    check_font_is_installed(language, "PDF of the report")
    blocks = _convert_to_pdf_blocks_and_name_figure_files(markdown_tree.children, figure_path_by_name, files)
    figure_files = [figure_path_by_name[each] for each in files]
    fonts = installed_fonts_of_language(language) or _installed_japanese_fonts_if_needed(
        document_title, blocks, figure_files
    )
    words = {kind: read_label_translations(language)[kind] for kind in ("figure", "table")}
    data = {
        "title": document_title,
        "language": language,
        "fonts": fonts,
        "words": words,
        "blocks": blocks,
    }
    with tempfile.TemporaryDirectory() as name, resources.as_file(resources.files("overturning")) as room:
        folder = Path(name)
        shutil.copyfile(room / "report" / "templates" / "report.typ", folder / "report.typ")
        (folder / "data.json").write_text(json.dumps(data, ensure_ascii=False), encoding="utf-8")
        for each, short in files.items():
            shutil.copyfile(figure_path_by_name[each], folder / f"{short}{figure_path_by_name[each].suffix}")
        try:
            # Without a clock, and without fonts of the system unless language or names need them: the same bytes.
            pages: bytes = typst.compile(
                folder / "report.typ", root=folder, format="pdf", ignore_system_fonts=not fonts, font_paths=[],
                timestamp=0, sys_inputs={"files": json.dumps({short: f"{short}{figure_path_by_name[each].suffix}"
                                                              for each, short in files.items()})},
            )  # fmt: skip
        except typst.TypstError as error:
            reason = str(error).splitlines()[0]
            raise ResultError(
                f"the PDF of the report cannot be made ({reason}); {_advice_after_pdf_failure(figure_files)}"
            ) from None
    return pages


def _installed_japanese_fonts_if_needed(
    document_title: str, pdf_blocks: list[dict[str, Any]], figure_paths: Iterable[Path]
) -> list[str]:
    """Return installed fonts for Japanese characters in the report's texts or figures; [] if there are none."""
    texts = (
        document_title,
        json.dumps(pdf_blocks, ensure_ascii=False),
        *(path.read_text(encoding="utf-8") for path in figure_paths),
    )
    last = max(chain.from_iterable(texts), default="")
    return installed_fonts_of_language(font_language_of_text(last))


def _advice_after_pdf_failure(figure_paths: Iterable[Path]) -> str:
    """Return advice for the user if the PDF cannot be made, naming a figure (SVG) that is damaged, if any."""
    for path in figure_paths:
        try:
            ElementTree.parse(path)
        except ElementTree.ParseError:
            return f"{path} is damaged: delete it, and run the study again"
    return "draw the figures again"


def _convert_to_pdf_blocks_and_name_figure_files(
    nodes: list[SyntaxTreeNode],
    figure_path_by_name: Mapping[str, Path],
    short_file_name_by_figure: dict[str, str],
    nodes_are_in_figure_pair: bool = False,
) -> list[dict[str, Any]]:
    """Convert the report's Markdown nodes to dictionaries (paragraphs, tables, figures) for the PDF template.

    A short file name for each figure is added to `short_file_name_by_figure`. Two figures side by side have half the
    width of the text each; the version of a figure that was drawn for phones is used there, if there is one.
    """
    blocks: list[dict[str, Any]] = []
    for node in nodes:
        name, text = markdown_container_name_and_text(node)
        if name in MARKDOWN_CONTAINERS_LEFT_OUT_OF_PDF:
            continue
        if name in ("table", "sortable"):
            caption = {"number": node.meta["table"], "caption": _convert_to_pdf_text_parts(parse_markdown_line(text))}
            blocks += [
                one | caption
                for one in _convert_to_pdf_blocks_and_name_figure_files(
                    node.children, figure_path_by_name, short_file_name_by_figure, nodes_are_in_figure_pair
                )
            ]
        elif name == "paper":
            blocks += _convert_to_pdf_blocks_and_name_figure_files(
                node.children, figure_path_by_name, short_file_name_by_figure, nodes_are_in_figure_pair
            )
        elif name:
            inner = _convert_to_pdf_blocks_and_name_figure_files(
                node.children,
                figure_path_by_name,
                short_file_name_by_figure,
                nodes_are_in_figure_pair or name == "pair",
            )
            blocks.append({"kind": "box", "name": name, "blocks": inner})
        elif image := single_image_of_paragraph(node):
            source = unquote(str(image.attrs["src"]))
            source = (
                f"{PHONE_FIGURE_PREFIX}{source}"
                if nodes_are_in_figure_pair and f"{PHONE_FIGURE_PREFIX}{source}" in figure_path_by_name
                else source
            )
            blocks.append({
                "kind": "figure", "alt": image.content,
                "file": short_file_name_by_figure.setdefault(source, f"{len(short_file_name_by_figure)}"),
                "number": node.meta["figure"], "caption": str(image.attrs.get("title", "")),
                "paired": nodes_are_in_figure_pair,
            })  # fmt: skip
        elif node.type == "heading":
            blocks.append({"kind": "heading", "level": int(node.tag[1:]), "text": _convert_to_pdf_text_parts(node)})
        elif node.type in ("fence", "code_block"):
            blocks.append({"kind": "code", "text": node.content})
        elif node.type == "table":
            blocks.append(_convert_to_pdf_table(node))
        elif node.type in ("bullet_list", "ordered_list"):
            blocks.append(
                {
                    "kind": "list",
                    "items": [
                        _convert_to_pdf_blocks_and_name_figure_files(
                            item.children,
                            figure_path_by_name,
                            short_file_name_by_figure,
                            nodes_are_in_figure_pair,
                        )
                        for item in node.children
                    ],
                }
            )
        elif node.type == "paragraph":
            blocks.append({"kind": "paragraph", "text": _convert_to_pdf_text_parts(node)})
        else:
            blocks += _convert_to_pdf_blocks_and_name_figure_files(
                node.children, figure_path_by_name, short_file_name_by_figure, nodes_are_in_figure_pair
            )
    return blocks


def _convert_to_pdf_table(table_node: SyntaxTreeNode) -> dict[str, Any]:
    """Convert a table of the report to a dictionary for the PDF template."""
    rows = [
        [_convert_to_pdf_text_parts(cell) for cell in row.children]
        for group in table_node.children
        for row in group.children
    ]
    cells = table_node.children[0].children[0].children
    right = ["right" in str(cell.attrs.get("style", "")) for cell in cells]
    return {"kind": "table", "right": right, "rows": rows, "number": None, "caption": []}


def _convert_to_pdf_text_parts(node: SyntaxTreeNode) -> list[dict[str, Any]]:
    """Convert the text of a paragraph, heading or cell to dictionaries for the PDF template, one per piece of text."""
    parts: list[dict[str, Any]] = []
    for one in node.children:
        if one.type in ("strong", "em"):
            parts.append({"kind": one.type, "parts": _convert_to_pdf_text_parts(one)})
        elif one.type == "link":
            # A place on the page, or another file, cannot be reached from paper: the text of the link remains.
            parts += _convert_to_pdf_text_parts(one)
        elif one.type == "code_inline":
            parts.append({"kind": "code", "text": one.content})
        elif one.type in ("softbreak", "hardbreak"):
            parts.append({"kind": "text", "text": " "})
        else:
            parts += _convert_to_pdf_text_parts(one) if one.children else [{"kind": "text", "text": one.content}]
    return parts
