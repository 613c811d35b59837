"""A whole small study: same bytes, resumed after a kill, computed again only where something changed."""

import json
import os
import shlex
import shutil
import time
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from overturning.cli import main
from overturning.study.cube import open_cube
from overturning.study.load import load_study_from_file_or_json
from overturning.study.resume import END_CHECKED_FILE_PATTERNS, FILE_END_BYTES_BY_SUFFIX
from overturning.study.scenes import variant_grid
from overturning.study.sources import package_source_hash
from tests.expect import skip_test_unless_skipping_is_forbidden
from tests.workflow.conftest import StudyWorkflowCopyWithPlanning, reproducible_result_file_contents
from verification.scale.same_bytes import simulate_study_without_snakemake
from verification.tables import ROOT

# make test keeps the tests of a file in one process: these share a finished study.
pytestmark = pytest.mark.workflow


def research_crate_entities_by_id(study: StudyWorkflowCopyWithPlanning) -> dict[str, dict[str, object]]:
    """The entities of a study's research crate, by id."""
    text = (study.results / "ro-crate-metadata.json").read_text(encoding="utf-8")
    return {one["@id"]: one for one in json.loads(text)["@graph"]}


def test_the_research_crate_lists_all_results_with_their_hashes(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning,
) -> None:
    """Partial results, logs, run times and the crate's own metadata file are not listed."""
    crate = research_crate_entities_by_id(checkout_with_finished_run)
    made = {
        name: sha256(content).hexdigest()
        for name, content in reproducible_result_file_contents(checkout_with_finished_run.results).items()
    }
    assert {name: one["sha256"] for name, one in crate.items() if one["@type"] == "File"} == {
        name: digest for name, digest in made.items() if name != "ro-crate-metadata.json"
    }
    assert {"#record-rinaldi", "#record-petrolia", "study.yaml", "cube.nc", "motion/rinaldi.nc"} <= crate.keys()


def test_results_contain_no_time_host_name_or_path(checkout_with_finished_run: StudyWorkflowCopyWithPlanning) -> None:
    report = (checkout_with_finished_run.results / "report.html").read_text(encoding="utf-8")
    with open_cube(checkout_with_finished_run.results / "cube.nc") as cube:
        text = report + repr(dict(cube.attrs))
    # Its day is that of the version, which may be today.
    text += json.dumps(
        [one | {"datePublished": ""} for one in research_crate_entities_by_id(checkout_with_finished_run).values()]
    )
    for word in (
        str(checkout_with_finished_run.folder),
        os.uname().nodename + " ",
        time.strftime("%Y-%m-%d"),
        time.strftime("%H:%M"),
    ):
        assert word not in text, word


def test_the_findings_command_prints_the_stored_findings(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["findings", str(checkout_with_finished_run.results / "cube.nc"), "--json"])
    assert capsys.readouterr().out == (checkout_with_finished_run.results / "findings.json").read_text(encoding="utf-8")


def test_time_and_memory_of_each_job_are_stored(checkout_with_finished_run: StudyWorkflowCopyWithPlanning) -> None:
    benchmarks = checkout_with_finished_run.results / "benchmarks"
    names = {path.relative_to(benchmarks).as_posix() for path in benchmarks.rglob("*.tsv")}
    jobs = {"members", "rotate", "describe/motions"} | RULES_AFTER_SWEEP - {"record_figures_1", "all"}
    of_records = {f"{job}/{record}" for job in ("read", "sweep/nominal") for record in ("rinaldi", "petrolia")}
    of_records |= {"record_figures/record_figures_1"}
    assert {name.partition(".")[0] for name in names} == jobs | of_records | {"steps"}
    head, row = (benchmarks / "report.tsv").read_text(encoding="utf-8").splitlines()
    assert float(dict(zip(head.split("\t"), row.split("\t"), strict=True))["s"]) > 0


SOIL = {"layers": [{"thickness_m": 20, "velocity_m_s": 200}], "rock": {"velocity_m_s": 760}}

FIGURE_RULES = {"record_figures_1", "figures", "illustrative"}
LAST_RULES = {"report", "crate", "all"}
RULES_AFTER_SWEEP = FIGURE_RULES | {"gather", "convergence", "explore", "fragility", "findings"} | LAST_RULES


