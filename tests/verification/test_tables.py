"""Measured figures are written to files and between the markers in the docs, reproducibly."""

from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from overturning.dem.block import state
from overturning.dem.kernel import clock
from overturning.errors import ResultError
from verification import experiments, sentences, timing
from verification.shaking_table import page as shaking_table
from verification.tables import (
    RESULT_TABLE_FOLDER,
    ROOT,
    MeasuredNumber,
    commit_and_machine_line,
    current_commit,
    measured_numbers_table,
    read_measured_numbers,
    read_table,
    update_marked_tables_and_sentences_in_docs,
    write_measured_numbers,
    write_table_as_netcdf_and_csv,
)
from verification.work_precision import page as error_page


def test_a_verification_table_is_reproducible_and_read_back_equal(tmp_path: Path) -> None:
    rows = pd.DataFrame({"a": [1.0, np.nan], "b": ["x", ""], "c": np.array([1, -128], np.int8)})
    meanings = {name: (name, "1") for name in rows}
    for name in ("one", "two"):
        write_table_as_netcdf_and_csv(
            rows, tmp_path / f"{name}.nc", long_name_and_unit_by_column=meanings, global_attributes={"seed": 1}
        )
    back = read_table(tmp_path / "one.nc")
    assert back.attrs == {"seed": 1}
    for name, values in rows.items():
        np.testing.assert_array_equal(back[name].to_numpy(), values.to_numpy())
    assert back["c"].dtype == np.int8
    assert (tmp_path / "one.nc").read_bytes() == (tmp_path / "two.nc").read_bytes()
    assert (tmp_path / "one.csv").read_text(encoding="utf-8") == "a,b,c\n1,x,1\nnan,,-128\n"
    with pytest.raises(ResultError, match="make verify"):
        read_table(tmp_path / "none.nc")


