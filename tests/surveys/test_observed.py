"""Summary of a survey by itself: numbers and shares by hand and with scipy, sectors, and three field tables."""

import math
from pathlib import Path

import numpy as np
import pytest
import scipy

from overturning.cli import main
from overturning.findings.observed import ObservedFallsFinding, ObservedSurveyFindings, observed_survey_findings
from overturning.surveys.observed import fall_counts_by_rose_sector, rose_sector_count, summarise_survey
from overturning.surveys.stones import Stone, read_survey_table


def observed_findings_of_table(folder: Path, text: str, declination_deg: float | None = None) -> ObservedSurveyFindings:
    """Write a survey table and return the findings of the survey by itself."""
    path = folder / "stones.csv"
    path.write_text(text, encoding="utf-8")
    return observed_survey_findings(summarise_survey(read_survey_table(path, declination_deg)))


TABLE_OF_TWO_SITES = (
    "site,outcome,azimuth_deg,count\n"
    "A,fell,10,4\nA,fell,30,4\nA,fell,,1\nA,stands,,3\nA,twisted 5,,2\nA,fixed,,2\n"
    "B,fell,200,3\nB,broken,,1\nB,unknown,,1\n"
)


def test_counts_and_shares_of_each_site_match_hand_counts_and_scipy(tmp_path: Path) -> None:
    found = observed_findings_of_table(tmp_path, TABLE_OF_TWO_SITES)
    first, second = found.sites

    def stone_counts(one: ObservedFallsFinding) -> tuple[int, ...]:
        unknown = one.fell_in_unknown_direction
        return one.stones, one.fell, unknown, one.stands, one.standing_shifted_or_twisted, one.not_counted

    assert (first.site, stone_counts(first)) == ("A", (16, 9, 1, 5, 2, 2))
    assert (second.site, stone_counts(second)) == ("B", (5, 3, 0, 0, 0, 2))
    assert stone_counts(found.all_sites) == (21, 12, 1, 5, 2, 4)
    assert found.all_sites.not_counted_by_reason == {"fixed": 2, "broken": 1, "unknown": 1}
    assert second.fell_share_of_counted is None, "only fallen stones are listed"
    assert found.sites_with_fallen_stones_only == ["B"], "its fallen stones would raise the share of all sites together"
    for share, k, n in (
        (first.fell_share_of_counted, 9, 14),
        (first.stands_share_of_counted, 5, 14),
        (found.all_sites.fell_share_of_counted, 9, 14),
        (found.all_sites.not_counted_share, 4, 21),
    ):
        exact = scipy.stats.binomtest(k, n).proportion_ci(method="exact")
        assert share is not None
        assert (share.value, share.low, share.high) == pytest.approx((k / n, exact.low, exact.high))


def test_mean_directions_of_sites_match_hand_computation(tmp_path: Path) -> None:
    found = observed_findings_of_table(tmp_path, TABLE_OF_TWO_SITES)
    first = found.sites[0]
    assert first.direction.mean_deg == pytest.approx(20)
    assert first.direction.mean_resultant_length == pytest.approx(math.cos(math.radians(10)))
    # Three falls to 200° are on the axis of the eight to 20°.
    assert found.all_sites.axis.mean_deg == pytest.approx(20)
    assert found.all_sites.axis.sample_size == 11
    north, east = 8 * math.cos(math.radians(10)) - 3, 0.0
    assert found.all_sites.direction.mean_resultant_length == pytest.approx(math.hypot(north, east) / 11)
    assert (found.smallest_magnetic_declination_deg, found.largest_magnetic_declination_deg) == (0, 0)


@pytest.mark.parametrize(
    ("text", "direction_p", "axis_p"),
    [
        ("octant\nN\nN\n", 1 / 8, 1 / 4),
        ("octant\nN\nS\n", 1, 1 / 4),
        ("azimuth\nSSE\nSSE\n", 1 / 16, 1 / 8),
        ("azimuth,declination\nSSE,-7.5\nSSE,-7.5\n", 1 / 16, 1 / 8),
        ("azimuth,count\n30,2\n", 1 / 12, 1 / 6),
        ("azimuth\n50\n50\n", 1 / 36, 1 / 18),
        ("azimuth\n50.5\n50.5\n", 0, 0),
    ],
)
def test_p_value_of_two_equal_directions_allows_for_the_azimuth_recording_step(
    tmp_path: Path, text: str, direction_p: float, axis_p: float
) -> None:
    """By chance two stones have the same recorded step with probability step/360°, or step/180° for axes."""
    found = observed_findings_of_table(tmp_path, text).all_sites
    assert found.direction.uniformity_p_value == pytest.approx(direction_p, abs=0.02)
    assert found.axis.uniformity_p_value == pytest.approx(axis_p, abs=0.02)


def test_a_single_site_is_not_listed_and_only_used_declinations_count(tmp_path: Path) -> None:
    text = "site,fell,azimuth_deg,declination\nA,yes,10,-7.5\nA,yes,20,-7\nA,no,,3\n"
    found = observed_findings_of_table(tmp_path, text)
    assert found.sites == []
    assert (found.smallest_magnetic_declination_deg, found.largest_magnetic_declination_deg) == (-7.5, -7)
    assert observed_findings_of_table(tmp_path, "fell\nno\n").smallest_magnetic_declination_deg is None


