"""Tables as people keep them: encodings, separators, decimal commas, all faults at once, and what rows count as."""

import math
import re
from pathlib import Path

import pytest

from overturning.errors import RecordError
from overturning.surveys.counted_stones import read_counted_stones
from overturning.surveys.row import SurveyRow
from overturning.surveys.stones import SurveyTable, read_survey_table


def write_and_read_survey_table(
    folder: Path, text: str, encoding: str = "utf-8", declination_deg: float | None = None
) -> SurveyTable:
    """Write a survey table to a file and read it."""
    path = folder / "field.csv"
    path.write_bytes(text.encode(encoding))
    return read_survey_table(path, declination_deg)


COMMA_SEPARATED_TABLE = "azimuth_deg,height_m,note\n12.5,0.6,a\nSSE,0.8,\n"


@pytest.mark.parametrize(
    "text",
    [
        COMMA_SEPARATED_TABLE,
        COMMA_SEPARATED_TABLE.replace(",", ";").replace(".", ","),
        COMMA_SEPARATED_TABLE.replace(",", "\t").replace(".", ","),
        COMMA_SEPARATED_TABLE.replace("\n", "\r\n"),
        COMMA_SEPARATED_TABLE.replace("\n", "\r"),
        "sep=;\n" + COMMA_SEPARATED_TABLE.replace(",", ";"),
        COMMA_SEPARATED_TABLE.replace("12.5", '"12,5"'),
        COMMA_SEPARATED_TABLE + ",,\n,,\n",
        COMMA_SEPARATED_TABLE.replace("0.6,a", '0.6,"first line\nsecond, ""quoted"" line"'),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_separators_encodings_and_decimal_commas_give_the_same_stones(tmp_path: Path, text: str, encoding: str) -> None:
    stones = write_and_read_survey_table(tmp_path, text, encoding).fallen_and_standing_stones
    assert [
        (one.fall_azimuth_deg, one.height_m, one.has_16_point_direction, one.has_octant_direction) for one in stones
    ] == [
        (12.5, 0.6, False, False),
        (157.5, 0.8, True, False),
    ]


def test_line_numbers_count_quoted_line_breaks_and_comments(tmp_path: Path) -> None:
    text = '# a\nazimuth_deg,note\n10,"two\nlines"\n# b\n\n20,\n'
    assert [line for line, _ in write_and_read_survey_table(tmp_path, text).rows] == [3, 7]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("azimuth_deg,note\n10,a\n20,Müller\n".encode("latin-1"), "line 3: byte 0xFC is not UTF-8; .* CSV UTF-8"),
        ("octant\nN\n".encode("utf-16-le"), "zero bytes, as in UTF-16 without a byte order mark"),
        (b"\xff\xfeo\x00c", "damaged UTF-16"),
        (b"PK\x03\x04 and more", "a spreadsheet"),
        (b'octant,note\nN,"open\nS,\n', "line 2: unexpected end of data; close the quote"),
        (b"octant,note\nN,a,b,c\n", "4 cells, the header names 2 columns; .* decimal commas, .* by semicolons"),
        (b"outcome,azimuth_deg,height_m\nfell,120,5,\n", "4 cells, .* 3 columns; .* end no line with a comma"),
        (b"octant;note\nN\n", "1 cells, the header names 2 columns; separate cells by semicolons"),
    ],
)
def test_error_about_an_unreadable_table_states_cause_and_remedy(tmp_path: Path, content: bytes, message: str) -> None:
    (tmp_path / "field.csv").write_bytes(content)
    with pytest.raises(RecordError, match=message):
        read_survey_table(tmp_path / "field.csv")


