"""Preflight check: errors that would stop a run are found before it starts."""

import json
import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from overturning.errors import ConfigError, MissingDataError, OverturningError
from overturning.motion.soil import import_pystrata
from overturning.records.catalogue import RecordTableRow
from overturning.statistics.by_record import record_masks_by_group
from overturning.study.load import load_study, study_from_content
from overturning.study.preflight import (
    can_compute_fault_alignment,
    check_soil_curve_package,
    estimate_and_check_study_size,
    estimate_cases_time_memory_and_disk_of_study,
    find_record_rows_and_files,
    read_and_process_records_and_collect_notes,
)
from tests.expect import run_overturning_and_return_printed_text
from tests.records.world_writers import unam_text

ROOT = Path(__file__).parents[2]
RECORD_TABLE_HEADER_LINE = "id\tformat\tsource\tcolumns\n"


def write_record_table_and_make_study(tmp_path: Path, *rows: str, **more: Any) -> Any:
    """Write a record table of the given rows and return a study of all its records."""
    (tmp_path / "records.tsv").write_text(
        RECORD_TABLE_HEADER_LINE + "".join(f"{row}\n" for row in rows), encoding="utf-8"
    )
    use = [row.split("\t")[0] for row in rows]
    records = {"use": use, "table": str(tmp_path / "records.tsv"), "folder": str(tmp_path)}
    return study_from_content({"name": "mine", "records": records} | more, "mine.yaml")


def study_of_record(record: str, **more: Any) -> Any:
    """Return a study of one record of the shipped record table."""
    return study_from_content({"name": "mine", "records": {"use": [record]}} | more, "mine.yaml")


def preflight_notes_on_records(study: Any) -> tuple[str, ...]:
    """Return the notes on the records of a study."""
    return read_and_process_records_and_collect_notes(study, find_record_rows_and_files(study, "mine.yaml")[0])


def test_the_preflight_check_names_all_missing_record_files(tmp_path: Path) -> None:
    with pytest.raises(MissingDataError) as found:
        find_record_rows_and_files(
            write_record_table_and_make_study(tmp_path, *(f"r{n}\tauto\tr{n}.V2A" for n in range(9))), "mine.yaml"
        )
    lines = str(found.value).splitlines()
    assert lines[0].startswith("record r0: r0.V2A is not in ")
    assert len(lines) == 7
    assert lines[-1].strip() == "… and 3 more"


@pytest.mark.parametrize("source", ["../secret.V2A", "/etc/passwd"])
def test_a_record_source_outside_its_folder_is_refused(tmp_path: Path, source: str) -> None:
    with pytest.raises(ConfigError, match=rf"record one: source '{source}' lies outside"):
        find_record_rows_and_files(write_record_table_and_make_study(tmp_path, f"one\tauto\t{source}"), "mine.yaml")


def test_the_preflight_check_names_unreadable_record_files(tmp_path: Path) -> None:
    for name in ("one.csv", "two.csv"):
        (tmp_path / name).write_text("time,north,east\n0,1,2\n", encoding="utf-8")
    study = write_record_table_and_make_study(tmp_path, "one\tcsv\tone.csv", "two\tnonsense\ttwo.csv")
    entries, files = find_record_rows_and_files(study, "mine.yaml")
    assert files["one"] == [tmp_path / "one.csv"]
    with pytest.raises(OverturningError) as found:
        read_and_process_records_and_collect_notes(study, entries)
    columns, processed, second = str(found.value).splitlines()
    assert "one.csv: columns are not declared" in columns
    assert "one.csv: columns do not say whether" in processed
    assert "format 'nonsense'" in second


