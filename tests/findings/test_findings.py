"""Findings: each number again from the cube by other means, as JSON, and as lines."""

import hashlib
import json
import math
import shutil
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jsonschema
import netCDF4
import numpy as np
import pytest
import xarray as xr
import yaml

import overturning
from overturning.cli import main
from overturning.commands.cube import FIGURE_KINDS_FROM_WHOLE_STUDY_RESULTS
from overturning.errors import ArgumentError
from overturning.figures.fall_rate import fragility_curves_figure
from overturning.findings.causes import logistic_fit_findings
from overturning.findings.collect import Findings, findings_schema
from overturning.findings.contrast import compare_study_with_variants
from overturning.findings.direction import fall_direction_findings
from overturning.findings.extent import choose_fall_maps_for_report, count_records_and_blocks_with_direction_range
from overturning.findings.lines import finding_text_lines
from overturning.findings.opening import open_study_results
from overturning.findings.processing import DRIFT_DOUBT_KIND, TRUSTED_CONTRADICTION_DOUBT_KIND
from overturning.findings.results import StudyResults
from overturning.findings.soil import population_fall_rates_by_soil_and_amplitude
from overturning.findings.study import (
    case_counts_and_overturned_shares,
    numerical_errors_and_software_versions,
    peaks_and_fall_directions_of_records,
)
from overturning.findings.values import Estimate
from overturning.model.variables import INT8_MISSING
from overturning.motion.soil import RockHalfSpace, SoilLayer
from overturning.records.site import SoilSite
from overturning.report.drawings import STUDY_FIGURES, draw_study_figure
from overturning.statistics.fragility import FittedFragilityCurve
from overturning.statistics.logistic import PREDICTOR_NAMES, LogisticFit
from overturning.study.cube import COMPLETE_STUDY_FILE_NAME, study_of_cube
from overturning.study.load import load_study_from_file_or_json, study_settings_with_file_names_for_absolute_paths
from overturning.study.sections import Variant
from overturning.study.sweep import cube_variables_of_study
from overturning.surveys.population import population_outcome_rates_by_record
from tests.report.tiny_studies import pulse_record, simulate_study_into_result_folder

DOCS_FOLDER = Path(__file__).parents[2] / "docs"


PROVENANCE_WITH_NOTES = {
    "declared": ["borehole sensor"],
    "trusted": ["peaks differ"],
    "notes": ["the vertical is left out"],
}


@pytest.fixture(scope="module")
def study_folder(make_folder_once: Callable[[str, Callable[[Path], object]], Path]) -> Path:
    """Return the result folder of a study of three records with a velocity pulse each: along 60°, 150° and 20°."""
    records = [
        pulse_record("one", 60, 6.0, fault_strike_deg=330.0, extra={"pulse": True}),
        pulse_record("two", 150, 6.6, fault_strike_deg=330.0, extra={"pulse": True}),
        pulse_record("three", 20, 5.0, fault_strike_deg=290.0, extra={"pulse": False} | PROVENANCE_WITH_NOTES),
    ]
    settings = {"drawn": False, "azimuth": {"step": 15}, "population": {"stones": 64}}
    return make_folder_once("findings", lambda place: simulate_study_into_result_folder(place, records, **settings))


@pytest.fixture(scope="module")
def study_findings(study_folder: Path) -> Findings:
    return overturning.findings(study_folder)


@pytest.fixture(scope="module")
def study_cube(study_folder: Path) -> xr.Dataset:
    with overturning.open_cube(study_folder / "cube.nc") as opened:
        return opened.load()


