"""What the report says of its convergence check."""

from types import SimpleNamespace
from typing import Any

from overturning.model.planes import Planes
from overturning.report.blocks import Caution, Note, Section
from overturning.report.sections.convergence import convergence, dependence
from overturning.study.convergence import Convergence
from tests.report.reading import column, tables, text_of

COUNTS = {"element": "", "cases": 200, "flags": 2, "flags_undivided": 2, "fallen": 50, "sides": 0, "unanswered": 0}
FOUND = {
    "seed": 1, "wanted": 200, "chosen": 200, "at_rest": 0, "cells": 9000, "study_block_steps": 1000, "cost": 1.0,
    "finer_by": 8, "stiffer_by": 4.0, "finer": {"block_steps": 500, "outcomes": [COUNTS]},
    "stiffer": {"block_steps": 0, "outcomes": [], "refused": "too stiff"},
    "settling": {"changed": 0, "looked_at": 0, "settled": 0, "chaotic": 0, "block_steps": 0},
}  # fmt: skip


def study(members: int = 0, variants: tuple[str, ...] = ()) -> Any:
    return SimpleNamespace(variants=variants, ensemble=SimpleNamespace(members=members))


def section(variants: tuple[str, ...] = (), members: int = 0, **found: Any) -> Section:
    results: Any = SimpleNamespace(
        model=Planes(), study=study(members, variants), convergence=Convergence.model_validate(FOUND | found)
    )
    shown = convergence(results)
    assert shown is not None
    return shown


def warnings(shown: Section) -> list[Caution]:
    return [block for block in shown.blocks if isinstance(block, Caution)]


def test_what_changed_and_what_was_refused() -> None:
    shown = section()
    assert "200 of the 9000 cases, drawn at random, were run again; 0 of them" in text_of(shown)
    assert "variants" not in text_of(shown)
    assert "asked for" not in text_of(shown)
    (table,) = tables(shown)
    assert column(table, "run again with") == ["steps 8 times finer", "", "springs 4 times stiffer"]
    assert column(table, "what changed")[1:] == ["side, where it falls", "not possible: too stiff"]
    assert column(table, "changed")[:2] == ["2", "0"]
    assert column(table, "share")[:2] == ["1.00\u00a0%", "0.00\u00a0%"]
    assert column(table, "of the study's") == ["50\u00a0%", "", ""]


def test_it_warns_above_one_percent() -> None:
    assert warnings(section()) == []
    more = {"block_steps": 500, "outcomes": [COUNTS | {"flags": 3, "flags_undivided": 3}]}
    (warning,) = warnings(section(finer=more))
    assert "steps 8 times finer more than 1\u00a0% of the flags change" in warning.text
    (warning,) = warnings(section(finer=more, stiffer=more))
    assert "steps 8 times finer and with springs 4 times stiffer more" in warning.text


def test_what_finer_steps_settle_and_what_nothing_decides() -> None:
    def said(**settling: int) -> str:
        return text_of(section(settling={"settled": 0, "chaotic": 0, "block_steps": 50} | settling))

    assert "settled" not in said(changed=0, looked_at=0)
    many = said(changed=7, looked_at=7, settled=4, chaotic=1)
    assert "7 cases changed; they were computed twice more" in many
    assert "4 kept the answer of the finer steps, which so is settled; 2 changed with the shorter steps only" in many
    assert "1 changed with the motion; no computation decides these, 0.50\u00a0% of" in many
    assert "(95 % interval 0.09 to 2.78\u00a0%)." in many
    some = said(changed=7, looked_at=1, settled=1)
    assert "7 cases changed; 1 of them was computed twice more" in some
    assert "none changed with the motion." in some
    assert "no computation decides these." in said(changed=7, looked_at=1, chaotic=1)
    assert "1 case changed; it was computed" in said(changed=1, looked_at=1, settled=1)
    assert "no room to look why" in said(changed=1, looked_at=0)


def test_what_was_not_run_again() -> None:
    assert "The variants were not run again." in text_of(section(variants=("bouncy",)))
    assert "verification.cost sets this bound" in text_of(section(chosen=50))
    none = section(
        chosen=0,
        finer={"block_steps": 0, "outcomes": [COUNTS | {"cases": 0, "fallen": 0, "flags": 0, "flags_undivided": 0}]},
    )
    assert "No case was run again" in text_of(none)
    assert column(tables(none)[0], "share")[0] == "–"


def test_each_element_is_counted_by_itself() -> None:
    outcomes = [COUNTS | {"element": name} for name in ("slender", "squat")]
    shown = section(finer={"block_steps": 500, "outcomes": outcomes})
    assert "Each element of the scene is counted by itself." in text_of(shown)
    assert "squat falls or stands" in column(tables(shown)[0], "what changed")


def test_a_study_without_it_has_no_section() -> None:
    results: Any = SimpleNamespace(study=None, convergence=None)
    assert convergence(results) is None


def test_the_line_below_the_answer() -> None:
    def line(members: int = 0, **found: Any) -> Any:
        results: Any = SimpleNamespace(study=study(members), convergence=Convergence.model_validate(FOUND | found))
        return dependence(results)

    calm = line()
    assert type(calm) is Note
    assert "200 cases change 1.0\u00a0% of the flags with steps 8 times finer" in calm.text
    more = {"block_steps": 500, "outcomes": [COUNTS | {"flags": 5, "flags_undivided": 5}]}
    warning = line(stiffer=more)
    assert isinstance(warning, Caution)
    assert "2.5\u00a0% of the flags with springs 4 times stiffer" in warning.text
    assert "a larger contact.stiffness would help" in warning.text
    assert "time_step" not in warning.text
    assert line(chosen=0) is None
    # What the neighbourhood does not agree on counts, but does not warn.
    outcomes = {"block_steps": 500, "outcomes": [COUNTS | {"flags": 5, "flags_undivided": 1}]}
    divided = line(24, stiffer=outcomes, finer=outcomes)
    assert type(divided) is Note
    assert "2.5\u00a0% of the flags with springs" in divided.text
    assert "at most 0.5\u00a0% where the neighbourhood of a case agrees" in divided.text
    shown = section(members=24, finer=outcomes)
    assert warnings(shown) == []
    (table,) = tables(shown)
    assert column(table, "changed")[:2] == ["5", "1"]
    assert dependence(SimpleNamespace(study=None, convergence=None)) is None  # type: ignore[arg-type]