def test_all_mistakes_in_a_table_are_reported_in_one_error(tmp_path: Path) -> None:
    text = (
        "stone,azimuth_deg,fell,heigth_m,lat,lon\n"
        "A1,400,yes,0.6,35,133\n"
        "A2,S95E,perhaps,60,35,\n"
        "A3,120,no,0.6,95,133\n"
        "A4,,,0.6,,\n"
        "A5,10,yes,0.6,35,133\n"
        "A6,400,yes,0.6,35,133\n"
        "A7,10,yes\n"
    )
    with pytest.raises(RecordError) as error:
        write_and_read_survey_table(tmp_path, text)
    path = tmp_path / "field.csv"
    forms = "a stone that stood has no fall direction; empty azimuth_deg and octant"
    assert str(error.value).split("\n") == [
        f"{path}: 10 faults, so no stone was read",
        "  line 1: column 'heigth_m' is not known; did you mean height_m? A column for something else needs a name "
        "that is less like it",
        "  lines 2, 7: column azimuth_deg '400': give degrees from -360 to 360; an azimuth in gon (400 to a turn) "
        "times 0.9",
        "  line 3: column fell 'perhaps': write yes or no",
        "  line 3: column azimuth_deg 'S95E': the angle of a quadrant bearing is 0 to 90 degrees, as in S40E",
        "  line 3: column height_m '60': height: 60 m; a stone is 0.01 to 50 m high; is that in centimetres or "
        "millimetres?",
        "  line 3: lat: without lon; give both coordinates or none",
        "  line 4: column lat '95': give a number from -90 to 90",
        f"  line 4: fell: {forms}",
        "  line 5: fell: empty, and no direction; write no for a stone that stood, yes for one that fell in an unknown "
        "direction",
        "  line 8: 3 cells, the header names 6 columns; separate cells by commas",
    ]


@pytest.mark.parametrize(
    ("header", "cells", "counted", "kinds"),
    [
        ("outcome", "fell SE", "fell", ("fell",)),
        ("outcome,azimuth_deg", "fell,140", "fell", ("fell",)),
        ("outcome,azimuth_deg", ",140", "fell", ("fell",)),
        ("outcome", '"fell, direction not known"', "fell", ("fell",)),
        ("outcome", '"fell, broken"', "fell", ("fell", "broken")),
        ("outcome", '"fell, repaired"', "fell", ("fell", "repaired")),
        ("outcome", '"fell, fixed"', "not counted", ("fell", "fixed")),
        ("outcome", "stands", "stands", ("stands",)),
        ("outcome", "shifted 2 cm", "stands", ("shifted",)),
        ("outcome,azimuth_deg", "shifted 2 cm,140", "stands", ("shifted",)),
        ("outcome", "twisted 5", "stands", ("twisted",)),
        ("outcome", "twisted 0", "stands", ("stands",)),
        ("outcome", '"shifted 0 cm, twisted 0"', "stands", ("stands",)),
        ("outcome", '"shifted 0 cm, twisted -3"', "stands", ("twisted",)),
        ("outcome", '"broken, shifted 0 mm"', "not counted", ("broken",)),
        ("outcome,twist_deg", "twisted,0", "stands", ("stands",)),
        ("outcome,shift_mm", "shifted,0", "stands", ("stands",)),
        ("fell,twist_deg", "no,-5", "stands", ("stands", "twisted")),
        ("fell,twist_deg", ",0", "stands", ("stands",)),
        ("fell,shift_mm", ",12", "stands", ("shifted",)),
        ("outcome", "broken", "not counted", ("broken",)),
        ("outcome", "repaired", "not counted", ("repaired",)),
        ("outcome", "fixed", "not counted", ("fixed",)),
        ("outcome", '"stands, fixed"', "not counted", ("stands", "fixed")),
        ("outcome", "unknown", "not counted", ("unknown",)),
    ],
)
def test_outcomes_count_as_fallen_standing_or_not_counted(
    tmp_path: Path, header: str, cells: str, counted: str, kinds: tuple[str, ...]
) -> None:
    table = write_and_read_survey_table(tmp_path, f"{header}\n{cells}\n")
    row = table.rows[0][1]
    assert (row.counted_as, row.stated_outcomes) == (counted, kinds)
    assert [stone.fell for stone in table.fallen_and_standing_stones] == (
        [] if counted == "not counted" else [counted == "fell"]
    )
    assert all(math.isnan(stone.fall_azimuth_deg) for stone in table.fallen_and_standing_stones if not stone.fell)