def test_overturned_shares_equal_counts_of_overturning_flags(study_findings: Findings, study_cube: xr.Dataset) -> None:
    flags = study_cube["overturned"].transpose("record", ...).to_numpy().reshape(3, -1)
    for record, own in zip(study_findings.records, flags, strict=True):
        assert record.share_overturned == pytest.approx(np.mean(own[np.isfinite(own)] != 0))
    assert study_findings.cases.total_cases == flags.size
    assert study_findings.cases.share_overturned == pytest.approx(np.mean(flags[np.isfinite(flags)] != 0))
    assert study_findings.cases.cases_not_copied_by_symmetry == flags.size / 2  # φ + 180° mirrors φ
    assert [record.has_velocity_pulse for record in study_findings.records] == [True, True, False]


def test_fall_axes_of_records_lie_along_their_velocity_pulses(study_findings: Findings) -> None:
    """Two pulses lie along and across one fault normal (60°), the third along the normal of its own fault (20°)."""
    pulse, control = study_findings.direction.groups
    along, across = (one.mean_cos_2_angle_to_fault_normal or math.nan for one in pulse.by_earthquake)
    assert along > 0.5  # falls spread about the axis
    assert across < -0.4
    assert pulse.mean_cos_2_angle_to_fault_normal.value == pytest.approx(
        np.mean([one.mean_cos_2_angle_to_fault_normal or math.nan for one in pulse.by_earthquake])
    )
    assert control.mean_cos_2_angle_to_fault_normal.value is not None
    assert control.mean_cos_2_angle_to_fault_normal.value > 0.5
    assert (
        pulse.mean_cos_2_angle_to_fault_normal.earthquake_count,
        control.mean_cos_2_angle_to_fault_normal.earthquake_count,
    ) == (2, 1)
    assert pulse.mean_cos_2_angle_to_fault_normal.low is None  # two earthquakes are too few for an interval
    assert not pulse.mean_cos_2_angle_to_fault_normal.excludes_zero
    np.testing.assert_allclose(
        [record.fall_axis_to_fault_normal_angle_deg for record in study_findings.records], [0.0, 90.0, 0.0], atol=2.0
    )
    difference = study_findings.direction.first_minus_second_group_alignment
    assert difference is not None
    assert difference.value == pytest.approx(
        (pulse.mean_cos_2_angle_to_fault_normal.value or 0.0) - control.mean_cos_2_angle_to_fault_normal.value
    )


def test_earthquakes_with_records_with_and_without_a_pulse_are_counted(study_folder: Path) -> None:
    """Only earthquake A has records both with and without a velocity pulse; B and C have one kind, D neither."""
    with open_study_results(study_folder) as opened:
        first = opened.reference_element_cube.isel(record=[0] * 6)
        events, pulses = list("AABCDA"), [1.0, 0.0, 1.0, 0.0, np.nan, 0.0]
        cube = first.assign_coords(event=("record", events), pulse=("record", pulses))
        extent = count_records_and_blocks_with_direction_range(replace(opened, reference_element_cube=cube))
    assert (extent.earthquakes_in_several_groups, extent.records) == (1, 6)


def test_peak_acceleration_and_velocity_are_those_of_the_motion(study_findings: Findings) -> None:
    for record, peak, towards in zip(study_findings.records, (6.0, 6.6, 5.0), (60.0, 150.0, 20.0), strict=True):
        assert record.pga_m_s2 == pytest.approx(peak, rel=0.03)
        assert record.pga_azimuth_deg is not None
        assert abs((record.pga_azimuth_deg - towards + 90.0) % 180.0 - 90.0) <= 7.5
        # A sine of period T has the peak velocity A T/π.
        assert record.pgv_m_s == pytest.approx(peak * 0.8 / math.pi, rel=0.05)


