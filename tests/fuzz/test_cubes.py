"""Damaged cubes, and malicious names in pages."""

import io
import json
import os
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
import yaml
from hypothesis import strategies as st

from overturning.cli import main
from overturning.figures.explore import write_explorer
from overturning.files import append_checksum
from overturning.findings.collect import Findings
from overturning.records.record import Record
from overturning.report.page import render_report_html_page
from overturning.report.render import parse_markdown_and_number_figures_and_tables, render_template_as_markdown
from overturning.study.cube import open_cube, record_sources, record_sources_and_processing_by_id, study_of_cube
from overturning.study.gather import merge_outcome_files_into_cube
from overturning.study.load import study_from_content
from overturning.study.sweep import simulate_and_write_cases_of_record
from tests.fuzz.spoiling import (
    EVIL_WORDS,
    assert_read_or_plain_error,
    run_on_random_examples_for_share_of_fuzzing_time,
    strategy_for_corrupted_bytes,
    strategy_for_yaml_files_with_changed_settings,
    tags_and_attributes_that_run_or_load_code,
)
from tests.report.by_hand import RECORD_FINDING, STUDY_FINDINGS, findings_with_changed_entries

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def bytes_of_small_cube_file(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Return the bytes of the NetCDF file of a small cube."""
    folder = tmp_path_factory.mktemp("cube")
    study = study_from_content(
        {
            "name": "small", "records": {"use": ["a"]}, "azimuth": {"step": 90}, "b_over_h": [0.3], "friction": [0.5],
            "ensemble": {"members": 0}, "verification": "none",
        },
        "test",
    )  # fmt: skip
    wave = 6.0 * np.sin(np.arange(300) / 12.0)
    record = Record("a", wave, 0.1 * wave, None, 0.01, station="S", event="E", sha256="0" * 64)
    simulate_and_write_cases_of_record(study, record, folder / "a.nc")
    merge_outcome_files_into_cube(study, [record], [folder / "a.nc"], folder / "cube.nc")
    return (folder / "cube.nc").read_bytes()


def make_and_check_explorer_page_of_cube(path: Path) -> None:
    """Make the explorer page of a cube; it must contain exactly two scripts, the data and its own."""
    assert write_explorer  # imported, so that a child need not
    page = path.with_suffix(".html")
    page.unlink(missing_ok=True)
    try:
        with redirect_stderr(io.StringIO()) as said, redirect_stdout(io.StringIO()):
            main(["explore", str(path), "--output", str(page)])
        code: object = 0
    except SystemExit as end:
        code = end.code
    assert not code or (code == 1 and said.getvalue().startswith("error: ")), said.getvalue()
    if page.is_file():
        assert tags_and_attributes_that_run_or_load_code(page.read_text(encoding="utf-8")) == [
            "meta",
            "meta",
            "script",
            "script",
        ], "a script in the page"
    with suppress(RuntimeError), open_cube(path) as opened:
        study_of_cube(opened), record_sources(opened), record_sources_and_processing_by_id(opened)


def unexpected_error_or_crash_of_reader_in_child(read: Callable[[], Any]) -> str:
    """Call a reader in a child process that it may crash; return the unexpected error or signal, or no text."""
    receiver, sender = os.pipe()
    child = os.fork()
    if not child:
        try:
            assert_read_or_plain_error(read)
        except BaseException as other:
            os.write(sender, f"{type(other).__name__}: {other}"[:2000].encode("utf-8", "replace"))
        os._exit(0)
    os.close(sender)
    with os.fdopen(receiver, "rb") as pipe:
        said = pipe.read().decode(errors="replace")
    _, status = os.waitpid(child, 0)
    return said or (f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else "")


def test_a_corrupted_cube_raises_no_unexpected_python_error(
    isolated_folder: Path, bytes_of_small_cube_file: bytes
) -> None:
    path = isolated_folder / "cube.nc"
    bare = bytes_of_small_cube_file[:-75]

    def check_explorer_page_of_byte_corrupted_cube(case: tuple[bool, bytes]) -> None:
        path.write_bytes(case[1])
        if case[0]:
            append_checksum(path)
        said = unexpected_error_or_crash_of_reader_in_child(lambda: make_and_check_explorer_page_of_cube(path))
        # The library of HDF5 itself may fall over a file that was made to; a process of ours falls with it.
        assert said in ("", "signal 11", "signal 6"), said

    check_explorer_page_of_byte_corrupted_cube((False, bytes_of_small_cube_file))
    check_explorer_page_of_byte_corrupted_cube((False, bare))
    run_on_random_examples_for_share_of_fuzzing_time(
        st.tuples(st.booleans(), strategy_for_corrupted_bytes(bare)),
        check_explorer_page_of_byte_corrupted_cube,
        examples=6,
    )


def test_a_cube_with_unexpected_content_is_read_or_refused_plainly(
    isolated_folder: Path, bytes_of_small_cube_file: bytes
) -> None:
    (isolated_folder / "whole.nc").write_bytes(bytes_of_small_cube_file)
    path = isolated_folder / "cube.nc"
    with xr.open_dataset(isolated_folder / "whole.nc", decode_timedelta=False) as opened:
        whole = opened.load()
    study = json.loads(whole.attrs["study"])

    def check_explorer_page_of_cube_with_altered_content(case: tuple[str, str, Any]) -> None:
        what, name, value = case
        changed = whole.copy()
        if what == "variable":
            changed = changed.drop_vars(name)
        elif what == "dimension":
            changed = changed.isel({name: slice(0, 0)})
        elif what == "attribute":
            changed.attrs.pop(name)
        else:
            changed.attrs[name] = value
        changed.drop_encoding().to_netcdf(path, engine="netcdf4")
        said = unexpected_error_or_crash_of_reader_in_child(lambda: make_and_check_explorer_page_of_cube(path))
        assert said == "", f"{case[:2]}: {said}"

    def convert_yaml_to_json(value: bytes) -> str:
        return json.dumps(yaml.safe_load(value), default=str)

    words = st.sampled_from(["", "{", "[]", "null", '"x"', "3", "[1]", '{"a": []}', "</script><script>hurt()</script>"])
    cases = st.one_of(
        st.tuples(st.just("variable"), st.sampled_from(sorted(map(str, whole.variables))), st.none()),
        st.tuples(st.just("dimension"), st.sampled_from(sorted(map(str, whole.dims))), st.none()),
        st.tuples(st.just("attribute"), st.sampled_from(sorted(whole.attrs)), st.none()),
        st.tuples(st.just("value"), st.sampled_from(sorted(whole.attrs)), words),
        st.tuples(
            st.just("value"),
            st.just("study"),
            strategy_for_yaml_files_with_changed_settings(study).map(convert_yaml_to_json),
        ),
    )
    run_on_random_examples_for_share_of_fuzzing_time(
        cases, check_explorer_page_of_cube_with_altered_content, examples=6
    )


def test_hostile_names_cannot_add_scripts_to_the_report(isolated_folder: Path) -> None:
    name = (
        st.text(max_size=40)
        | st.sampled_from(EVIL_WORDS[:-1])
        | st.tuples(st.text(max_size=5), st.sampled_from(EVIL_WORDS)).map("".join)
    )

    def render_findings_with_names_as_html(names: list[str]) -> str:
        one, two, three = names
        record = RECORD_FINDING | {"id": one, "station": two, "event": three}
        data = findings_with_changed_entries(
            STUDY_FINDINGS["survey"], study={"title": one, "question": two}, records=[record]
        )
        data = data | {"sources": [{"record": three, "source": one, "licence": two}]}
        text = render_template_as_markdown(Findings.model_validate(data))
        return render_report_html_page(parse_markdown_and_number_figures_and_tables(text), three, "en", None, {})

    usual = tags_and_attributes_that_run_or_load_code(render_findings_with_names_as_html(["a", "b", "c"]))

    def assert_page_has_no_added_script(names: list[str]) -> None:
        assert tags_and_attributes_that_run_or_load_code(render_findings_with_names_as_html(names)) == usual

    run_on_random_examples_for_share_of_fuzzing_time(
        st.lists(name, min_size=3, max_size=3), assert_page_has_no_added_script
    )