def test_the_preflight_check_notes_skipped_data_of_a_record_file(tmp_path: Path) -> None:
    waves = 50 * np.sin(np.arange(500) / 9)
    (tmp_path / "x.asa").write_text(unam_text({"N00E": waves, "N90E": waves[::-1], "V": waves}), encoding="utf-8")
    study = write_record_table_and_make_study(tmp_path, "one\tauto\tx.asa", b_over_h=[0.02, 0.1])
    (note,) = preflight_notes_on_records(study)
    assert note.startswith("record one: vertical axis 'V' left out: x.asa does not say whether up or down")


@pytest.mark.parametrize(("gal", "weak"), [(90.0, True), (105.0, False)])
def test_a_record_too_weak_to_move_any_stone_is_noted(tmp_path: Path, gal: float, weak: bool) -> None:
    """By West's limit, a rigid block of B/H 0.1 rocks from a PGA of 98 Gal on, along the motion."""
    row = f"slight\tsynthetic\tsine amplitude_gal={gal:g} period_s=1 azimuth_deg=40"
    study = write_record_table_and_make_study(tmp_path, row, b_over_h=[0.1, 0.4], friction=[0.5])
    assert preflight_notes_on_records(study) == (
        ("record slight: too weak to move any stone of the study",) if weak else ()
    )
    twice = write_record_table_and_make_study(tmp_path, row, b_over_h=[0.1, 0.4], friction=[0.5], amplitude=[1, 2])
    assert preflight_notes_on_records(twice) == ()


@pytest.mark.parametrize("without", [{"simulation": {"vertical": False}}, {"variants": {"flat": {"vertical": False}}}])
def test_omitted_vertical_motion_is_ignored_in_the_note_on_weak_records(
    tmp_path: Path, without: dict[str, Any]
) -> None:
    """A study without vertical motion ignores upward acceleration in its note on weak records.

    A motion of 105 Gal does not rock a block of B/H 0.1 while the ground accelerates upwards by as much, but does
    without vertical motion.
    """
    wave = 105 * np.sin(np.arange(500) / 9)
    # Some of it goes east: an axis at rest beside one that moves is taken for a dead channel.
    rows = "".join(f"{h:.4f},{0.1 * h:.4f},{abs(h):.4f}\n" for h in wave)
    (tmp_path / "x.csv").write_text(rows, encoding="utf-8")
    header = RECORD_TABLE_HEADER_LINE.strip() + "\tprocessed\tsampling_interval_s\n"
    (tmp_path / "records.tsv").write_text(
        f"{header}slight\tcsv\tx.csv\tnorth:gal east:gal up:gal\ttrue\t0.01\n", encoding="utf-8"
    )
    records = {"use": ["slight"], "table": str(tmp_path / "records.tsv"), "folder": str(tmp_path)}
    plain = {"name": "mine", "records": records, "b_over_h": [0.1, 0.4], "friction": [0.5]}
    weak = "record slight: too weak to move any stone of the study"
    assert weak in preflight_notes_on_records(study_from_content(plain, "mine.yaml"))
    assert weak not in preflight_notes_on_records(study_from_content(plain | without, "mine.yaml"))


def test_no_note_is_given_on_weak_records_that_soil_can_amplify(tmp_path: Path) -> None:
    """The preflight check knows only the motion of the rock, not that at the surface of the soil."""
    row = "slight\tsynthetic\tsine amplitude_gal=90 period_s=1 azimuth_deg=40"
    layer = {"thickness_m": 20, "velocity_m_s": 150, "density_kg_m3": 1800}
    site = {"layers": [layer], "rock": {"velocity_m_s": 760}}
    for more in ({"site": site}, {"variants": {"soil": {"site": site}}}):
        assert (
            preflight_notes_on_records(
                write_record_table_and_make_study(tmp_path, row, b_over_h=[0.1, 0.4], friction=[0.5], **more)
            )
            == ()
        )


SOIL_SITE_SETTINGS = {"layers": [{"thickness_m": 20, "velocity_m_s": 150}], "rock": {"velocity_m_s": 760}}
"""20 m of soil over rock: a motion goes through it by pystrata, an optional package."""