def test_falls_noted_as_compass_points_are_shared_among_rose_sectors() -> None:
    octant, wind = (
        Stone(True, 45.0, has_octant_direction=True, stone_count=3),
        Stone(True, 22.5, has_octant_direction=False, has_16_point_direction=True),
    )
    exact = Stone(True, 355.0, has_octant_direction=False)
    assert rose_sector_count([octant, exact]) == 8
    assert rose_sector_count([wind, exact, Stone(False, math.nan, has_octant_direction=False)]) == 16
    np.testing.assert_allclose(fall_counts_by_rose_sector([octant, wind, exact], 8), [1.5, 3.5, 0, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(fall_counts_by_rose_sector([wind, exact], 16), [1, 1, *[0] * 14])


FIELD_TABLES = {
    "winds, commas, unknown directions": (
        "Cemetery,No.,Stone name,Outcome,Fall direction,Photographer\n"
        + "".join(
            f"Hill,{i},S{i},Fell,{wind},Ito\n"
            for i, wind in enumerate(["SE", "sse", "SE", "ese", "SE", "s", "E", "nw"])
        )
        + "Hill,9,S9,fell direction unknown,,Ito\nHill,10,S10,stands,,Ito\nValley,11,S11,shifted 4 cm,,Ito\n"
        + "Valley,12,S12,fell,SE,Ito\n",
        "utf-8",
        (),
        (10, 1, 2),
    ),
    "decimal commas, semicolons, BOM, CRLF": (
        "site;stone;fell;azimuth_deg;declination;height_m;weather\r\n"
        + "".join(f"A;{i};yes;{130 + i},5;-7,5;0,{60 + i};dry\r\n" for i in range(9))
        + "B;1;no;;;0,8;dry\r\nB;2;yes;;;0,8;dry\r\n;;;;;;\r\n",
        "utf-8-sig",
        (),
        (10, 1, 1),
    ),
    "quadrant bearings, tabs, UTF-16, magnetic": (
        "# Survey of the parish\nsite\tstone\toutcome\tAzimuth (mag)\tlat\tlon\tremarks\n"
        + "".join(f"A\t{i}\tfell\tS {35 + i}° E\t35,3{i}\t133,4\t\n" for i in range(8))
        + "A\t9\ttwisted -12\t\t\t\tclockwise from below\nA\t10\tfixed\n",
        "utf-16",
        ("--declination", "-7.5"),
        (8, 0, 1),
    ),
}


@pytest.mark.parametrize("name", FIELD_TABLES)
def test_field_tables_in_three_layouts_are_summarised_and_drawn(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text, encoding, options, (fell, unknown, stand) = FIELD_TABLES[name]
    path, figure, rose = (tmp_path / file for file in ("stones.csv", "roses.svg", "rose.png"))
    path.write_bytes(text.encode(encoding))
    with pytest.raises(SystemExit) as stop:
        main(["survey", str(path), "--figure", str(figure), "--rose", str(rose), *options])
    printed = capsys.readouterr()
    assert not stop.value.code, printed.err
    assert f"{fell} stones fell and {stand} stand" in printed.out
    table = read_survey_table(path, -7.5 if options else None)
    assert (
        sum(stone.fell and not stone.fell_in_known_direction for stone in table.fallen_and_standing_stones) == unknown
    )
    found = observed_survey_findings(summarise_survey(table)).all_sites
    assert found.direction.mean_deg is not None
    assert 110 < found.direction.mean_deg < 150
    assert figure.read_text(encoding="utf-8").startswith("<?xml")
    assert rose.read_bytes().startswith(b"\x89PNG")


def test_survey_command_prints_the_summary_in_sentences(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "stones.csv").write_text(TABLE_OF_TWO_SITES, encoding="utf-8")
    with pytest.raises(SystemExit):
        main(["survey", str(tmp_path / "stones.csv")])
    lines = capsys.readouterr().out.replace("\u00a0", " ").split("\n")
    assert lines[:7] == [
        "stones.csv: not counted as fallen or standing: 4 (outcomes: 2 fixed, 1 broken, 1 unknown)",
        "12 stones fell and 5 stand (2 of them shifted or twisted); 4 do not count. Share that fell: 64 % (35 to 87), "
        "without B, where no standing stone is listed. "
        "The falls have a common axis: 20° ± 6° (p < 0.001, the probability that falls in random directions are "
        "aligned at least as closely). They show no mean "
        "direction (p = 0.12).",
        "",
        "  site      fell  direction unknown  stand  moved  not counted  share that fell",
        "  A            9                  1      5      2            2  64 % (35 to 87)",
        "  B            3                  0      0      0            2                –",
        "  together    12                  1      5      2            4  64 % (35 to 87)",
    ]
    assert lines[-2].endswith("No magnetic declination is given, so the directions are taken as from true north.")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--record", "one"), "--record: only with --cube"),
        (("--output", "a.json"), "--output: only with --cube"),
        (("--rose", "a.bmp"), "--rose"),
        (("--declination", "200"), "give degrees from -180 to 180, east positive"),
    ],
)
def test_survey_command_refuses_invalid_options_and_options_that_need_a_cube(
    arguments: tuple[str, str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "stones.csv").write_text(TABLE_OF_TWO_SITES, encoding="utf-8")
    with pytest.raises(SystemExit) as stop:
        main(["survey", str(tmp_path / "stones.csv"), *arguments])
    assert stop.value.code == 1
    assert message in capsys.readouterr().err


def test_template_command_prints_the_survey_template(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["survey", "template"])
    assert not stop.value.code
    assert capsys.readouterr().out.splitlines()[-1].startswith("site,stone,kind,outcome,azimuth_deg")
