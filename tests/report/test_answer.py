"""The answer in words, from summaries whose meaning is known, and how numbers are written."""

import math
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.stats import bootstrap, norm, t

from overturning.model.planes import Planes
from overturning.report.blocks import table
from overturning.report.sections.alignment import alignment_sentences, axes_sentence, axes_shown
from overturning.report.sections.answer import ANSWERS, beside_the_normal, primary_sentence
from overturning.report.sections.causes import doubling_sentence
from overturning.report.sections.contrast import contrast_told
from overturning.report.sections.space import follow_sentences
from overturning.report.text import counted, degrees, estimate, interval, number, percent, share
from overturning.report.words import WORDS
from overturning.statistics.alignment_by_rule import RuleAlignment
from overturning.statistics.bootstrap import Mean
from overturning.statistics.earthquakes import AxisSummary, ReferenceAlignment
from overturning.statistics.elements import Contrast
from overturning.statistics.falls import BLOCK_RULES
from overturning.statistics.logistic import LogisticFit
from overturning.study.evaluation import Primary
from overturning.study.schema import Study
from tests.report.reading import numbers

NAN = math.nan


def summary(axis: float, half_width: float, low: float, high: float, n: int = 5, closer: int = 4) -> AxisSummary:
    return AxisSummary(n + 1, Mean(n, (low + high) / 2, low, high), axis, half_width, n, closer, largest=0.9)


NORMAL, EITHER = summary(-7.4, 12.0, 0.3, 0.8), summary(20.0, 60.0, -0.2, 0.6, n=3, closer=1)
NOTHING = summary(NAN, NAN, NAN, NAN, n=0)


def results(difference: Mean | None = None, /, **groups: AxisSummary) -> Any:
    """Groups of records: `pulse` and `control`, or `all` of them."""
    names = {"pulse": "with a velocity pulse", "control": "without (control)", "all": "all records"}
    axes = {names[key]: one for key, one in groups.items()}
    # Under one rule each group has its alignment, under the other 0.02 with an interval that takes in 0.
    by_rule = {
        name: [
            RuleAlignment(rule, one.alignment.n, mean, one.largest)
            for rule, mean in zip(BLOCK_RULES, (one.alignment, Mean(one.alignment.n, 0.02, -0.1, 0.1)), strict=False)
        ]
        for name, one in axes.items()
    }
    return SimpleNamespace(
        axis_summaries=axes, alignment_difference=difference, words=WORDS[Planes], alignment_by_rule=by_rule
    )


def two(low: float, high: float, n: int = 3) -> Any:
    return results(Mean(n, 0.35, low, high), pulse=NORMAL, control=EITHER)


def test_an_alignment_that_no_earthquake_has_is_not_drawn() -> None:
    made = results(all=NOTHING)
    made.figures = Path("figures")
    assert axes_shown(made) is None, "it was a plot without a point"
    made.axis_summaries |= {"with a velocity pulse": NORMAL}
    assert axes_shown(made) is not None


def test_the_verdict_is_that_of_the_primary_statistic() -> None:
    (first, rules), rest = alignment_sentences(results(all=NORMAL), primary=True), axes_sentence(results(all=NORMAL))
    assert numbers(first) == ["1", "−1", "0.55", "0.90", "95", "0.30", "0.80", "5", "6"]
    assert numbers(rules) == ["0.02", "0.55", "0", "1", "2"], "its range over the rules, and under how many it is shown"
    assert "closer to the fault normal" in first
    assert numbers(rest) == ["7", "12", "4", "5"]
    (first, _, second), rest = alignment_sentences(two(-0.1, 0.7), primary=True), axes_sentence(two(-0.1, 0.7))
    assert first.startswith("Primary")
    assert "closer to the fault normal" in first
    assert "without" not in first
    assert second.startswith("Secondary")
    assert numbers(second) == ["0.20", "0.90", "95", "−0.20", "0.60", "3", "4", "0.35", "−0.10", "0.70"]
    assert "no difference" in second
    assert numbers(rest) == ["7", "12", "20", "60", "4", "5", "1", "3"]
    second = alignment_sentences(two(0.1, 0.7), primary=True)[2]
    assert ": a difference" in second
    assert "between the two" not in alignment_sentences(two(NAN, NAN, 1), primary=True)[2]
    assert "no earthquake" in alignment_sentences(results(pulse=NOTHING, control=NORMAL), primary=True)[0]
    across = results(all=summary(80.0, 5.0, -0.9, -0.5))
    assert "closer to the fault than" in alignment_sentences(across, primary=True)[0]
    # If another statistic is primary, the alignment gives no verdict.
    (other,) = alignment_sentences(across, primary=False)
    assert other.startswith("Secondary")
    assert "closer" not in other