@pytest.mark.parametrize("key", ["site", "variants.soil: site"])
def test_study_check_finds_that_the_package_for_soil_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, key: str
) -> None:
    """None in sys.modules makes the import fail, as if pystrata were not installed."""
    monkeypatch.setitem(sys.modules, "pystrata", None)
    pulse = {"use": [], "pulses": {"p1": "sine amplitude_gal=300 period_s=1 azimuth_deg=60"}}
    site = (
        {"site": SOIL_SITE_SETTINGS}
        if key == "site"
        else {"variants": {"soil": {"site": SOIL_SITE_SETTINGS}, "flat": {"vertical": False}}}
    )
    (tmp_path / "mine.yaml").write_text(json.dumps({"name": "mine", "records": pulse} | site), encoding="utf-8")
    (line,) = run_overturning_and_return_printed_text("study", "check", tmp_path / "mine.yaml", status=1).splitlines()
    assert line.startswith(f"error: {tmp_path / 'mine.yaml'}: {key}: soil layers need pystrata")
    assert "python -m pip install 'overturning[soil]'" in line


def test_the_import_of_the_package_for_soil_prints_no_warnings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recwarn: pytest.WarningsRecorder
) -> None:
    """From Python 3.12, pystrata's source gives syntax warnings, until its compiled form is stored."""
    (tmp_path / "pystrata.py").write_text("doubtful = 1 is 1\n", encoding="utf-8")
    monkeypatch.setitem(sys.modules, "pystrata", None)
    del sys.modules["pystrata"]
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    assert import_pystrata().doubtful
    assert recwarn.list == []


