"""What was measured reaches its files and the marks in the docs, and the same bytes each time."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from overturning.errors import ResultError
from verification import summary
from verification.tables import Figure, figures_table, publish, read_figures, read_table, write_figures, write_table


def test_table_reads_back_and_is_the_same_each_time(tmp_path: Path) -> None:
    rows = pd.DataFrame({"a": [1.0, np.nan], "b": ["x", ""], "c": np.array([1, -128], np.int8)})
    meanings = {name: (name, "1") for name in rows}
    for name in ("one", "two"):
        write_table(rows, tmp_path / f"{name}.nc", meanings=meanings, attributes={"seed": 1})
    back = read_table(tmp_path / "one.nc")
    assert back.attrs == {"seed": 1}
    for name, values in rows.items():
        np.testing.assert_array_equal(back[name].to_numpy(), values.to_numpy())
    assert back["c"].dtype == np.int8
    assert (tmp_path / "one.nc").read_bytes() == (tmp_path / "two.nc").read_bytes()
    assert (tmp_path / "one.csv").read_text(encoding="utf-8") == "a,b,c\n1,x,1\nnan,,-128\n"
    with pytest.raises(ResultError, match="make verify"):
        read_table(tmp_path / "none.nc")


def test_pages_change_between_their_marks_only(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    pages = [tmp_path / "README.md", tmp_path / "docs" / "page.md", tmp_path / "docs" / "other.md"]
    for page in pages[:2]:
        page.write_text("before\n<!-- x:begin -->\nold\n<!-- x:end -->\nafter\n", encoding="utf-8")
    pages[2].write_text("nothing", encoding="utf-8")
    for _ in range(2):
        publish({"x": r"new \1"}, tmp_path)
    for page in pages[:2]:
        text = "before\n<!-- x:begin -->\n\nnew \\1\n\n<!-- x:end -->\nafter\n"
        assert page.read_text(encoding="utf-8") == text
    assert pages[2].read_text(encoding="utf-8") == "nothing"
    with pytest.raises(ResultError, match="y:begin"):
        publish({"y": "", "x": "newer"}, tmp_path)
    assert "newer" in pages[0].read_text(encoding="utf-8"), "what has its marks is published all the same"


def test_figures_measured_again_take_the_place_of_the_old_ones(tmp_path: Path) -> None:
    path = tmp_path / "exactness.csv"
    write_figures([Figure("speed", 3.0, "x", ">= 2"), Figure("cases", 20_000)], path)
    assert write_figures([Figure("speed", 2.5, "x", ">= 2")], path, keep=True) == read_figures(path)
    assert figures_table(read_figures(path)).splitlines()[2:] == ["| speed | 2.5 x | >= 2 |", "| cases | 20,000 |  |"]
    assert "speed | >= 2 | 2.5 x | [exactness.csv]" in summary.bodies(tmp_path)["summary"]
    assert "cases" not in summary.bodies(tmp_path)["summary"], "what has no target is not in the summary"