@pytest.mark.parametrize(
    ("change", "again"),
    [
        ({}, set()),
        ({"friction": [0.5]}, {"sweep"} | RULES_AFTER_SWEEP),
        ({"amplitude": [1, 2]}, {"sweep"} | RULES_AFTER_SWEEP),
        (
            {"site": SOIL},
            {"read", "describe", "rotate", "sweep"} | RULES_AFTER_SWEEP,
        ),
        ({"title": "Other", "question": "Where?"}, {"explore", "findings", *LAST_RULES}),
        ({"primary": {"statistic": "fall_rate"}, "population": {"stones": 32}}, {"fragility", "findings", *LAST_RULES}),
        ({"processing": [{"step": "remove_mean"}]}, {"read", "describe", "rotate", "sweep"} | RULES_AFTER_SWEEP),
        ({"verification": "none"}, RULES_AFTER_SWEEP - {"convergence"}),
        (
            {"surveys": [{"stones": "config/stones.csv", "record": "rinaldi"}]},
            {"survey", "backwards", "findings", *LAST_RULES},
        ),
        (
            {"surveys": [{"stones": "config/stones.csv", "record": "rinaldi", "backwards": False}]},
            {"survey", "findings", *LAST_RULES},
        ),
        (
            {"surveys": [{"stones": "config/stones.csv", "record": "rinaldi", "site": SOIL, "backwards": False}]},
            {"cemetery_surface", "describe_cemetery", "sweep", "gather", "survey", "findings", *LAST_RULES},
        ),
        ({"figures": {"dpi": 100}}, {"record_figures_1", "figures", *LAST_RULES}),
        ({"figures": {"formats": ["pdf"]}}, {"record_figures_1", "figures", *LAST_RULES}),
        ({"figures": {"friction": 1.0}}, {"record_figures_1", "figures", "explore", "findings", *LAST_RULES}),
    ],
    ids=lambda value: next(iter(value), "nothing") if isinstance(value, dict) else None,
)
def test_changing_a_study_key_reruns_only_dependent_steps(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning, change: dict[str, object], again: set[str]
) -> None:
    if "cemetery_surface" in again and find_spec("pystrata") is None:
        skip_test_unless_skipping_is_forbidden("pystrata is not installed (`make soil`)")
    (checkout_with_finished_run.folder / "config" / "stones.csv").write_text("octant\nSE\n", encoding="utf-8")
    assert checkout_with_finished_run.planned_rules(**change) == again


@pytest.mark.parametrize(
    ("column", "value", "again"),
    [
        ("event", "Another name 1994", {"describe", "rotate"} | RULES_AFTER_SWEEP),
        ("station", "Another name", {"describe", "rotate"} | RULES_AFTER_SWEEP),
        ("fault_strike_deg", "10", {"describe", "rotate"} | RULES_AFTER_SWEEP),
        ("orientation_correction_deg", "5", {"read", "describe", "rotate", "sweep"} | RULES_AFTER_SWEEP),
    ],
)
def test_changing_a_column_of_the_record_table_reruns_only_dependent_steps(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning, column: str, value: str, again: set[str]
) -> None:
    """Names and the fault strike do not change the samples of a record.

    A correction of the sensor azimuth rotates them, so that reading and simulation are repeated.
    """
    table = checkout_with_finished_run.folder / "config" / "records.tsv"
    text = table.read_text(encoding="utf-8")
    lines = [line.split("\t") for line in text.splitlines()]
    head = next(line for line in lines if line[0] == "id")
    for line in lines:
        if line[0] == "id" and column not in head:
            line.append(column)
        elif line[0] == "rinaldi":
            line.extend([""] * (len(head) - len(line)))
            line[head.index(column)] = value
    table.write_text("".join("\t".join(line) + "\n" for line in lines), encoding="utf-8")
    try:
        assert checkout_with_finished_run.planned_rules() == again
    finally:
        table.write_text(text, encoding="utf-8")


@pytest.fixture(scope="module")
def copied_sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package's sources, which tests may change."""
    folder = tmp_path_factory.mktemp("sources") / "overturning"
    return Path(shutil.copytree(ROOT / "src" / "overturning", folder, ignore=shutil.ignore_patterns("__pycache__")))