def test_generated_tables_replace_only_the_text_between_their_markers(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    pages = [tmp_path / "README.md", tmp_path / "docs" / "page.md", tmp_path / "docs" / "other.md"]
    for page in pages[:2]:
        page.write_text("before\n<!-- x:begin -->\nold\n<!-- x:end -->\nafter\n", encoding="utf-8")
    pages[2].write_text("nothing", encoding="utf-8")
    for _ in range(2):
        update_marked_tables_and_sentences_in_docs({"x": r"new \1"}, tmp_path)
    for page in pages[:2]:
        text = f"before\n<!-- x:begin -->\n\nnew \\1\n\n{commit_and_machine_line()}\n\n<!-- x:end -->\nafter\n"
        assert page.read_text(encoding="utf-8") == text
    assert pages[2].read_text(encoding="utf-8") == "nothing"
    with pytest.raises(ResultError, match="y:begin"):
        update_marked_tables_and_sentences_in_docs({"y": "", "x": "newer"}, tmp_path)
    assert "newer" in pages[0].read_text(encoding="utf-8"), "what has its marks is published all the same"


def test_a_measured_number_replaces_only_its_own_old_value(tmp_path: Path) -> None:
    path = tmp_path / "exactness.csv"
    write_measured_numbers([MeasuredNumber("speed", 3.0, "x"), MeasuredNumber("cases", 20_000)], path)
    assert write_measured_numbers(
        [MeasuredNumber("speed", 2.5, "x")], path, keep_other_stored_numbers=True
    ) == read_measured_numbers(path)
    assert measured_numbers_table(read_measured_numbers(path)).splitlines()[2:] == [
        "| speed | 2.5 x |",
        "| cases | 20,000 |",
    ]


def test_a_table_names_the_commit_of_each_number_measured_earlier(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    write_measured_numbers([MeasuredNumber("speed", 2.5, "x")], path)
    (row,) = read_measured_numbers(path)
    assert row.commit == current_commit()
    path.write_text(path.read_text(encoding="utf-8").replace(current_commit(), "0123e456"), encoding="utf-8")
    known = write_measured_numbers([MeasuredNumber("cases", 1)], path, keep_other_stored_numbers=True)
    lines = ["| speed | 2.5 x | 0123e456 |", f"| cases | 1 | {current_commit()} |"]
    assert measured_numbers_table(known).splitlines()[2:] == lines
    assert current_commit() in commit_and_machine_line()


def test_a_long_benchmark_is_timed_only_once(monkeypatch: pytest.MonkeyPatch) -> None:
    for seconds, runs in ((0.5, 3), (3.0, 2), (5.0, 1)):
        clock = iter(np.arange(20) * seconds)
        monkeypatch.setattr("verification.timing.time.process_time", lambda clock=clock: next(clock))
        calls: list[int] = []
        assert timing.run_and_measure_min_processor_time(partial(calls.append, 1), 3, int) == (None, seconds)
        assert len(calls) == runs


PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_measured_numbers_in_sentences_equal_those_in_their_tables(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert sentences.fill_measured_numbers_into_page(text, RESULT_TABLE_FOLDER) == text, "python -m verification.tables"
    assert len(sentences.MARKED_NUMBER_PATTERN.findall(text)) == text.count("<!--=") == text.count("<!--/-->")


def test_each_measured_number_is_in_a_sentence_and_updated_from_its_table(tmp_path: Path) -> None:
    texts = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    assert {name for name, _ in sentences.MARKED_NUMBER_PATTERN.findall(texts)} == set(
        sentences.NUMBER_FUNCTION_BY_MARKER
    )
    write_measured_numbers([MeasuredNumber("flags changed by leaving out", 7.0)], tmp_path / "x86-64-2-cores.csv")
    assert (
        sentences.fill_measured_numbers_into_page("<!--=left-out-flags-->5<!--/--> do", tmp_path)
        == "<!--=left-out-flags-->7<!--/--> do"
    )
    rows = (
        "cases_of,method,default,cases,wrong_flags,wrong_sides,disagree\n"
        '"records, no sliding",centred,1,90,3,4,2\n'
        '"records, no sliding",centred,0,90,1,1,1\nsine pulses,centred,1,80,0,0,0\n'
    )
    (tmp_path / "work-precision.csv").write_text(rows, encoding="utf-8")
    names = ("rigid-cases", "rigid-otherwise", "rigid-otherwise-shared")
    assert [sentences.NUMBER_FUNCTION_BY_MARKER[name](tmp_path) for name in names] == ["90", "7", "2"]
    with pytest.raises(KeyError):
        sentences.fill_measured_numbers_into_page("<!--=unheard-of-->5<!--/-->", tmp_path)


def test_tables_in_the_docs_equal_those_of_the_result_files() -> None:
    boulder = shaking_table.score_tables_by_marker(pd.read_csv(RESULT_TABLE_FOLDER / "shaking-table.csv"))
    curve = pd.read_csv(RESULT_TABLE_FOLDER / "default-step.csv")
    made = boulder | {"equal-error": experiments.cost_ratio_table_of_default_to_cundall_scheme(curve)}
    made["equal-agreement"] = error_page.table_of_least_time_by_share_of_equal_outcomes(
        pd.read_csv(RESULT_TABLE_FOLDER / "work-precision.csv")
    )
    texts = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    assert [mark for mark, body in made.items() if f"<!-- {mark}:begin -->\n\n{body}\n\n" not in texts] == []


def test_each_experiment_on_the_step_control_changes_one_existing_constant(monkeypatch: pytest.MonkeyPatch) -> None:
    """The statements of experiments are text run in another process: a stale name would fail only after hours."""
    changed = []
    for name, statements in experiments.STEP_CONTROL_CHANGE_CODE_BY_NAME.items():
        with monkeypatch.context() as patched:
            constants = [(clock, "BLOCK_STEP_CONTROL")] + [(state, one) for one in vars(state) if one.isupper()]
            before = {(module.__name__, one): getattr(module, one) for module, one in constants}
            for module, one in constants:
                patched.setattr(module, one, getattr(module, one))  # restored afterwards
            exec(statements, {})
            after = {(module.__name__, one): getattr(module, one) for module, one in constants}
        changed.append((name, sum(before[key] is not after[key] for key in before)))
    assert changed == [(name, int(name != "unchanged")) for name, _ in changed]


def test_cost_at_equal_error_is_found_on_a_non_monotonic_curve() -> None:
    """Errors 4, 1 and 2 % at 1, 2 and 4 s: 2 % is first reached between 1 and 2 s, at √2 s, not at 4 s."""
    rows = [("centred", 0.1, 2.0), ("cundall", 4.0, 2.0), ("cundall", 2.0, 1.0), ("cundall", 1.0, 4.0)]
    curve = pd.DataFrame([(name, cost, *(error,) * 4) for name, cost, error in rows])
    curve.columns = pd.Index(["scheme", "processor time, s", *experiments.ERROR_COLUMN_TITLES])
    assert experiments.cost_ratio_table_of_default_to_cundall_scheme(curve).count("| 1/14 |") == 4
    curve.loc[0, experiments.ERROR_COLUMN_TITLES] = [0.5, 8.0, 4.0, 1.0]
    shares = [
        line.split(" | ")[-1]
        for line in experiments.cost_ratio_table_of_default_to_cundall_scheme(curve).splitlines()[2:]
    ]
    assert shares == ["1/40, at most |", "1/10, at least |", "1/10, at least |", "1/20 |"]


def test_the_shortest_time_at_which_an_engine_reaches_an_agreement_is_found() -> None:
    """An engine's time for an agreement is the shortest time per case at which it reaches that agreement.

    An engine that agrees in 8 of 10 cases in 1 s per case, and in 9 of 10 in 3 s and in 5 s, needs 3 s for 90 % and
    never reaches 95 %.
    """
    rows = pd.DataFrame({
        "cases_of": "records, no sliding", "method": ["exact", "pymunk", "pymunk", "pymunk"], "shared": 10.0,
        "disagree": [0.0, 2.0, 1.0, 1.0], "seconds_per_case": [0.1, 1.0, 5.0, 3.0],
    })  # fmt: skip
    head, _, *lines = error_page.table_of_least_time_by_share_of_equal_outcomes(rows).splitlines()
    assert head == "| agreement in 10 cases | exact | pymunk |"
    assert lines[0] == "| 90 % | 100 ms | 3e+03 ms |"
    assert lines[1] == "| 95 % | 100 ms | – |"
    assert lines[-1] == "| highest agreement | 100.0 % in 100 ms | 90.0 % in 3e+03 ms |"