def shares(primary: Primary, own: list[float], variant: list[float], vertical: list[int] | None = None) -> str:
    """The sentence of a study whose stones fall in so many of twenty planes under each record, some with `vertical`."""

    def cube(values: list[float]) -> xr.Dataset:
        falls = np.arange(20) < 20 * np.array(values)[:, None]
        events = ("record", [str(number) for number in range(len(values))])
        applied = ("record", vertical or [1] * len(values))
        return xr.Dataset(
            {"overturned": (("record", "azimuth"), falls.astype(float))}, {"event": events, "vertical": applied}
        )

    cubes = {"nominal": cube(own), "other": cube(variant)}
    rates = {
        name: xr.Dataset(
            {"fall_rate": (("record", "amplitude"), np.array([values, values]).T)}, {"amplitude": [1.0, 2]}
        )
        for name, values in (("nominal", own), ("other", variant))
    }
    study = Study.model_validate(
        {
            "name": "shares",
            "records": {"use": ["one"]},
            "population": {},
            "primary": primary.model_dump(),
            "variants": {"other": {"vertical": False}},
        }
    )
    made = SimpleNamespace(study=study, cube=cubes["nominal"], cubes=cubes, populations=rates, of_known="")
    made.events, made.reference_cube = made.cube["event"].to_numpy(), cubes.__getitem__
    return primary_sentence(made)  # type: ignore[arg-type]


@pytest.mark.parametrize("statistic", ["share", "fall_rate"])
def test_a_share_is_compared_with_that_of_a_variant_earthquake_by_earthquake(statistic: Any) -> None:
    own, variant = [0.9, 0.5, 0.6, 0.3, 0.8, 0.4, 0.7, 0.2], [0.8, 0.45, 0.5, 0.1, 0.8, 0.3, 0.6, 0.1]
    found = numbers(shares(Primary(statistic=statistic, against="other"), own, variant))
    apart = np.subtract(own, variant)
    level = 1 - 2 * norm.cdf(-np.sqrt(8 / 7) * t.ppf(0.975, 7))  # expanded percentile (Hesterberg 2015)
    scipys = bootstrap(
        (apart,), np.mean, method="percentile", confidence_level=level, n_resamples=20_000, rng=1
    ).confidence_interval
    assert float(found[0]) == pytest.approx(100 * apart.mean(), abs=0.05)
    assert [float(one) for one in found[2:4]] == pytest.approx([100 * end for end in scipys], abs=0.4)
    assert found[4] == "8"
    assert "more fall with vertical motion" in shares(Primary(statistic=statistic, against="other"), own, variant)
    assert "fewer fall with vertical motion" in shares(Primary(statistic=statistic, against="other"), variant, own)
    assert "no difference" in shares(Primary(statistic=statistic, against="other"), own, own[::-1])
    alone = shares(Primary(statistic=statistic), own[:1], variant[:1])
    assert numbers(alone) == ["90.0", "1"]
    assert "90.0\u00a0%" in alone
    less = shares(Primary(statistic=statistic, against="other"), own[:1], variant[:1])
    assert "with vertical motion, less that without vertical motion" in less
    assert "is 10.0\u00a0percentage points (1 earthquake" in less
    wide = [0.95, 0.5, 0.1, 0.9, 0.2, 0.3, 0.7, 0.4]
    assert all("." not in one for one in numbers(shares(Primary(statistic=statistic), wide, variant)))
    assert "too few" in alone


def test_vertical_question_uses_records_with_vertical_motion() -> None:
    """The others, the same with and without, made a difference of ten points one of five, with as many earthquakes."""
    own, primary = [0.9, 0.5, 0.6, 0.3], Primary(statistic="share", against="other")
    said = shares(primary, own, [0.8, 0.4, 0.6, 0.3], vertical=[1, 1, 0, 0])
    assert "a mean over earthquakes of the 2 records with vertical motion, is 10.0" in said
    assert "2 earthquakes, too few" in said
    assert "with vertical motion, is" not in shares(primary, own, own)
    assert "None of these records has vertical motion" in shares(primary, own, own, vertical=[0] * 4)


