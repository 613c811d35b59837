"""Reading a survey."""

import math
from collections.abc import Iterable
from pathlib import Path

import pytest

from overturning.errors import RecordError
from overturning.surveys.counted_stones import read_counted_stones, read_fallen_and_standing_stones_notes_and_warnings
from overturning.surveys.stones import SURVEY_COLUMNS


def write_survey(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    """Write the text of a survey to a file and return its path."""
    path = folder / "survey.csv"
    path.write_bytes(text.encode(encoding))
    return path


def test_azimuths_octants_counts_and_line_numbers_are_read(tmp_path: Path) -> None:
    stones = read_counted_stones(
        write_survey(
            tmp_path,
            "# cemetery of the temple\nfell,azimuth_deg,octant,count,b_over_h,face_azimuth_deg\n"
            "yes,62.5,,1,0.4,60\n\nyes,,nw,3,,\nno,,,2,0.5,150\n",
        )
    )
    assert [stone.stone_count for stone in stones] == [1, 3, 2]
    assert [stone.line_number for stone in stones] == [3, 5, 6]
    assert (stones[0].fall_azimuth_deg, stones[0].has_octant_direction, stones[0].face_azimuth_deg) == (62.5, False, 60)
    assert (stones[1].fall_azimuth_deg, stones[1].has_octant_direction) == (315, True)
    assert math.isnan(stones[1].b_over_h)
    assert not stones[2].fell
    assert not any(stone.has_round_plan for stone in stones)
    assert math.isnan(stones[2].fall_azimuth_deg)


def test_a_stone_with_a_direction_counts_as_fallen(tmp_path: Path) -> None:
    assert read_counted_stones(write_survey(tmp_path, "octant\nE\n"))[0].fell


def test_magnetic_declination_is_added(tmp_path: Path) -> None:
    text = "azimuth_deg,face_azimuth_deg,magnetic_declination_deg\n5,350,-7.5\n"
    stone = read_counted_stones(write_survey(tmp_path, text))[0]
    assert stone.fall_azimuth_deg == pytest.approx(357.5)
    assert stone.face_azimuth_deg == pytest.approx(342.5)


def test_survey_with_byte_order_mark_and_crlf_is_read(tmp_path: Path) -> None:
    assert len(read_counted_stones(write_survey(tmp_path, "octant,count\r\nN,2\r\n", "utf-8-sig"))) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("octant\n", "no stone"),
        ("bearing\nN\n", "'bearing' is not known; did you mean azimuth_deg"),
        ("azimuht\n10\n", "did you mean azimuth_deg"),
        ("Azimuth (gon)\n10\n", "did you mean azimuth_deg"),
        ("octant,cuont\nN,3\n", "did you mean count"),
        ("azimut,fell\n10,yes\n", "did you mean azimuth_deg"),
        ("octant,counts\nN,3\n", "did you mean count"),
        ("octant,fell?\nN,yes\n", "did you mean fell"),
        ("octant,height\nN,0.6\n", "did you mean height_m"),
        ("octant,height_cm\nN,60\n", "did you mean height_m"),
        ("octant,B/H\nN,0.4\n", "did you mean b_over_h"),
        ("octant,fallen\nN,yes\n", "did you mean fell"),
        ("azimuth_deg,octant,fell,note\n10,,,\n,,,leans\n", "line 3: fell: empty, and no direction; write no for"),
        ("count\n3\n", "azimuth_deg or octant"),
        ("octant,octant\nN,N\n", "each column once"),
        ("octant\nNNE\n", "line 2: column octant 'NNE'"),
        ("azimuth_deg\n400\n", "from -360 to 360; an azimuth in gon"),
        ("azimuth_deg\n700\n", "from -360 to 360"),
        ("azimuth_deg\nnan\n", "from -360 to 360"),
        ("azimuth_deg\nnorth\n", "give a number"),
        ("azimuth_deg,octant\n10,N\n", "not both"),
        ("octant,fell\nN,no\n", "has no fall direction"),
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
def test_invalid_surveys_are_refused_with_the_reason(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(RecordError, match=message) as error:
        read_counted_stones(write_survey(tmp_path, text))
    assert "survey.csv" in str(error.value)


def test_survey_file_that_is_no_utf_8_text_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="UTF-8"):
        read_counted_stones(write_survey(tmp_path, "octant\n北\n", "shift_jis"))
    with pytest.raises(RecordError, match="cannot be read"):
        read_counted_stones(tmp_path)
    with pytest.raises(RecordError, match="cannot be read"):
        read_counted_stones(tmp_path / "nothing.csv")


def test_the_docs_name_every_survey_column() -> None:
    text = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")
    section = text.partition("## Surveys")[2].partition("\n## ")[0]
    assert [name for name in SURVEY_COLUMNS if f"| `{name}` |" not in section] == []


def test_error_about_a_huge_cell_names_its_line(tmp_path: Path) -> None:
    path = tmp_path / "stones.csv"
    path.write_text(f"octant\nN\n{'N' * 200_000}\n", encoding="utf-8")
    with pytest.raises(RecordError, match=r"stones\.csv line 3: field larger than field limit"):
        read_counted_stones(path)


def test_stones_that_all_stood_need_no_direction(tmp_path: Path) -> None:
    stones = read_counted_stones(write_survey(tmp_path, "fell,b_over_h,height_m,count\nno,0.3,0.6,4\nno,0.25,0.9,2\n"))
    assert [(stone.fell, stone.stone_count) for stone in stones] == [(False, 4), (False, 2)]


def test_a_stone_that_fell_in_an_unknown_direction_has_fallen(tmp_path: Path) -> None:
    stones = read_counted_stones(write_survey(tmp_path, "fell,octant,count\nyes,,3\nyes,N,1\nno,,2\n"))
    assert [(stone.fell, stone.fell_in_known_direction) for stone in stones] == [
        (True, False),
        (True, True),
        (False, False),
    ]


def test_columns_of_unused_data_are_skipped_with_a_note(tmp_path: Path) -> None:
    others = (
        "cemetery,stone,note,latitude,longitude,easting,northing,x,y,photo,date,remarks,material,id,county,ground,cell,"
    )
    cells = "Iwami,A7,leans,35.3,133.4,1,2,3,4,a.jpg,2016-04-16,-,granite,7,Tottori,sand,5,"
    stones, notes, doubts = read_fallen_and_standing_stones_notes_and_warnings(
        write_survey(tmp_path, f"{others},octant\n{cells},NE\n")
    )
    assert (stones[0].fall_azimuth_deg, stones[0].line_number, doubts) == (45, 2, [])
    assert notes == [
        "survey.csv: column 'cemetery' is read as site",
        "survey.csv: column 'latitude' is read as lat",
        "survey.csv: column 'longitude' is read as lon",
        "survey.csv: not used: columns easting, northing, date, remarks, material, id, county, ground, cell, "
        "without a name",
    ]


SIX_AZIMUTHS_DEG = (12.5, 63.0, 118.2, 187.0, 244.6, 301.0)


@pytest.mark.parametrize("column", ["azimuth_deg", "face_azimuth_deg"])
def test_azimuths_in_radians_or_gon_give_a_warning(tmp_path: Path, column: str) -> None:
    def warnings_about_azimuths(values: Iterable[float]) -> str:
        rows = "".join(f"yes,{value:.4f}\n" for value in values)
        return "".join(
            read_fallen_and_standing_stones_notes_and_warnings(write_survey(tmp_path, f"fell,{column}\n{rows}"))[2]
        )

    assert warnings_about_azimuths(SIX_AZIMUTHS_DEG) == ""
    assert warnings_about_azimuths((0, 45, 90, 135, 180, 225, 270, 315)) == "", "octants in degrees"
    assert warnings_about_azimuths((0, 90, 180, 270)) == ""
    assert warnings_about_azimuths((1, 2, 4)) == "", "whole degrees near north"
    assert f"column {column}: 6 values, none beyond 5.2534°: radians?" in warnings_about_azimuths(
        map(math.radians, SIX_AZIMUTHS_DEG)
    )
    assert "gon (400 to a turn)? Multiply by 0.9" in warnings_about_azimuths((50, 100, 150, 350))