@pytest.mark.parametrize(
    "text",
    [
        "# stone, outcome\n# measured in 2016\nstone,outcome,inscription\nA,fell,X\n",
        "# stone, kind\nstone,outcome\nA,fell\n",
        "# x, y\nstone,outcome,x,y,weather\nA,fell,1,2,dry\n",
        "stone,outcome,2016\nA,fell N,3\n",
        "stone,outcome,azimuth (º)\nA,fell,120º\n",
    ],
)
def test_comments_and_columns_resembling_mistakes_are_accepted(tmp_path: Path, text: str) -> None:
    (stone,) = write_and_read_survey_table(tmp_path, text).fallen_and_standing_stones
    assert stone.fell


def test_error_about_a_title_line_above_the_header_states_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match=r"line 1: no column azimuth_deg .*above the names .* begin with #"):
        write_and_read_survey_table(tmp_path, "Survey of Hill cemetery\nstone,outcome\nA,fell\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Survey of 2020,,\nstone,azimuth,note\nA,120,x\n", r"above the names .* must begin with #: 'Survey of 2020'"),
        ("墓石,方位\nA,120\n", r"line 1: no column azimuth_deg .*; it has 墓石, 方位$"),
        (
            "site,fell,total\nA,1,10\nB,0,10\n",
            r"line 1: column 'total' next to fell: .* numbers of stones, write .* count",
        ),
        ("site,fell,not fell\nA,1,9\nB,0,10\n", r"column 'not fell' next to fell"),
        ("site,fell,stones\nA,1,10\nB,0,10\n", r"column 'stones' next to fell"),
        ("stone,fell,count\nA,yes,1\nB,no,3\nTotal,yes,4\n", r"line 4: 'Total' names a line of totals"),
        ("site,stone,fell\nA,1,yes\n合計,,yes\n", r"line 3: '合計' names a line of totals"),
        ("stone,azimuth,height_m\n,deg,m\nA,120,0.5\n", r"line 2: a line of units; begin it with #"),
        ("stone,azimuth,height_cm\nA,120,45\n", r"did you mean height_m\? Divide the heights by 100"),
        ("stone,azimuth (gon)\nA,120\n", r"did you mean azimuth_deg\? Multiply the azimuths in gon by 0.9"),
        ("stone,azimuth (rad)\nA,1.2\n", r"did you mean azimuth_deg\? Multiply the azimuths in radians by 57"),
        ("azimuth,h_over_b\n120,3.3\n", r"did you mean b_over_h\? Give B/H, the reciprocal"),
        ("azimuth,height_m\n120,1_2\n", r"height_m '1_2': write a number without underscores"),
        ("azimuth\n1_20\n", r"azimuth_deg '1_20': give a number of degrees"),
        ('outcome\n"shifted 1,000 mm"\n', r"may be a thousand or have three decimals; write 1000"),
        ("fell,shift_cm\nno,1.000\n", r"shift_cm '1\.000': may be a thousand"),
    ],
)
def test_tables_of_totals_units_or_other_layouts_are_refused_with_a_remedy(
    tmp_path: Path, text: str, message: str
) -> None:
    with pytest.raises(RecordError, match=message):
        write_and_read_survey_table(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "warning"),
    [
        ("azimuth,height_m\n120,45\n20,0.5\n", "field.csv: line 2: a height up to 45 m: in centimetres?"),
        ("azimuth,b_over_h\n120,0.3\n20,3.3\n", "field.csv: line 3: b_over_h above 2, .*: height over width?"),
        ("site,fell,total\nA,1,1\nB,0,1\n", None),
        ("stone,true azimuth,declination\nA,120,\nB,130,0\n", None),
    ],
)
def test_stone_sizes_apparently_in_cm_or_as_h_over_b_are_read_with_a_warning(
    tmp_path: Path, text: str, warning: str | None
) -> None:
    found = write_and_read_survey_table(tmp_path, text).warnings
    assert len(found) == (warning is not None)
    assert all(re.match(str(warning), one) for one in found)