@pytest.mark.parametrize(
    ("module", "again"),
    [
        ("", set()),
        ("figures/study.py", {"record_figures_1", "figures", "illustrative", "explore", *LAST_RULES}),
        ("dem/kernel/queue.py", {"members", "sweep"} | RULES_AFTER_SWEEP),
        ("report/page.py", LAST_RULES),
    ],
)
def test_changing_a_source_file_reruns_dependent_steps(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning,
    copied_sources: Path,
    module: str,
    again: set[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("overturning.study.sources.PACKAGE_FOLDER", copied_sources)
    package_source_hash.cache_clear()
    path = copied_sources / (module or "errors.py")
    text = path.read_text(encoding="utf-8")
    path.write_text(text + ("\n# changed\n" if module else ""), encoding="utf-8")
    try:
        assert checkout_with_finished_run.planned_rules() == again
    finally:
        path.write_text(text, encoding="utf-8")
        package_source_hash.cache_clear()


@pytest.mark.parametrize(
    ("name", "again"),
    [
        ("figures/rose.svg", {"figures", *LAST_RULES}),
        ("figures/intensity/rinaldi.svg", {"record_figures_1", *LAST_RULES}),
        ("report.pdf", LAST_RULES),
        ("intensity.nc", {"rotate", "fragility", "record_figures_1", "figures", "findings", *LAST_RULES}),
        ("convergence.json", {"convergence", "findings", *LAST_RULES}),
        ("fragility/fragility-pga.xml", {"fragility", "findings", *LAST_RULES}),
        ("motion/rinaldi.nc", {"describe", "rotate"} | RULES_AFTER_SWEEP),
        ("members.csv", {"members", "sweep"} | RULES_AFTER_SWEEP),
    ],
)
def test_a_deleted_result_is_made_again(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning, tmp_path: Path, name: str, again: set[str]
) -> None:
    path = checkout_with_finished_run.results / name
    kept = path.rename(tmp_path / path.name)
    try:
        assert checkout_with_finished_run.planned_rules() == again
    finally:
        kept.rename(path)


def test_every_page_figure_and_table_is_checked_for_truncation(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning,
) -> None:
    """The file patterns name each kind of figure, so that files of the user are not checked.

    Every figure, page and table of a run must match a pattern.
    """
    looked_at = {
        path for pattern in END_CHECKED_FILE_PATTERNS for path in checkout_with_finished_run.results.glob(pattern)
    }
    written = {
        path for path in checkout_with_finished_run.results.rglob("*") if path.suffix in FILE_END_BYTES_BY_SUFFIX
    }
    assert {path.relative_to(checkout_with_finished_run.results).as_posix() for path in written - looked_at} == {
        "convergence.json"
    }


def test_only_added_records_are_simulated(checkout_with_finished_run: StudyWorkflowCopyWithPlanning) -> None:
    use = ["rinaldi", "petrolia", "sylmar", "tcu065", "izmit", "duzce", "erzincan", "lucerne", "sturno", "tcu102"]
    plan = checkout_with_finished_run.plan(records={"use": use})
    swept = {line.partition(" --motion ")[2].split()[0] for line in plan.commands if "overturning sweep " in line}
    assert swept == {f"results/small/read/{name}.nc" for name in use[2:]}
    assert "members" not in plan.rules
    of_records = [line for line in plan.commands if line.startswith("overturning record-figures")]
    drawn = sorted(
        (json.loads(shlex.split(line)[3])["records"]["use"] for line in of_records), key=lambda one: use.index(one[0])
    )
    assert drawn == [use[:4], use[4:8], use[8:]]
    assert not any("cube.nc" in line for line in of_records)


def test_only_an_added_variant_is_simulated(checkout_with_finished_run: StudyWorkflowCopyWithPlanning) -> None:
    """The input of a job depends only on its own variant, so that adding another variant repeats no simulation."""
    soft = {"soft": {"contact": {"damping_ratio": 1}}}
    one, two = (checkout_with_finished_run.plan(variants=soft | more) for more in ({}, {"flat": {"vertical": False}}))
    swept = [{line for line in plan.commands if "overturning sweep " in line} for plan in (one, two)]
    assert {line.partition(" --variant ")[2].split()[0] for line in swept[0]} == {"soft"}
    assert swept[0] < swept[1]
    assert {line.partition(" --variant ")[2].split()[0] for line in swept[1] - swept[0]} == {"flat"}
    cube = next(line for line in one.commands if "overturning gather " in line and "/cube.nc" in line)
    assert "damping_ratio" in cube, "the cube states all variants of its study"


def test_removing_a_record_from_a_study_removes_its_files(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning, tmp_path: Path
) -> None:
    checkout = checkout_with_finished_run.copy_to(tmp_path / "checkout")
    before = {str(path.relative_to(checkout.results)) for path in checkout.results.rglob("*") if path.is_file()}
    of_record = {name for name in before if "petrolia" in name}
    assert {"read/petrolia.nc", "motion/petrolia.nc", "figures/polar/petrolia.svg"} < of_record
    checkout.planned_rules(records={"use": ["rinaldi"]})
    assert (checkout.results / "motion" / "petrolia.nc").is_file(), "a dry run removes nothing"
    plan = checkout.plan(dry_run=False, records={"use": ["rinaldi"]})
    after = {str(path.relative_to(checkout.results)) for path in checkout.results.rglob("*") if path.is_file()}
    assert before - after == of_record
    assert f"record petrolia is no longer in the study: removed its {len(of_record)} files" in plan.warnings
    assert not plan.rules & {"read", "sweep"}


def test_results_that_the_settings_no_longer_produce_are_removed(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning, tmp_path: Path
) -> None:
    """Results of former settings are removed before the first step runs; files that the user has added stay."""
    checkout = checkout_with_finished_run.copy_to(tmp_path / "checkout")
    own = [checkout.results / name for name in ("fragility/notes.csv", "figures/mine.svg")]
    for path in own:
        path.write_text("<svg></svg>", encoding="utf-8")
    curves = ("curves.json", "fragility.csv", "fragility-pga.xml", "fragility-pgv.xml")
    gone = {"convergence.json", *(f"fragility/{name}" for name in curves)}
    assert all((checkout.results / name).is_file() for name in gone)
    file = checkout.folder / checkout.file
    text = file.read_text(encoding="utf-8").partition("population")[0]
    file.write_text(f"{text}verification: none\n", encoding="utf-8")
    done = checkout.run("--until", "gather", result_file_name="")
    assert done.returncode == 0, done.stderr
    assert {line for line in done.stderr.splitlines() if line.endswith("of the study: removed")} == {
        f"results/small/{name} is not made with the present settings of the study: removed" for name in gone
    }
    assert not any((checkout.results / name).exists() for name in gone)
    assert all(path.is_file() for path in own)


def test_a_new_title_reruns_only_explorer_findings_report_and_crate(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning, tmp_path: Path
) -> None:
    """A new title reruns only the steps of the explorer page, the findings, the report and the crate.

    A missing figure of an illustrative case is planned again, too, although Snakemake does not know the number of
    these cases in advance.
    """
    checkout = checkout_with_finished_run.copy_to(tmp_path / "checkout")
    before = reproducible_result_file_contents(checkout.results)
    gone = next((checkout.results / "figures" / "illustrative").glob("*.svg"))
    kept = gone.rename(tmp_path / gone.name)
    plan = checkout.plan(dry_run=False, title="Another title")
    kept.rename(gone)
    assert plan.rules == {"illustrative", "explore", "findings", *LAST_RULES}
    assert f"{gone.relative_to(checkout.folder)}" in plan.warnings, "it is said"
    steps = ("overturning findings", "overturning report")
    checkout.execute_steps_in_this_process([command for command in plan.commands if command.startswith(steps)])
    after = reproducible_result_file_contents(checkout.results)
    assert {name for name in after if after[name] != before[name]} == {"findings.json", "report.html", "report.pdf"}
    assert b"Another title" in after["report.html"]


def test_a_run_without_snakemake_gives_a_cube_with_the_same_bytes(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning, tmp_path: Path
) -> None:
    run = simulate_study_without_snakemake(checkout_with_finished_run.copy_to(tmp_path / "checkout"), "whole")
    assert run.sha256_of_result == sha256(checkout_with_finished_run.cube_path.read_bytes()).hexdigest()
    assert len(list(checkout_with_finished_run.results.glob("sweep/*/*.nc"))) == 4, "the default profile keeps parts"


def test_the_cube_has_the_grid_that_the_study_asks_for(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning,
) -> None:
    with open_cube(checkout_with_finished_run.results / "cube.nc", chunks={"record": 1}) as cube:
        assert cube["overturned"].chunks is not None
        assert dict(cube.sizes) == {"record": 2, "azimuth": 13, "height": 1, "b_over_h": 2, "friction": 2}
        assert 32 in cube["azimuth"]
        overturned = cube.set_index(record="record_id")["overturned"].sel(b_over_h=0.4, friction=1.0, height=0.6).load()
        # Rinaldi's fault-normal component overturns B/H = 0.4, and at N32E that is all there is.
        assert abs(float(overturned.sel(record="rinaldi", azimuth=32))) == 1
        assert np.isfinite(overturned).all()


def test_settings_too_long_for_a_command_line_are_passed_in_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Linux limits the line of a shell command to 128 KiB."""
    also = [round(0.01 * number, 2) for number in range(1, 18000)]
    checkout = StudyWorkflowCopyWithPlanning(tmp_path / "checkout")
    plan = checkout.plan(azimuth={"step": 30, "also": also})
    assert 0 < max(map(len, plan.commands)) < 1 << 17
    monkeypatch.chdir(checkout.folder)
    (sweep,) = {line.split()[3] for line in plan.commands if line.startswith("overturning sweep") and "rinaldi" in line}
    assert set(also) <= set(variant_grid(load_study_from_file_or_json(sweep))["azimuth"].tolist())
