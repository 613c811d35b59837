"""Sentences of the report on the convergence check and on disagreement between members."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from overturning.model.body import Body
from overturning.model.planes import Planes
from overturning.report.blocks import Caution, Paragraph, Section
from overturning.report.results import Results
from overturning.report.sections.exactness import convergence, dependence, ensemble
from overturning.study.convergence import AMPLITUDE_PERTURBATION, Convergence
from tests.report.reading import column, numbers, tables, text_of

COUNTS = {
    "element": "", "cases": 200, "flags": 2, "undivided": 160, "flags_undivided": 1, "sides_undivided": 0, "fallen": 50,
    "sides": 0, "fallen_undivided": 45, "fallen_agreed": 40, "sides_agreed": 0, "unanswered": 0,
}  # fmt: skip
FOUND = {
    "seed": 1, "wanted": 200, "chosen": 200, "at_rest": 0, "cells": 9000, "computed": 4500,
    "study_block_steps": 1000, "cost": 1.0,
    "finer_by": 8, "stiffer_by": 4.0,
    "finer": {"block_steps": 500, "outcomes": [COUNTS]},
    "stiffer": {"block_steps": 0, "outcomes": [], "refused": "too stiff"},
    "settling": {"changed": 0, "looked_at": 0, "settled": 0, "chaotic": 0, "block_steps": 0},
    "amplitude": None, "rigid": None,
}  # fmt: skip


BOUNDS = ("0.09", "2.78")  # of 1 in 200, %, by Wilson


def run_again(**counts: Any) -> dict[str, Any]:
    """A repetition in which other counts were found."""
    return {"block_steps": 500, "outcomes": [COUNTS | counts]}


def results_of(variants: tuple[str, ...] = (), members: int = 0, **found: Any) -> Any:
    study = SimpleNamespace(variants=variants, ensemble=SimpleNamespace(members=members))
    return SimpleNamespace(model=Planes(), study=study, convergence=Convergence.model_validate(FOUND | found))


def section(**found: Any) -> Section:
    return convergence(results_of(**found))


def warnings(shown: Section) -> list[Caution]:
    return [block for block in shown.blocks if isinstance(block, Caution)]


def test_processing_table_lists_changes_and_refusals() -> None:
    shown = section()
    assert numbers(text_of(shown).splitlines()[1])[:2] == ["200", "9,000"]
    assert "variants" not in text_of(shown)
    (table,) = tables(shown)
    assert column(table, "run again with") == ["steps 8 times finer", "", "springs 4 times stiffer"]
    assert column(table, "what changed")[1:] == ["side, where it falls", "not possible: too stiff"]
    assert column(table, "changed")[:2] == ["2", "0"]
    assert column(table, "share")[:2] == ["1.00\u00a0%", "0.00\u00a0%"]
    assert column(table, "of the study's") == ["50.0\u00a0%", "", ""]


def test_it_warns_above_one_percent() -> None:
    assert warnings(section()) == []
    more = run_again(flags=3, flags_undivided=3)
    (warning,) = warnings(section(finer=more))
    assert "steps 8 times finer" in warning.text
    assert "stiffer" not in warning.text.partition("of the flags")[0]
    (warning,) = warnings(section(finer=more, stiffer=more))
    assert "steps 8 times finer and with springs 4 times stiffer" in warning.text


@pytest.mark.parametrize(
    ("settling", "told"),
    [
        ({"changed": 0, "looked_at": 0}, []),
        ({"changed": 1, "looked_at": 0}, ["1"]),
        # Seven changed; four kept the finer steps' answer, two need finer ones yet, one changes with the motion, which
        # is half a percent of the 200.
        (
            {"changed": 7, "looked_at": 7, "settled": 4, "chaotic": 1},
            ["7", "4", "2", "1", "0.50", "95", "0.09", "2.78"],
        ),
        ({"changed": 7, "looked_at": 1, "settled": 1}, ["7", "1", "1", "0"]),
        ({"changed": 7, "looked_at": 1, "chaotic": 1}, ["7", "1", "0", "0", "1"]),
    ],
)
def test_decided_and_chaotic_cases_are_counted(settling: dict[str, int], told: list[str]) -> None:
    text = text_of(section(settling={"settled": 0, "chaotic": 0, "block_steps": 50} | settling))
    about = text.partition("With finer steps")[2].partition("\n")[0]
    assert numbers(about.replace(f"1 + {AMPLITUDE_PERTURBATION:g}", "")) == told


def test_reason_for_missing_repetition() -> None:
    assert "The variants were not run again." in text_of(section(variants=("bouncy",)))
    assert "verification.cost" in text_of(section(chosen=50))
    none = section(chosen=0, finer=run_again(cases=0, fallen=0, flags=0, flags_undivided=0))
    assert "No case was run again" in text_of(none)
    assert column(tables(none)[0], "share")[0] == "–"
    assert convergence(SimpleNamespace(study=None, convergence=None)) is None


def test_beside_the_exact_rigid_block() -> None:
    """3 of 200 cells change their flag and 5 their side; among the 160 with agreeing members 1 and 2."""
    assert "rigid" not in text_of(section())
    counts = COUNTS | {"flags": 3, "sides": 5, "sides_undivided": 2, "sides_agreed": 1}
    shown = section(members=24, rigid=counts | {"cells": 200})
    assert numbers(text_of(shown).partition("Blocks of µ")[2].partition("\n")[0]) == [
        "1", "200", "98.50", "96.00", "99.38", "98.12",
    ]  # fmt: skip
    assert column(tables(shown)[0], "changed")[-5:] == ["3", "1", "5", "2", "1"]
    assert column(tables(shown)[0], "block steps")[-5:] == [""] * 5
    assert "200 of them drawn at random" in text_of(section(rigid=counts | {"cells": 30_000}))


def test_a_count_of_all_cells_has_no_sampling_interval() -> None:
    """A complete enumeration has no error of sampling: a share of all cells is that share."""
    shown = section(members=24, rigid=COUNTS | {"cells": 200})
    (table,) = tables(shown)
    shown_intervals = column(table, "95 % interval")
    assert shown_intervals[-5:] == ["all cells"] * 5
    assert shown_intervals[0] == "0.27 to 3.57\u00a0%", "2 of a random 200 keep theirs"
    drawn = tables(section(members=24, rigid=COUNTS | {"cells": 201}))[0]
    assert "all cells" not in column(drawn, "95 % interval")
    # The same if every computed cell of a small study was repeated.
    settling = {"changed": 7, "looked_at": 7, "settled": 4, "chaotic": 1, "block_steps": 50}
    every = results_of(chosen=200, computed=200, settling=settling)
    assert column(tables(convergence(every))[0], "95 % interval")[:2] == ["all cells", "all cells"]
    line = dependence(every)
    for text in (line.text, text_of(convergence(every)).partition("With finer steps")[2].partition("\n")[0]):
        assert text
        assert " to " not in text.replace("to the other side", "")
        assert "interval" not in text


def test_sides_that_change_although_all_members_agree_have_a_row() -> None:
    """21 of 29 falls that change sides are in cases whose members all fall, 10 in cases whose members fall one way.

    That they are divided over the side the flags alone do not show.
    """
    counts = {"fallen": 964, "sides": 29, "fallen_undivided": 800, "sides_undivided": 21}
    (table,) = tables(section(members=24, finer=run_again(**counts, fallen_agreed=607, sides_agreed=10)))
    assert column(table, "changed")[2:5] == ["29", "21", "10"]
    assert column(table, "compared")[2:5] == ["964", "800", "607"]
    assert column(table, "share")[2:5] == ["3.01\u00a0%", "2.62\u00a0%", "1.65\u00a0%"]
    assert "not divided" in column(table, "what changed")[3]
    assert "falls one way" in column(table, "what changed")[4]
    assert not any("falls one way" in text for text in column(tables(section())[0], "what changed"))


def test_share_of_3d_falls_with_unstable_azimuth() -> None:
    moving = {"falls": 60, "moved": 15, "stood": 2, "weight": 50.0, "weight_moved": 4.0, "block_steps": 100}
    results = results_of(members=8, amplitude=moving)
    results.model = Body()
    for text in (dependence(results).text, text_of(convergence(results))):
        about = text.partition(" Of 60 falls ")[2].partition(" of the weight")[0]
        # 25 % of the falls, with 8 % of the weight in direction statistics.
        assert numbers(about) == ["25.0", "15.8", "37.2", "30", "1", "8.0"]
    results.study.ensemble.members = 0
    assert "count them in full" in dependence(results).text
    assert "elsewhere under motions" not in dependence(results_of(members=8)).text


def test_no_sentence_about_zero_cases() -> None:
    """Regression: shares of zero cells were printed, such as "all" or 0.0 %."""
    none = COUNTS | {"undivided": 0, "flags_undivided": 0}
    told = text_of(section(members=24, rigid=none | {"cells": 200})).partition("Blocks of µ")[2].partition("\n")[0]
    assert "is not divided" not in told
    for answered, said in ((0, "more than g.\n"), (150, "gives the others the same flag in 98.00\u00a0%")):
        counts = none | {"cases": answered, "unanswered": 200 - answered, "flags": 3, "cells": 200}
        told = text_of(section(rigid=counts)).partition("Blocks of µ")[2]
        assert f"In {200 - answered} cases there is nothing to compare" in told
        assert said in told
    line = dependence(results_of(members=24, finer=run_again(undivided=0, flags_undivided=0)))
    assert "is not divided" not in line.text


def test_each_element_is_counted_by_itself() -> None:
    outcomes = [COUNTS | {"element": name} for name in ("slender", "squat")]
    shown = section(finer={"block_steps": 500, "outcomes": outcomes})
    assert "squat falls or stands" in column(tables(shown)[0], "what changed")


def test_the_line_below_the_answer() -> None:
    calm = dependence(results_of())
    assert type(calm) is Paragraph
    assert numbers(calm.text) == ["200", "0.0", "0.0", "7.1", "8", "1.0", "8"]  # of 0 in 50 by Wilson 7.1 %
    warning = dependence(results_of(stiffer=run_again(flags=5, flags_undivided=5)))
    assert isinstance(warning, Caution)
    assert "contact.stiffness" in warning.text
    assert "time_step" not in warning.text
    in_space = results_of(stiffer=run_again(flags=5, flags_undivided=5))
    in_space.model = Body()
    spring = dependence(in_space)
    assert isinstance(spring, Caution)
    assert "Do not trust single cells (How exact" in spring.text, "its springs are those of its weight"
    assert dependence(results_of(chosen=0)) is None
    # Sides come first. Cells with disagreeing members count, but cause no warning; the others are
    # a share of such cases.
    outcomes = run_again(flags=5, flags_undivided=1, sides=10)
    divided = dependence(results_of(members=24, stiffer=outcomes, finer=outcomes))
    assert type(divided) is Paragraph
    ways = ["20.0", "11.2", "33.0"]  # of 10 in 50, by Wilson
    assert numbers(divided.text) == ["200", *ways, "8", *ways, "4", "2.5", "8", "2.5", "4", "0.6"]
    assert "to the other side" in divided.text
    settled = dependence(
        results_of(members=24, finer=run_again(flags_undivided=0), stiffer=run_again(flags_undivided=0))
    )
    assert "is not divided, in none. No single" in settled.text
    shown = section(members=24, finer=outcomes)
    assert warnings(shown) == []
    (table,) = tables(shown)
    assert column(table, "changed")[:2] == ["5", "1"]
    assert column(table, "compared")[:5] == ["200", "160", "50", "45", "40"]
    # 2 of 160 are more than one percent, of all 200 they would not be.
    assert len(warnings(section(members=24, finer=run_again(flags=5, flags_undivided=2)))) == 1
    assert dependence(SimpleNamespace(study=None, convergence=None)) is None


def test_the_ensemble(opened: Results, one_record: Callable[..., Results]) -> None:
    assert "4 more times" in text_of(ensemble(opened))
    assert "nothing to run" in text_of(ensemble(one_record(probability_towards=np.nan)))
    two, times = one_record(2), xr.DataArray([1, 3], dims="record")
    some = replace(two, cube=two.cube.assign(members=(two.cube["members"] * times).astype("int16")))
    assert "4 to 12 more times" in text_of(ensemble(some))