def test_planes_near_fault_normal_and_fault_are_separated() -> None:
    """The normal is 60°: 30, 60, 90 and their opposites lie nearer to it than 45°, of which four of six fall."""
    azimuth = np.arange(0, 360, 30)
    falls = [float(one in (30, 60, 210, 240, 330)) for one in azimuth]
    cube = xr.Dataset(
        {"overturned": (("record", "azimuth"), [falls])}, {"azimuth": azimuth, "fault_normal": ("record", [60.0])}
    )
    (said,) = beside_the_normal(cube)
    assert numbers(said) == ["67", "45", "17"]
    assert "not in the direction of the normal only" in said
    (there_only,) = beside_the_normal(cube.where(cube["azimuth"] != 330, 0.0).assign_coords(cube.coords))
    assert "only" not in there_only
    unknown = cube.assign_coords(fault_normal=("record", [NAN]))
    assert beside_the_normal(unknown) == ()
    assert beside_the_normal(xr.concat([cube, unknown], "record")) == (said,)


@pytest.mark.parametrize(
    ("fallen", "planes", "start"),
    [
        (NAN, 36, "No outcome was found"),
        (0.0, 36, "No block overturned"),
        (0.5, 1, "50\u00a0% of the cases overturn; with a single plane"),
        (1.0, 36, "Every block overturned in every plane"),
        (0.5, 36, "Primary statistic"),
    ],
)
def test_edges(fallen: float, planes: int, start: str) -> None:
    edge = {
        "share_overturned": fallen,
        "has_single_axis": planes == 1,
        "fault_normal_known": True,
        "every_case_overturns": fallen == 1,
    }
    own = vars(results(all=NORMAL)) | {
        "study": SimpleNamespace(primary=Primary()),
        "record_names": (),
        "figures": Path(),
    }

    def said(of_known: str = "") -> str:
        made: Any = SimpleNamespace(**own, **edge, of_known=of_known)
        return ANSWERS["direction"](made)[0][0]

    assert said().startswith(start)
    missing = said(" whose outcome is known")
    assert ("whose outcome is known" in missing) == (fallen in (0.0, 1.0) or planes == 1)


def test_doubling() -> None:
    def said(coefficient: Any, low: Any, high: Any, earthquakes: int = 9) -> str:
        values = [np.array(one) for one in (coefficient, np.zeros(5), low, high)]
        names = ("intercept", "PGA", "ratio", "shape", "size")
        return doubling_sentence(LogisticFit(names, *values, 100, earthquakes, np.zeros(4), np.ones(4)))

    unknown = [NAN] * 5
    coefficient, low, high = [0, 3, 1, -2, -1], [-1, 2, -3, -3, -2], [1, 4, 4, -1, 0]
    told, untold = said(coefficient, low, high).split(". ")
    assert [numbers(part) for part in told.split("; ")] == [["8.0", "4.0", "16"], ["0.50", "0.25", "1.0"]]
    assert untold.startswith("9 earthquakes cannot tell")
    two = said([0, 4.65, 1, -2, -1], [-1, 2.39, -3, -3, -2], [1, 6.90, 4, -1, 0])
    assert "by 25 (5.2 to 119) where PGA, and PGV with it, doubles" in two
    assert "PGV alone" in untold
    assert said(coefficient, unknown, unknown, earthquakes=7).startswith("7 earthquakes cannot tell")
    assert said(unknown, unknown, unknown) == ""


def test_two_settings_compared_case_by_case() -> None:
    share, none, unknown = Mean(9, 0.4, 0.2, 0.6), Mean(9, 0.0, 0.0, 0.0), Mean(0, NAN, NAN, NAN)
    first, second = contrast_told(Contrast(share, none, Mean(9, 0.052, 0.03, 0.07), share, share), "here", "there")
    assert numbers(first) == ["9", "40", "20", "60", "5.2", "3.0", "7.0"]
    assert "only there in none" in first
    assert numbers(second) == ["40", "20", "60"] * 2
    alone = contrast_told(Contrast(share, none, none, unknown, unknown), "here", "there")
    assert alone[1].startswith("So it falls first here wherever it falls")
    apart = contrast_told(Contrast(share, share, none, unknown, unknown), "here", "there")
    assert apart[1].startswith("So there are no two directions")
    assert contrast_told(Contrast(*[unknown] * 5), "here", "there") == ("In no case is the outcome known under both.",)