def test_azimuths_that_are_read_are_below_360_degrees(tmp_path: Path) -> None:
    assert [
        stone.fall_azimuth_deg
        for stone in write_and_read_survey_table(tmp_path, "azimuth\n-1e-20\n360\n-5\n").fallen_and_standing_stones
    ] == [
        0.0,
        0.0,
        355.0,
    ]


def test_a_note_counts_the_stones_counted_neither_as_fallen_nor_standing(tmp_path: Path) -> None:
    table = write_and_read_survey_table(tmp_path, 'outcome,count\nfixed,3\n"broken, repaired",2\nunknown,1\nfell E,4\n')
    assert table.notes == (
        "field.csv: not counted as fallen or standing: 6 (outcomes: 3 fixed, 2 repaired, 1 unknown)",
    )
    assert [(stone.fell, stone.stone_count) for stone in table.fallen_and_standing_stones] == [(True, 4)]


@pytest.mark.parametrize(
    ("header", "cells", "message"),
    [
        ("outcome,fell", "stands,yes", "fell: yes, but outcome stands"),
        ("outcome,azimuth_deg", "stands,10", "has no fall direction"),
        ("outcome,azimuth_deg", "fell direction unknown,10", "direction is not known, but azimuth_deg or octant gives"),
        ("outcome,octant", "fell SE,N", "outcome: names a direction, and so does azimuth_deg"),
        ("outcome,twist_deg", "twisted 5,6", "twist_deg: outcome gives the twist as well"),
        ("outcome,shift_cm", "shifted 5 cm,6", "shift: given more than once"),
        ("outcome,shift_cm,shift_mm", "shifted,6,60", "shift: given more than once"),
        ("fell,x", "yes,6", "x: without y"),
        ("fell,stood", "1,0", "column 'stood' beside fell: fell is yes or no"),
        ("outcome,fell from", "fell,10", "did you mean azimuth_deg"),
        ("1;fell;120", "2;fell;130", "line 1: column '120' is a number; the first line without # names the columns"),
        ("1,fell,N", "2,stood,", "line 1: column '1' is a number"),
        ("#stone,outcome,azimuth_deg\nA,fell,N", "B,fell,E", "line 2: the line above it names the columns, but is a "),
        ("outcome,twist_deg", "twisted cw,-3", "twist_deg: has a sign, and outcome states clockwise"),
        ("fell,twist_deg", "no,200", "twist_deg '200': give a number from -180 to 180"),
        ("fell,shift_cm", "no,-1", "shift_cm '-1': give a number from 0 to 1000"),
        ("outcme", "fell", "did you mean outcome"),
        ("fell,azimuth,fall_direction", "yes,1,", "azimuth_deg is named twice"),
        ("fell,Azimuth (rad)", "yes,1", "did you mean azimuth_deg"),
    ],
)
def test_contradictory_or_invalid_rows_and_headers_are_refused(
    tmp_path: Path, header: str, cells: str, message: str
) -> None:
    with pytest.raises(RecordError, match=message):
        write_and_read_survey_table(tmp_path, f"{header}\n{cells}\n")


def test_an_unused_column_gives_a_note_with_a_similar_known_name(tmp_path: Path) -> None:
    table = write_and_read_survey_table(tmp_path, "fell,sites,photographer,mood\nyes,a,Ito,calm\n")
    assert table.notes == (
        "field.csv: not used: columns sites (did you mean site?), photographer (did you mean photo?), mood",
    )


def test_table_cells_that_state_an_unknown_value_are_read_as_empty(tmp_path: Path) -> None:
    text = "fell,azimuth_deg,Height (m),note\nyes,?,n/a,?\nyes,SE,-,-\nyes,unknown,0.6,\n"
    table = write_and_read_survey_table(tmp_path, text)
    assert [stone.fell_in_known_direction for stone in table.fallen_and_standing_stones] == [False, True, False]
    assert [math.isnan(stone.height_m) for stone in table.fallen_and_standing_stones] == [True, True, False]
    assert [row.note for _, row in table.rows] == ["?", "-", ""]
    with pytest.raises(RecordError, match=r"write yes or no; an unknown outcome belongs in the column outcome"):
        write_and_read_survey_table(tmp_path, "fell\n?\n")