def test_study_check_finds_an_unknown_soil_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pystrata, which defines the names of soil curves, is replaced by a stub that knows two of them."""
    curves = SimpleNamespace(known_published_curves=lambda: ["kishida", "idriss_sand"])
    monkeypatch.setitem(sys.modules, "pystrata", SimpleNamespace(site=curves))
    layers = [*SOIL_SITE_SETTINGS["layers"], {"thickness_m": 5, "velocity_m_s": 150, "curve": "idris"}]
    check_soil_curve_package(study_of_record("rinaldi", site=SOIL_SITE_SETTINGS | {"layers": layers[:1]}), "mine.yaml")
    with pytest.raises(ConfigError, match=re.escape("mine.yaml: site: curve 'idris'; known are idriss_sand, kishida")):
        check_soil_curve_package(study_of_record("rinaldi", site=SOIL_SITE_SETTINGS | {"layers": layers}), "mine.yaml")


@pytest.mark.parametrize(
    ("records", "answer"),
    [
        ([(None, None)], False),
        ([(30.0, None)], True),
        ([(None, True), (30.0, None)], True),
        ([(None, True), (30.0, False)], False),
        ([(30.0, True), (None, False)], True),
        ([(None, True), (None, False), (30.0, None)], False),
    ],
)
def test_fault_alignment_needs_the_strike_of_a_pulse_record_if_pulses_are_distinguished(
    records: list[tuple[float | None, bool | None]], answer: bool
) -> None:
    """Fault strikes count only for records with a pulse if there are records with and without a pulse.

    The records that count are the first group of `record_masks_by_group`.
    """
    entries = [
        RecordTableRow(id="a", source="a.V2A", fault_strike_deg=strike, pulse=pulse) for strike, pulse in records
    ]
    assert can_compute_fault_alignment(entries) is answer
    pulses = np.array([np.nan if pulse is None else float(pulse) for _, pulse in records])
    first = next(iter(record_masks_by_group(xr.Dataset(coords={"pulse": ("record", pulses)})).values()))
    assert answer == any(strike is not None for (strike, _), one in zip(records, first, strict=True) if one)


def test_a_study_without_soil_needs_no_optional_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pystrata", None)
    check_soil_curve_package(study_of_record("rinaldi"), "mine.yaml")


def test_a_study_that_is_too_large_is_refused_with_its_size() -> None:
    fine = {"start": 0.001, "stop": 10, "step": 0.001}
    with pytest.raises(
        ConfigError, match=r"mine\.yaml: 1 record × 7,200,000,000 cases = .* of processor time, .* of memory"
    ):
        estimate_and_check_study_size(study_of_record("rinaldi", b_over_h=fine, friction=fine), "mine.yaml")


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"simulation": {"scheme": "euler"}}, "study 'mine': simulation.scheme: 'euler'; known: cundall, centred"),
        ({"simulation": {"time_step": 1.0}}, "study 'mine': simulation.time_step: 1 s is not stable; at most"),
        ({"contact": {"stiffness": 1e20}}, "study 'mine': contact.stiffness: static penetration"),
        (
            {"variants": {"stiff": {"contact": {"stiffness": 1e20}}}},
            "study 'mine': variants.stiff.contact.stiffness: static",
        ),
        (
            {"b_over_h": [0.05, 0.4], "ensemble": {"initial_tilt": 0.1}},
            "study 'mine': ensemble.initial_tilt: the block would",
        ),
    ],
)
def test_unusable_simulation_settings_are_refused_before_the_run(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=re.escape(message)):
        preflight_notes_on_records(study_of_record("wtmc", **keys))


def test_the_estimated_run_time_is_within_a_factor_of_two_of_the_stored_measurement() -> None:
    measured = pd.read_csv(ROOT / "verification/results/x86-64-2-cores.csv").set_index("quantity")["value"]
    processor_s = float(measured["default study, whole run: processor time"])
    assert (
        0.5
        < estimate_cases_time_memory_and_disk_of_study(
            load_study(ROOT / "config/near-fault.yaml")
        ).total_processor_time_s
        / processor_s
        < 2
    )
    small = estimate_cases_time_memory_and_disk_of_study(study_of_record("wtmc"))
    assert 10 < small.total_processor_time_s < 100, "most of it is no case"
    assert 1e6 < small.results_disk_bytes < 5e6, "the report alone is half a megabyte"


def test_the_memory_estimate_includes_the_outcomes_of_ensemble_members() -> None:
    """The memory of the largest job includes a flag of 1 byte and an azimuth of 8 bytes per case and member."""
    without, with_members = (
        estimate_cases_time_memory_and_disk_of_study(
            study_of_record("rinaldi", ensemble={"members": n}), chunks_per_record=4
        )
        for n in (0, 24)
    )
    assert (
        with_members.largest_job_memory_bytes - without.largest_job_memory_bytes
        >= 9 * 24 * with_members.cases_per_record / 4
    )


@pytest.mark.parametrize(("step", "size"), [(360, "1 record × 1 case = 1; "), (180, "1 record × 2 cases = 2; ")])
def test_the_printed_size_of_a_study_uses_singular_and_plural_correctly(step: int, size: str) -> None:
    one = study_of_record("rinaldi", azimuth={"step": step}, b_over_h=[0.3], height=[0.6], friction=[0.58])
    assert str(estimate_cases_time_memory_and_disk_of_study(one)).startswith(size)


def test_a_study_of_pulses_needs_no_record_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    study = tmp_path / "pulse.yaml"
    study.write_text('name: pulse\nrecords: {pulses: {p1: "sine amplitude_gal=300 period_s=1 azimuth_deg=60"}}\n')
    assert "study 'pulse', 1 record × 216 cases = 216; about " in run_overturning_and_return_printed_text(
        "study", "check", study
    )


def test_a_record_table_separated_by_commas_is_refused(tmp_path: Path) -> None:
    study = write_record_table_and_make_study(tmp_path, "one\tauto\tone.csv")
    (tmp_path / "records.tsv").write_text("id,format\none,auto\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"line 1: columns are separated by commas; use tabs"):
        find_record_rows_and_files(study, "mine.yaml")