def test_followed_reference_and_its_interval() -> None:
    sure, against, open_ = (Mean(9, *values) for values in ((0.5, 0.2, 0.7), (-0.4, -0.6, -0.1), (0.1, -0.3, 0.5)))
    velocity, normal = "peak velocity", "fault normal"
    references = {(velocity, True): [sure] * 3, (velocity, False): [open_, against, sure], (normal, True): [open_] * 3}
    (text,) = follow_sentences(
        {"all records": ReferenceAlignment(references, (velocity, normal), [sure])}, ["slender", "stout"]
    )
    best, closer, ends = text.split(". ")
    assert numbers(best) == ["2", "0.50", "0.20", "0.70", "9", "0", "0.10"]
    assert "leaves out 0" in best
    assert numbers(closer) == ["0.50", "0.20", "0.70"]
    assert closer.startswith("They lie closer")
    # Falls of slender and stout blocks to opposite ends are not averaged to zero.
    assert numbers(ends) == ["1", "−1", "−0.40", "−0.60", "−0.10", "9", "0.50", "0.20", "0.70", "9"]
    assert re.findall("slender: .*, against it; stout: .*, with it", ends)
    (text,) = follow_sentences({"all records": ReferenceAlignment(references, (velocity, normal), [open_])}, ["a", "b"])
    assert "not shown to lie closer" in text
    (text,) = follow_sentences({"all records": ReferenceAlignment({(normal, True): [open_]}, (normal,), [])}, [])
    assert "nothing is shown" in text
    assert follow_sentences({"all records": ReferenceAlignment({}, (), [])}, []) == []
    (text,) = follow_sentences({"all records": ReferenceAlignment({(normal, True): [against]}, (normal,), [])}, [])
    assert "its interval leaves out 0" in text
    assert "takes in 0" not in text
    few = Mean(3, 0.6, NAN, NAN)
    (text,) = follow_sentences({"all records": ReferenceAlignment({(normal, True): [few]}, (normal,), [])}, [])
    assert "0.60 over 3 earthquakes, too few for an interval." in text
    assert "takes in 0" not in text


def test_numbers() -> None:
    assert (percent(0.351), percent(0.351, 1), percent(NAN)) == ("35\u00a0%", "35.1\u00a0%", "–")
    # A share that is neither 0 nor 1 is not printed as such; rounding of a sum does not matter.
    least = {0.004: "0.4", 0.005: "0.5", 0.0051: "1", 4e-5: "0.004", 0.9949: "99", 0.996: "99.6", 0.99996: "99.996"}
    assert {share: percent(share) for share in least} == {share: f"{text}\u00a0%" for share, text in least.items()}
    assert (percent(0.99996, 1), percent(1 / 3000, 1)) == ("99.996\u00a0%", "0.03\u00a0%")
    assert [percent(one) for one in (0.0, 1e-12, 1 - 1e-12, 1.0)] == [f"{n}\u00a0%" for n in (0, 0, 100, 100)]
    assert (share(0.35, 0.004, 0.998), share(0.35, NAN, NAN)) == ("35\u00a0% (0.4 to 99.8)", "35\u00a0%")
    assert (number(-0.001), number(-1.25, 1), number(NAN)) == ("0.00", "−1.2", "–")
    assert (degrees(359.6, 360), degrees(-30.2), degrees(NAN)) == ("0°", "−30°", "–")
    assert (interval(-0.5, 1.0), interval(NAN, NAN)) == ("−0.50 to 1.00", "–")
    assert (estimate(0.5, 0.2, 0.7), estimate(0.5, NAN, NAN)) == ("0.50 (0.20 to 0.70)", "0.50")
    assert (counted(1, "record"), counted(0, "record")) == ("1 record", "0 records")


def test_cells_are_written_as_the_letter_of_their_column_says() -> None:
    made = table(tuple("abcdefg"), [("x", 0.4, 12345, 0.5, -1.25, 30.4, "–")], "tgd%1°2")
    assert made.rows == (("x", "0.4", "12,345", "50\u00a0%", "−1.2", "30°", "–"),)
    assert made.kinds == "tnnnnnn"