def test_a_survey_without_countable_stones_is_refused_but_read_as_a_table(tmp_path: Path) -> None:
    assert write_and_read_survey_table(tmp_path, "outcome\nfixed\nbroken\n").fallen_and_standing_stones == []
    with pytest.raises(RecordError, match="no stone counts as fallen or standing"):
        read_counted_stones(tmp_path / "field.csv")


def test_compass_points_are_octants_if_all_are_among_the_main_eight(tmp_path: Path) -> None:
    eight = write_and_read_survey_table(tmp_path, "azimuth_deg\nN\nse\n130\n").fallen_and_standing_stones
    assert [(one.has_octant_direction, one.has_16_point_direction,
    one.direction_uncertainty_half_width_deg) for one in eight] == [
        (True, False, 22.5), (True, False, 22.5), (False, False, 0.0),
    ]  # fmt: skip
    sixteen = write_and_read_survey_table(tmp_path, "azimuth_deg\nN\nsse\n").fallen_and_standing_stones
    assert [(one.has_octant_direction, one.direction_uncertainty_half_width_deg) for one in sixteen] == [
        (False, 11.25),
        (False, 11.25),
    ]


def test_declination_is_added_from_column_or_option(tmp_path: Path) -> None:
    by_column = write_and_read_survey_table(
        tmp_path, "azimuth_deg;declination\nS40E;-7,5\nNNE;\n"
    ).fallen_and_standing_stones
    assert [stone.fall_azimuth_deg for stone in by_column] == [132.5, 22.5]
    by_option = write_and_read_survey_table(
        tmp_path, "azimuth_deg\nS40E\nNNE\n", declination_deg=-7.5
    ).fallen_and_standing_stones
    assert [stone.fall_azimuth_deg for stone in by_option] == [132.5, 15.0]
    with pytest.raises(RecordError, match="a column gives the declination; leave out the option"):
        write_and_read_survey_table(tmp_path, "azimuth_deg,declination\n10,5\n", declination_deg=-7.5)
    with pytest.raises(RecordError, match="from -180 to 180, east positive"):
        write_and_read_survey_table(tmp_path, "azimuth_deg\n10\n", declination_deg=200)
    with pytest.raises(
        RecordError, match="lines 2, 3: one of 8 compass points from magnetic north, 20° from true north"
    ):
        write_and_read_survey_table(tmp_path, "azimuth_deg\nN\nSE\n", declination_deg=20)


def test_a_magnetic_column_without_declination_gives_a_warning(tmp_path: Path) -> None:
    assert (
        "names magnetic north, but no declination"
        in write_and_read_survey_table(tmp_path, "Azimuth (mag)\n10\n").warnings[0]
    )
    assert write_and_read_survey_table(tmp_path, "Azimuth (mag)\n10\n", declination_deg=5).warnings == ()


@pytest.mark.parametrize(
    ("header", "cells", "lines"),
    [
        (
            "outcome;azimuth (mag);declination",
            ("fell;10;", "fell;20;15", "fell;;"),
            "no declination is given in line 2;",
        ),
        ("outcome;azimuth (mag);declination", ("fell;10;15", "stands;;"), ""),
        ("outcome;Face azimuth (magnetic)", ("fell;10", "fell;20"), "no declination is given;"),
        ("outcome;azimuth_magnetic", ("fell;10", "fell;20"), "no declination is given;"),
        ("outcome;magnetic azimuth;declination", ("fell;10;7", "fell;20;7"), ""),
    ],
)
def test_warning_names_lines_of_magnetic_azimuths_without_declination(
    tmp_path: Path, header: str, cells: tuple[str, ...], lines: str
) -> None:
    assert lines in "".join(write_and_read_survey_table(tmp_path, "\n".join((header, *cells))).warnings)
    assert bool(lines) == bool(write_and_read_survey_table(tmp_path, "\n".join((header, *cells))).warnings)


