"""Reading a survey."""

import math
from pathlib import Path

import pytest

from overturning.errors import RecordError
from overturning.surveys.stones import COLUMNS, read_survey


def write(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "survey.csv"
    path.write_bytes(text.encode(encoding))
    return path


def test_azimuths_octants_and_counts(tmp_path: Path) -> None:
    stones = read_survey(
        write(
            tmp_path,
            "# cemetery of the temple\nfell,azimuth_deg,octant,count,b_over_h,face_azimuth_deg\n"
            "yes,62.5,,1,0.4,60\n\nyes,,nw,3,,\nno,,,2,0.5,150\n",
        )
    )
    assert [stone.count for stone in stones] == [1, 3, 2]
    assert [stone.line for stone in stones] == [3, 5, 6]
    assert (stones[0].azimuth_deg, stones[0].octant, stones[0].face_azimuth_deg) == (62.5, False, 60)
    assert (stones[1].azimuth_deg, stones[1].octant) == (315, True)
    assert math.isnan(stones[1].b_over_h)
    assert not stones[2].fell
    assert not any(stone.round for stone in stones)
    assert math.isnan(stones[2].azimuth_deg)


def test_a_direction_means_that_it_fell(tmp_path: Path) -> None:
    assert read_survey(write(tmp_path, "octant\nE\n"))[0].fell


def test_magnetic_declination_is_added(tmp_path: Path) -> None:
    text = "azimuth_deg,face_azimuth_deg,magnetic_declination_deg\n5,350,-7.5\n"
    stone = read_survey(write(tmp_path, text))[0]
    assert stone.azimuth_deg == pytest.approx(357.5)
    assert stone.face_azimuth_deg == pytest.approx(342.5)


def test_byte_order_mark_and_crlf(tmp_path: Path) -> None:
    assert len(read_survey(write(tmp_path, "octant,count\r\nN,2\r\n", "utf-8-sig"))) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("octant\n", "no stone"),
        ("direction\nN\n", "'direction' is not known"),
        ("count\n3\n", "azimuth_deg or octant"),
        ("octant,octant\nN,N\n", "each column once"),
        ("octant\nNNE\n", "line 2: column octant 'NNE'"),
        ("azimuth_deg\n400\n", "from -360 to 360"),
        ("azimuth_deg\nnan\n", "from -360 to 360"),
        ("azimuth_deg\nnorth\n", "give a number"),
        ("azimuth_deg,octant\n10,N\n", "not both"),
        ("octant,fell\nN,no\n", "has no fall direction"),
        ("octant,fell\n,yes\n", "needs azimuth_deg or octant"),
        ("octant,fell\nN,perhaps\n", "write yes or no"),
        # 1° of declination more would move all stones of a survey by 45°: 22° is N, 23° is NE.
        ("octant,magnetic_declination_deg\nN,22\n", "22° from true north, lies across two octants"),
        ("octant,count\nN,1.5\n", "whole number"),
        ("octant,count\nN,0\n", "count '0'"),
        ("octant,count\nN\n", "line 2: 1 cells, the header names 2"),
        ("octant,b_over_h\nN,-0.4\n", "b_over_h '-0.4'"),
        ("octant,height_m\nN,60\n", "a stone is 0.01 to 50 m high; is that in centimetres"),
    ],
)
def test_refuses(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(RecordError, match=message) as error:
        read_survey(write(tmp_path, text))
    assert "survey.csv" in str(error.value)


def test_not_a_text(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="UTF-8"):
        read_survey(write(tmp_path, "octant\n北\n", "shift_jis"))
    with pytest.raises(RecordError, match="cannot be read"):
        read_survey(tmp_path)
    with pytest.raises(RecordError, match="cannot be read"):
        read_survey(tmp_path / "nothing.csv")


def test_the_documentation_names_every_column() -> None:
    text = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")
    section = text.partition("## Surveys")[2].partition("\n## ")[0]
    assert [name for name in COLUMNS if f"| `{name}` |" not in section] == []


def test_a_cell_without_end_is_refused_by_its_line(tmp_path: Path) -> None:
    path = tmp_path / "stones.csv"
    path.write_text(f"octant\nN\n{'N' * 200_000}\n", encoding="utf-8")
    with pytest.raises(RecordError, match=r"stones\.csv line 3: field larger than field limit"):
        read_survey(path)


def test_stones_that_all_stood_need_no_direction(tmp_path: Path) -> None:
    stones = read_survey(write(tmp_path, "fell,b_over_h,height_m,count\nno,0.3,0.6,4\nno,0.25,0.9,2\n"))
    assert [(stone.fell, stone.count) for stone in stones] == [(False, 4), (False, 2)]
    with pytest.raises(RecordError, match=r"line 2: .*fell: a stone that fell needs azimuth_deg or octant"):
        read_survey(write(tmp_path, "fell,b_over_h\nyes,0.3\n"))
