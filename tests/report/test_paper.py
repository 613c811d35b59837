"""The report on paper has what the page has."""

import re
import zlib
from pathlib import Path

from overturning.report.content import content
from overturning.report.paper import paper_data, write_paper
from overturning.report.scene_content import sentence
from overturning.statistics.elements import ElementFalls, StoneComparison

SQUARE = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10"><rect width="8" height="8"/></svg>'


def drawn(path: Path) -> int:
    """Rough size of what the pages draw: bytes of the inflated streams."""
    total = 0
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", path.read_bytes(), flags=re.DOTALL):
        try:
            total += len(zlib.decompress(stream))
        except zlib.error:
            continue
    return total


def test_the_scene(hostile: Path, tmp_path: Path) -> None:
    data = content(hostile)
    write_paper(data, hostile / "figures", tmp_path / "without.pdf")
    data["scene"] = {
        "drawing": SQUARE,
        "roses": SQUARE,
        "elements": [("A shaft on #two bases", ElementFalls("shaft", 12, 6, 6, 0.5, float("nan")))],
        "comparisons": [sentence(StoneComparison("shaft", "monolith", 12, 4, 2, 1, 5, 3, 2))],
    }
    shown = paper_data(data)["scene"]
    assert shown["rows"] == [["A shaft on #two bases", "shaft", "12", "6", "50\u00a0%", "6", "–"]]
    assert "they go to the same side in 75\u00a0%" in shown["comparisons"][0]
    write_paper(data, hostile / "figures", tmp_path / "with.pdf")
    assert drawn(tmp_path / "with.pdf") > drawn(tmp_path / "without.pdf") + 1000


def test_a_study_of_a_block_has_none(hostile: Path) -> None:
    assert paper_data(content(hostile))["scene"] is None