def test_notes_on_a_record_repeat_its_stored_provenance(study_findings: Findings) -> None:
    one, _, three = (record.processing for record in study_findings.records)
    assert one is not None
    assert three is not None
    assert (three.user_declared_properties, three.contradictions_trusted_by_user, three.notes) == tuple(
        PROVENANCE_WITH_NOTES.values()
    )
    assert one.user_declared_properties == one.contradictions_trusted_by_user == one.notes == []
    # The noise across the pulse leaves a velocity at the end.
    assert (one.doubts, three.doubts) == ([DRIFT_DOUBT_KIND], [DRIFT_DOUBT_KIND, TRUSTED_CONTRADICTION_DOUBT_KIND])
    assert "velocity of" in one.drift_evidence
    assert three.pga_before_m_s2 == three.pga_after_m_s2 == pytest.approx(5.0 * math.cos(math.radians(20.0)), rel=0.03)
    assert study_findings.record_notes.record_count_with_notes_or_doubts == 3
    named = {one.doubt: one.records for one in study_findings.record_notes.doubts}
    assert named == {DRIFT_DOUBT_KIND: ["one", "two", "three"], TRUSTED_CONTRADICTION_DOUBT_KIND: ["three"]}


def test_median_fall_rate_is_the_median_over_records(study_findings: Findings) -> None:
    assert study_findings.population is not None
    rates = [one.fall_rate for one in study_findings.population.by_record]
    assert study_findings.population.median_fall_rate == pytest.approx(np.median(np.array(rates, float)))
    assert study_findings.population.stones == 64


def test_json_follows_the_schema_and_holds_no_nan(study_findings: Findings) -> None:
    text, schema = study_findings.model_dump_json(), findings_schema()
    jsonschema.validate(json.loads(text, parse_constant=pytest.fail), json.loads(schema))
    assert (DOCS_FOLDER / "findings.schema.json").read_text(encoding="utf-8") == schema, (
        "run: overturning study document"
    )


def test_printed_findings_change_only_in_the_line_of_a_changed_number(study_findings: Findings) -> None:
    lines = list(finding_text_lines(study_findings))
    assert any(
        line.startswith("direction, groups, with a velocity pulse, mean cos 2 angle to fault normal: ")
        for line in lines
    )
    shares = {f"records, {one.id}, share overturned: {one.share_overturned:.4g}" for one in study_findings.records}
    assert shares <= set(lines), "the two records of one group are told apart"
    names = [line.partition(":")[0] for line in lines]
    assert sorted(set(names)) == sorted(names), "each name stands for one number"
    cases = study_findings.cases.model_copy(update={"share_overturned": 0.123})
    changed = list(finding_text_lines(study_findings.model_copy(update={"cases": cases})))
    assert [line for line in changed if line not in lines] == ["cases, share overturned: 0.123"]


@pytest.mark.parametrize(
    ("low", "high", "excludes"), [(0.1, 0.3, True), (-0.3, -0.1, True), (-0.1, 0.3, False), (math.nan, math.nan, False)]
)
def test_interval_excludes_zero_only_if_both_bounds_have_one_sign(low: float, high: float, excludes: bool) -> None:
    assert Estimate(statistic="", value=0.2, low=low, high=high, earthquake_count=9).excludes_zero is excludes


def run_command_line(*arguments: str) -> int:
    """Run the command line and return its exit status."""
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    return int(stop.value.code or 0)