def test_a_declination_for_azimuths_from_true_north_is_refused(tmp_path: Path) -> None:
    for text, declination in (
        ("outcome;Azimuth (true);declination\nfell;10;15\n", None),
        ("outcome;Azimuth (true)\nfell;10\n", 15.0),
    ):
        with pytest.raises(RecordError, match=r"line 1: column 'Azimuth \(true\)' names true north, but a declination"):
            write_and_read_survey_table(tmp_path, text, declination_deg=declination)
    assert (
        write_and_read_survey_table(tmp_path, "outcome;Azimuth (true)\nfell;10\n")
        .fallen_and_standing_stones[0]
        .fall_azimuth_deg
        == 10.0
    )


def test_rows_that_are_read_as_comments_give_a_warning(tmp_path: Path) -> None:
    """A stone name such as #12 turns its row into a comment.

    A comment with fewer cells, or above the header, is taken as intended.
    """
    text = '# a;b;c\nstone;outcome;azimuth_deg\n#1;fell;120\n3;fell;90\n"#4";fell;10\n# moved in 1990\n# padded;;\n'
    table = write_and_read_survey_table(tmp_path, text)
    assert len(table.rows) == 1
    (doubt,) = table.warnings
    assert "lines 3, 5: not used, because # marks a comment" in doubt


def test_an_unclosed_quotation_mark_that_swallows_whole_rows_gives_a_warning(tmp_path: Path) -> None:
    text = 'stone;outcome;note\nA;fell;\nB;stands;"open\nC;fell;x\nD;fell;"\nE;stands;"two\nlines; and more"\n'
    (doubt,) = write_and_read_survey_table(tmp_path, text).warnings
    assert "line 3: a cell in quotation marks contains whole rows" in doubt


def test_only_line_feeds_and_carriage_returns_end_a_line(tmp_path: Path) -> None:
    table = write_and_read_survey_table(tmp_path, "outcome;note\nfell;a\u2028b\x0bc\x85d\nstands;\n")
    assert [line for line, _ in table.rows] == [2, 3]


@pytest.mark.parametrize("count", ["1,000", "1.000", "2,0", "1.5", "12,", "-3.0"])
def test_a_count_with_a_point_or_comma_is_refused(tmp_path: Path, count: str) -> None:
    with pytest.raises(RecordError, match=r"column count .* write a whole number without point or comma"):
        write_and_read_survey_table(tmp_path, f"outcome;count\nfell;{count}\n")


@pytest.mark.parametrize(
    ("outcome", "column", "twist"),
    [
        ("twisted anticlockwise", "10", -10.0),
        ("rotated ccw", "8,5", -8.5),
        ("twisted clockwise", "10", 10.0),
        ("twisted", "-10", -10.0),
        ("twisted 10 anticlockwise", "", -10.0),
    ],
)
def test_sense_of_a_twist_is_read_from_outcome_or_twist_column(
    tmp_path: Path, outcome: str, column: str, twist: float
) -> None:
    ((_, row),) = write_and_read_survey_table(tmp_path, f"outcome;twist_deg\n{outcome};{column}\n").rows
    assert row.clockwise_twist_deg == twist


def test_a_stone_that_is_listed_twice_gives_a_warning(tmp_path: Path) -> None:
    table = write_and_read_survey_table(tmp_path, "site,stone,fell\nA,1,yes\nB,1,no\nA,1,yes\n")
    assert table.warnings == ("field.csv: stone '1' is listed 2 times, and counts each time: lines 2, 4",)
    assert table.site_names == ["A", "B"]
    assert [stone.line_number for stone in table.select_site("B").fallen_and_standing_stones] == [3]


def test_docs_repeat_the_description_of_each_survey_column() -> None:
    text = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")
    rows = [f"| `{name}` | {one.description} |" for name, one in SurveyRow.model_fields.items()]
    assert "\n".join(rows) in text