def test_findings_command_prints_and_writes_all_findings(
    study_folder: Path, study_findings: Findings, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    everything = json.loads(study_findings.model_dump_json())
    assert run_command_line("findings", str(study_folder / "cube.nc"), "--json") == 0
    assert json.loads(capsys.readouterr().out) == everything
    assert run_command_line("findings", str(study_folder), "--output", str(tmp_path / "findings.json")) == 0
    assert json.loads((tmp_path / "findings.json").read_text(encoding="utf-8")) == everything


def test_findings_command_reads_the_study_file_next_to_the_cube(
    study_folder: Path, study_findings: Findings, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The cube of a run stores no question, primary statistic and population: study.yaml next to it has them."""
    for name in ("cube.nc", "intensity.nc"):
        shutil.copy(study_folder / name, tmp_path)
    with overturning.open_cube(tmp_path / "cube.nc") as opened:
        stored = study_of_cube(opened)
    changed = {"question": "Where to?", "primary": {"statistic": "fall_rate"}, "population": {"stones": 128}}
    settings = study_settings_with_file_names_for_absolute_paths(stored) | changed
    (tmp_path / COMPLETE_STUDY_FILE_NAME).write_text(yaml.safe_dump(settings), encoding="utf-8")
    output = tmp_path / "findings.json"
    assert run_command_line("findings", str(tmp_path / "cube.nc"), "--output", str(output)) == 0
    assert capsys.readouterr() == (f"{output}\n", "")
    written = json.loads(output.read_text(encoding="utf-8"))
    assert (written["study"]["question"], written["study"]["primary_statistic"]) == ("Where to?", "fall_rate")
    assert written["population"]["stones"] == 128
    assert written.keys() == json.loads(study_findings.model_dump_json()).keys()
    (tmp_path / COMPLETE_STUDY_FILE_NAME).write_text(yaml.safe_dump(settings | {"name": "other"}), encoding="utf-8")
    assert run_command_line("findings", str(tmp_path), "--output", str(output)) == 0
    warned = capsys.readouterr().err
    assert json.loads(output.read_text(encoding="utf-8"))["population"]["stones"] == 64, "that in the cube"
    assert "study.yaml is not of the study 'tiny': the findings are without the primary statistic, surveys;" in warned
    (tmp_path / COMPLETE_STUDY_FILE_NAME).unlink()
    missing = r"study\.yaml is missing: the findings are without the primary statistic, surveys;"
    with pytest.warns(UserWarning, match=missing):
        overturning.findings(tmp_path)


UNREADABLE_CUBE_FILES_AND_ERRORS: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "other.nc": (lambda _: b"", "no such cube"),
    "report.html": (lambda _: b"<!DOCTYPE html>", "cannot be opened"),
    "cut.nc": (lambda content: content[: len(content) // 2], "damaged|cannot be opened"),
    "intensity.nc": (lambda _: b"", "not a cube of this package"),
}


@pytest.mark.parametrize("name", UNREADABLE_CUBE_FILES_AND_ERRORS)
def test_error_names_a_file_that_is_no_cube_of_a_study(study_folder: Path, tmp_path: Path, name: str) -> None:
    """The error names the given file; an intact cube in the same folder is not read in its place."""
    change, message = UNREADABLE_CUBE_FILES_AND_ERRORS[name]
    for one in ("cube.nc", "intensity.nc"):
        shutil.copy(study_folder / one, tmp_path)
    if content := change((study_folder / "cube.nc").read_bytes()):
        (tmp_path / name).write_bytes(content)
    with pytest.raises(overturning.errors.ResultError, match=rf"/{name}: ({message})"):
        overturning.findings(tmp_path / name)


def test_findings_are_those_of_the_cube_file_that_is_named(
    study_folder: Path, study_findings: Findings, tmp_path: Path
) -> None:
    """Findings are read from the named cube, in which all blocks fall; cubes of a variant or a part are refused."""
    for name in ("cube.nc", "intensity.nc", COMPLETE_STUDY_FILE_NAME):
        shutil.copy(study_folder / name, tmp_path)
    with xr.open_dataset(study_folder / "cube.nc", decode_timedelta=False) as cube:
        cube.assign(overturned=xr.ones_like(cube["overturned"])).to_netcdf(tmp_path / "falls.nc")
        cube.assign_attrs(variant="flat").to_netcdf(tmp_path / "cube.flat.nc")
        cube.isel(record=[0, 2]).to_netcdf(tmp_path / "part.nc")
        cube.isel(azimuth=slice(1, None)).to_netcdf(tmp_path / "planes.nc")
    assert (study_findings.cases.share_overturned or 1.0) < 1.0
    assert overturning.findings(tmp_path / "falls.nc").cases.share_overturned == 1.0
    for name, message in (
        ("cube.flat.nc", "results of the variant 'flat'"), ("part.nc", "a part of"), ("planes.nc", "a part of")
    ):  # fmt: skip
        with pytest.raises(overturning.errors.ResultError, match=rf"/{name}: {message}"):
            overturning.findings(tmp_path / name)
    (tmp_path / "intensity.nc").unlink()
    with pytest.raises(overturning.errors.ResultError, match=r"intensity\.nc: no intensity measures"):
        overturning.findings(tmp_path / "falls.nc")


def test_missing_outcomes_at_other_amplitudes_are_counted(tmp_path: Path) -> None:
    """Cases of records scaled by 2 are counted apart; a third of them lacks outcomes if one of three B/H does."""
    record = pulse_record("one", 60, 6.0)
    made = simulate_study_into_result_folder(
        tmp_path, [record], drawn=False, amplitude=[1, 2], population={"stones": 64}
    )
    with overturning.open_cube(made / "cube.nc", amplitude=None) as opened:
        flags = opened["overturned"].sel(amplitude=2.0).to_numpy()
    with open_study_results(made) as results:
        cases = case_counts_and_overturned_shares(results)
    assert (cases.total_cases, cases.cases_at_other_amplitudes, cases.other_amplitude_cases_without_outcome) == (
        flags.size,
        flags.size,
        np.isnan(flags).sum(),
    )
    with xr.open_dataset(made / "cube.nc", decode_timedelta=False) as cube:
        lost = cube["overturned"].where((cube["amplitude"] == 1.0) | (cube["b_over_h"] > 0.25))
        cube.assign(overturned=lost).to_netcdf(made / "lost.nc")
    with pytest.warns(UserWarning, match=r"lost\.nc: its outcomes were changed after the run"):
        found = overturning.findings(made / "lost.nc")
    assert (found.cases.total_cases, found.cases.other_amplitude_cases_without_outcome) == (flags.size, flags.size / 3)
    assert found.population is not None
    assert found.population.max_share_of_stones_without_outcome == 0.0


def test_hash_in_findings_changes_only_if_the_outcomes_change(
    study_folder: Path, study_findings: Findings, tmp_path: Path
) -> None:
    """A cube saved again by another program has the hash of its run; a cube with changed outcomes has another hash."""
    shutil.copytree(study_folder, tmp_path / "results")
    path = tmp_path / "results" / "cube.nc"
    stated = study_findings.numerical_quality.results_cube_sha256
    with xr.open_dataset(path, decode_timedelta=False) as opened:
        cube = opened.load()
    cube.to_netcdf(path)
    with open_study_results(path) as results:
        assert (
            numerical_errors_and_software_versions(results).results_cube_sha256,
            results.names_of_cubes_changed_after_run,
        ) == (
            stated,
            (),
        )
    cube["overturned"][0] = 0
    cube.to_netcdf(path)
    with pytest.warns(UserWarning, match=r"cube\.nc: its outcomes were changed after the run"):
        changed = overturning.findings(path)
    by_hand = hashlib.sha256()
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        for variable in cube_variables_of_study(load_study_from_file_or_json(file.study)):
            by_hand.update(variable.name.encode() + file[variable.name][:].tobytes())
    assert changed.numerical_quality.results_cube_sha256 == by_hand.hexdigest() != stated
    assert changed.records[0].share_overturned == 0.0


def test_error_names_the_missing_results_file(tmp_path: Path) -> None:
    with pytest.raises(overturning.errors.ResultError, match=r"cube\.nc"):
        overturning.findings(tmp_path)


def test_blocks_that_fall_in_every_direction_or_in_none_have_no_axis(study_folder: Path) -> None:
    """If slender blocks fall in all planes and the others in none, no fall axis arises, not even by rounding errors."""
    with open_study_results(study_folder) as results:
        cube = results.reference_element_cube.load()
        slender = (cube["b_over_h"] < float(cube["b_over_h"].mean())).broadcast_like(cube["overturned"])
        towards = xr.where(slender, 1, 0).transpose(*cube["overturned"].dims).astype(np.int8)
        changed = cube.drop_vars([one for one in ("probability_towards", "probability_away") if one in cube])
        values = {name: getattr(results, name) for name in results.__dataclass_fields__}
        direction = fall_direction_findings(
            StudyResults(**values | {"reference_element_cube": changed.assign(overturned=towards)})
        )
        half = changed.assign(overturned=towards.where((cube["azimuth"] % 180) < 90, INT8_MISSING))
        found = StudyResults(**values | {"reference_element_cube": half})
        missing, extent = fall_direction_findings(found), count_records_and_blocks_with_direction_range(found)
    assert direction.reason_for_no_axis_comparable_with_fault == "every direction or none"
    assert not direction.has_fall_axis_comparable_with_fault
    assert (
        missing.reason_for_no_axis_comparable_with_fault == "unknown outcomes"
    )  # the axis would be that of the planes with outcomes, 45°
    assert extent.records_with_fall_axis_imposed_by_azimuths == cube["record_id"].to_numpy().tolist()


def test_records_without_falls_have_no_fall_direction(study_folder: Path) -> None:
    """A cube in which nothing falls: shares are 0, directions are not defined, and nothing fails."""
    with open_study_results(study_folder) as results:
        still = results.reference_element_cube.load().assign(
            overturned=xr.zeros_like(results.reference_element_cube["overturned"])
        )
        for name in ("probability_towards", "probability_away"):
            if name in still:
                still[name] = xr.zeros_like(still[name])
        changed = StudyResults(
            **{name: getattr(results, name) for name in results.__dataclass_fields__}
            | {"reference_element_cube": still}
        )
        direction = fall_direction_findings(changed)
    assert not direction.has_fall_axis_comparable_with_fault
    assert all(one.mean_cos_2_angle_to_fault_normal.value is None for one in direction.groups)


@pytest.mark.parametrize(
    ("planes", "reason"),
    [
        ([60, 75, 90], "uneven planes"),
        ([60, 75, 90, 240, 255, 270], "uneven planes"),
        ([60, 240], "one plane"),
    ],
)
def test_simulated_planes_in_one_sector_give_fall_shares_but_no_fall_axis(
    study_folder: Path, study_cube: xr.Dataset, planes: list[int], reason: str
) -> None:
    """Falls in planes of one sector lie in it whatever the motion, and so near any fault normal within the sector."""
    with open_study_results(study_folder) as results:
        values = {name: getattr(results, name) for name in results.__dataclass_fields__}
        sector = StudyResults(**values | {"reference_element_cube": results.reference_element_cube.sel(azimuth=planes)})
        direction, records, maps = (
            fall_direction_findings(sector),
            peaks_and_fall_directions_of_records(sector),
            choose_fall_maps_for_report(sector),
        )
    assert direction.reason_for_no_axis_comparable_with_fault == reason
    assert not direction.has_fall_axis_comparable_with_fault
    assert direction.first_minus_second_group_alignment is None
    for group in direction.groups:
        assert group.mean_cos_2_angle_to_fault_normal.value is None
        assert group.fall_axis_from_fault_normal_deg is None
        assert group.mean_axis_resultant_length_within_records.value is None
        assert all(rule.mean_cos_2_angle_to_fault_normal.value is None for rule in group.by_rule)
        assert all(one.fall_axis_from_fault_normal_deg is None for one in group.by_earthquake)
    for record in records:
        assert record.mean_fall_axis_deg is None
        assert record.mean_fall_direction_deg is None
        assert record.fall_axis_resultant is None
    assert all(one.mean_cos_2_angle_to_fault_normal is None for one in maps.records)
    expected = {}
    for plane in [60, 75, 90] if reason == "uneven planes" else []:
        flags = study_cube["overturned"].sel(azimuth=[one for one in planes if one % 180 == plane]).to_numpy()
        expected[plane] = np.mean(flags[np.isfinite(flags)] != 0)
    shares = {one.azimuth_deg: one.share_overturned for one in direction.overturned_shares_by_plane_azimuth}
    assert shares == pytest.approx(expected)


def logistic_fit_with_coefficients(coefficient: list[float], half_width: float, note: str = "") -> LogisticFit:
    """Return a logistic fit with coefficients (intercept, then `PREDICTOR_NAMES`) whose intervals are equally wide."""
    value, four = np.array(coefficient), np.zeros(4)
    width = np.full(5, half_width)
    return LogisticFit(
        ("intercept", *PREDICTOR_NAMES), value, width / 2, value - width, value + width, 99, 9, four, four, note
    )


@pytest.mark.parametrize(
    ("fit", "expected"),
    [
        # Doubling multiplies the odds by 2 to the power of the coefficient: 8 (4 to 16), and 1/4 (1/8 to 1/2).
        (
            logistic_fit_with_coefficients([0, 3, 0.9, 5, -2], 1),
            {"PGA and PGV": (8 / 9, 4 / 5, 16 / 17), "size of the block": (1 / 5, 1 / 9, 1 / 3)},
        ),
        # A wide interval that excludes 0 is an effect; all others of this fit are not.
        (
            logistic_fit_with_coefficients([0, 12, 2, -2, 1], 11),
            {"PGA and PGV": (1 - 1 / 4097, 2 / 3, 1 - 1 / (1 + 2**23))},
        ),
        (logistic_fit_with_coefficients([0, 3, 3, 3, 3], math.nan, "no interval: fewer than 8 earthquakes"), {}),
        (logistic_fit_with_coefficients([0, 3, 3, 3, 3], math.nan, "no fit: everything falls"), {}),
    ],
)
def test_effect_of_a_predictor_is_stated_only_if_its_interval_excludes_zero(
    fit: LogisticFit, expected: dict[str, tuple[float, float, float]]
) -> None:
    found = logistic_fit_findings(SimpleNamespace(logistic_fit=fit))
    assert found is not None
    chances = {
        one.doubled_quantity: (
            one.fall_probability_after_doubling_from_half,
            one.fall_probability_after_doubling_from_half_low,
            one.fall_probability_after_doubling_from_half_high,
        )
        for one in found.fall_probabilities_after_doubling
    }
    assert chances.keys() == expected.keys()
    for name, numbers in expected.items():
        assert chances[name] == pytest.approx(numbers)


@pytest.mark.parametrize(("planes", "angle"), [(slice(None), 0.0), ([60, 75, 90], None)])
def test_fall_axes_on_soil_and_rock_are_compared_only_if_all_planes_were_run(
    study_folder: Path, planes: "slice | list[int]", angle: float | None
) -> None:
    """Soil and rock have equal outcomes: axes of all planes differ by 0°; planes of one sector give no angle."""
    soil = SoilSite(layers=(SoilLayer(thickness_m=20, velocity_m_s=180),), rock=RockHalfSpace(velocity_m_s=760))
    with open_study_results(study_folder) as opened:
        cube = opened.reference_element_cube.sel(azimuth=planes)
        rates = population_outcome_rates_by_record(cube, opened.study.population)
        study = opened.study.model_copy(update={"variants": {"soft": Variant(site=soil)}})
        both = dict.fromkeys(("nominal", "soft"), (cube, rates))
        cubes, populations = ({name: pair[part] for name, pair in both.items()} for part in (0, 1))
        found = population_fall_rates_by_soil_and_amplitude(
            replace(
                opened,
                study=study,
                reference_element_cube=cube,
                cubes_by_variant=cubes,
                population_rates_by_variant=populations,
            )
        )
    (soft,) = (one for one in found if one.variant == "soft")
    assert soft.median_angle_to_fall_axis_without_soil_deg == angle
    assert (soft.records_with_fall_axis_with_and_without_soil > 0) is (angle is not None)


def test_study_and_variant_are_compared_where_both_have_an_outcome(study_folder: Path) -> None:
    """Outcomes are equal, but the study lacks those that stand at B/H 0.3, and the variant those that fall at 0.4."""
    with open_study_results(study_folder) as opened:
        whole = opened.reference_element_cube.isel(record=[0, 1], azimuth=slice(None, None, 4)).load()
        flags, shape = whole["overturned"], whole["b_over_h"]
        lost = [(flags == 0) & (shape == 0.3), (flags != 0) & (shape == 0.4)]
        cubes = {
            name: whole.assign(overturned=flags.where(~one))
            for name, one in zip(("nominal", "flat"), lost, strict=True)
        }
        study = opened.study.model_copy(update={"variants": {"flat": Variant(vertical=False)}})
        # Without vertical motion in the records, a variant in the vertical motion has no record to compare.
        cubes["nominal"] = cubes["nominal"].assign_coords(vertical=("record", [1, 1]))
        (found,) = compare_study_with_variants(
            replace(opened, study=study, reference_element_cube=cubes["nominal"], cubes_by_variant=cubes)
        )
    assert all(one.any() for one in lost)
    assert found.cases_not_compared == int((lost[0] | lost[1]).sum())
    fell = (flags != 0).where(~(lost[0] | lost[1]))
    share = fell.mean([name for name in flags.dims if name != "record"]).mean()  # each record is an earthquake
    for estimate in (found.share_overturned_in_study, found.share_overturned_in_variant):
        assert estimate.value == pytest.approx(float(share))
    assert [one.study_minus_variant_share.value for one in (found, *found.overturned_shares_by_b_over_h)] == [0.0] * 4
    assert found.primary_statistic_study_minus_variant.value == 0.0
    assert found.population_fall_rate_in_study is not None
    assert found.population_fall_rate_in_study == found.population_fall_rate_in_variant


def test_a_study_figure_is_refused_if_the_study_has_no_findings_for_it(
    study_findings: Findings, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert tuple(STUDY_FIGURES) == FIGURE_KINDS_FROM_WHOLE_STUDY_RESULTS
    opened: Any = SimpleNamespace(study=SimpleNamespace(name="tiny"))
    assert [len(STUDY_FIGURES[kind](opened, study_findings)) for kind in ("fragility", "fall-rate", "surveys")] == [
        1,
        1,
        0,
    ]
    monkeypatch.setattr("overturning.report.drawings.open_study_results", lambda _: nullcontext(opened))
    monkeypatch.setattr("overturning.report.drawings.findings_from_results", lambda _: study_findings)
    with pytest.raises(ArgumentError, match="surveys: the study tiny has no such figure; it needs a 2-D study with"):
        draw_study_figure("surveys", Path("cube.nc"))


def test_each_fragility_panel_shows_the_points_and_the_lognormal_curve() -> None:
    """The curve is a lognormal distribution: 50 % at the median, 84 % at exp(spread) times the median."""
    curves = [
        FittedFragilityCurve("all stones", "PGA", "g", 0.4, 0.5, (0.3, 0.5), 0.1, 1.6),
        FittedFragilityCurve("all stones", "PGV", "cm/s", 50.0, 0.25, (40.0, 60.0), 10.0, 100.0),
    ]
    rates, levels = np.array([[0.1, np.nan], [0.7, 1.0]]), np.array([[0.2, 0.3], [0.6, 0.9]])
    figure = fragility_curves_figure(rates, {"PGV": 100 * levels, "PGA": levels}, curves)
    for axes, curve, factor in zip(figure.axes, curves, (1, 100), strict=True):
        points, line = axes.lines
        np.testing.assert_allclose(points.get_xydata(), np.c_[factor * levels.ravel(), 100 * rates.ravel()])
        for sigma, share in ((0, 50.0), (1, 84.134)):
            x = curve.median * math.exp(sigma * curve.spread)
            assert np.interp(x, *line.get_data()) == pytest.approx(share, abs=0.1)
