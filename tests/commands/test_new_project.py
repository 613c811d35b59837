"""Use of the wheel without the repository: a film in any folder, a new project, own records and studies."""

import json
import os
import re
import shlex
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.expect import run_overturning_and_return_printed_text

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def unpacked_wheel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return the folder into which the wheel was unpacked; the wheel was built here, without network."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (built,) = folder.glob("*.whl")
    assert len(list(folder.glob("*.tar.gz"))) == 1
    with zipfile.ZipFile(built) as file:
        file.extractall(folder / "site")
    return folder / "site"


COMMAND_RUNNER_SCRIPT = """
import json, os, runpy, sys
import overturning, snakemake_logger_plugin_overturning
from overturning.cli import main
print(overturning.__file__, snakemake_logger_plugin_overturning.__file__, sep="\\n")
for folder, (program, *words) in json.loads(sys.argv[1]):
    for stream in (sys.stdout, sys.stderr):
        print("\\f", end="", file=stream, flush=True)
    os.chdir(folder)
    try:
        if program == "overturning":
            main(words)
        else:
            sys.argv = [program, *words]
            runpy.run_module(program, run_name="__main__", alter_sys=True)
    except SystemExit as end:
        print(f"status {end.code or 0}" + ", with dask.array" * ("dask.array" in sys.modules))
"""


@pytest.fixture(scope="module")
def folder_and_outputs_of_wheel_commands(
    unpacked_wheel: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, list[tuple[str, str]]]:
    """Return the folder in which commands of the unpacked wheel ran, and (standard output, standard error) of each.

    One process runs all commands, as the imports of a process take longer than a command.
    """
    folder = tmp_path_factory.mktemp("commands")
    project = folder / "mine"
    study = "--configfile config/mine.yaml"
    commands = (
        (folder, "overturning --version"),
        (folder, "overturning one --record rinaldi --azimuth 32 --animate fall.html"),
        (folder, "overturning init mine"),
        (project, "overturning study check config/mine.yaml"),
        (folder, "overturning init mine"),
        (project, f"snakemake --cores 1 {study} --dry-run --quiet host"),
    )
    listed = json.dumps([(str(place), shlex.split(words)) for place, words in commands])
    paths = os.pathsep.join([str(unpacked_wheel), os.environ.get("XDG_DATA_HOME", "")]).rstrip(os.pathsep)
    done = subprocess.run(
        [sys.executable, "-c", COMMAND_RUNNER_SCRIPT, listed],
        cwd=folder, env=os.environ | {"PYTHONPATH": paths}, capture_output=True, text=True, check=True, timeout=300,
    )  # fmt: skip
    (where, *outputs), (warned, *errors) = (text.split("\f") for text in (done.stdout, done.stderr))
    assert all(path.startswith(str(unpacked_wheel)) for path in where.split()), where
    assert not warned
    return folder, list(zip(outputs, errors, strict=True))


def test_the_cd_command_printed_by_init_leads_into_the_project(tmp_path: Path) -> None:
    go = run_overturning_and_return_printed_text("init", tmp_path / "my stones").splitlines()[1]
    done = subprocess.run(["sh", "-c", f"{go} && ls"], capture_output=True, text=True, check=True)
    assert "config" in done.stdout


@pytest.mark.parametrize(("folder", "name"), [("mine", "mine"), ("My stones, 2nd", "my-stones-2nd"), ("墓石", "study")])
def test_a_new_study_is_named_after_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: str, name: str
) -> None:
    text = run_overturning_and_return_printed_text("init", tmp_path / folder)
    assert [path.name for path in (tmp_path / folder / "config").glob("*.yaml")] == [f"{name}.yaml"]
    assert f"snakemake --cores 2 --configfile config/{name}.yaml" in text
    monkeypatch.chdir(tmp_path / folder)
    checked = run_overturning_and_return_printed_text("study", "check", f"config/{name}.yaml")
    assert f"study '{name}', 2 records × " in checked
    assert "no answer" not in checked


def test_the_readme_of_a_new_project_names_existing_files(tmp_path: Path) -> None:
    run_overturning_and_return_printed_text("init", tmp_path / "mine")
    readme = tmp_path / "mine" / "config" / "README.md"
    text = readme.read_text(encoding="utf-8")
    links = re.findall(r"\[[^]]*\]\(([^)]+)\)", text)
    assert [link for link in links if not (readme.parent / link.partition("#")[0]).exists()] == []
    named = set(re.findall(r"`([a-z-]+\.(?:yaml|tsv|json))`", text)) - {"study.yaml"}
    assert [name for name in named if not (readme.parent / name).is_file()] == []
    assert "repository -->" not in text
    assert "| `b_over_h` |" in text, "the tables of keys and columns are whole"
    assert "docs/formats.md describes the formats of records." in text


def test_the_wheel_runs_and_contains_project_files_records_and_licence(
    unpacked_wheel: Path, folder_and_outputs_of_wheel_commands: tuple[Path, list[tuple[str, str]]]
) -> None:
    folder, ((version, _), (one, _), *_) = folder_and_outputs_of_wheel_commands
    assert version.startswith("overturning 0.")
    assert "falls towards S32°W" in one
    assert version.endswith("status 0\n")
    assert one.endswith("status 0\n"), "and without dask.array, whose import takes longer than the command"
    assert (folder / "fall.html").stat().st_size > 10_000
    project = unpacked_wheel / "overturning" / "project"
    for part in (
        "Snakefile",
        "profiles/default/config.yaml",
        "workflow/rules/sweep.smk",
        "config/records.tsv",
        "config/scenes/three-tier.yaml",
        "workflow/schemas/config.schema.yaml",
    ):
        assert (project / part).read_bytes() == (ROOT / part).read_bytes(), part
    for part in ("ground-motions.zip", "LICENSE", "README.md"):
        shipped = Path("overturning", "records", "fema-p695", part)
        assert (unpacked_wheel / shipped).read_bytes() == (ROOT / "src" / shipped).read_bytes(), part
    (licence,) = unpacked_wheel.glob("*.dist-info/licenses/src/overturning/records/fema-p695/LICENSE")
    assert "MIT License" in licence.read_text(encoding="utf-8")
    assert not list(project.rglob("__pycache__"))


def test_a_project_made_by_the_wheel_can_be_planned_by_snakemake(
    folder_and_outputs_of_wheel_commands: tuple[Path, list[tuple[str, str]]],
) -> None:
    *_, (made, _), (checked, _), (again, refused), (planned, profile) = folder_and_outputs_of_wheel_commands[1]
    assert "snakemake --cores 2" in made
    assert "2 records × " in checked
    assert [text.splitlines()[-1] for text in (made, checked, again)] == ["status 0", "status 0", "status 1"]
    assert "exists and is not empty" in refused
    assert "rule report:" in planned
    assert planned.endswith("status 0\n")
    assert "profiles/default" in profile, "which asks for the logger plugin"


def test_a_record_added_to_a_project_is_usable_in_new_studies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_overturning_and_return_printed_text("init", tmp_path / "mine")
    monkeypatch.chdir(tmp_path / "mine")
    rows = "\n".join(f"{0.01 * n:.2f},{100 * (n % 50 == 7)},{50 * (n % 40 == 3)}" for n in range(400))
    (tmp_path / "my-site.csv").write_text(f"time,north,east\n{rows}\n", encoding="utf-8")
    given = ("records", "add", "../my-site.csv", "--id", "my-site", "--set", "format=csv", "--set", "event=Here 2020")
    columns = ("--set", "columns=time:s north:gal east:gal", "--set", "processed=true")
    assert "unitt: no column of the record table; known are id" in run_overturning_and_return_printed_text(
        *given, "--set", "unitt=gal", status=1
    )
    assert "error: ..: a folder; name the files of one record" in run_overturning_and_return_printed_text(
        "records", "add", "..", status=1
    )
    assert "config/records.tsv: my-site" in run_overturning_and_return_printed_text(*given, *columns)
    assert Path("resources/records/my-site.csv").is_file()
    assert "is there already" in run_overturning_and_return_printed_text(*given, *columns, status=1)
    assert "config/own.yaml" in run_overturning_and_return_printed_text(
        "study", "new", "--name", "own", "--records", "my-site, rinaldi"
    )
    assert "study 'own', 2 records" in run_overturning_and_return_printed_text("study", "check", "config/own.yaml")
    own = Path("config/own.yaml")
    assert "primary: {statistic: alignment}" in own.read_text(encoding="utf-8"), "rinaldi has a fault strike"
    run_overturning_and_return_printed_text("study", "new", "--name", "no-fault", "--records", "my-site")
    text = Path("config/no-fault.yaml").read_text(encoding="utf-8")
    assert "primary: {statistic: share}" in text, "without a fault there is no alignment with its normal"
    assert "no answer" not in run_overturning_and_return_printed_text("study", "check", "config/no-fault.yaml")
    Path("config/asked.yaml").write_text(text.replace("{statistic: share}", "{statistic: alignment}"), encoding="utf-8")
    asked = run_overturning_and_return_printed_text("study", "check", "config/asked.yaml")
    assert "alignment has no answer: config/records.tsv has no fault_strike_deg for the records of the study" in asked
    refused = run_overturning_and_return_printed_text("study", "new", "--name", "other", "--records", "gone", status=1)
    assert "'gone' is not in config/records.tsv" in refused
    coarse = ("--records", "rinaldi", "--title", "Here: 2020", "--step", "7")
    assert "error: config/other.yaml: azimuth: step 7" in run_overturning_and_return_printed_text(
        "study", "new", "--name", "other", *coarse, status=1
    )
    assert not Path("config/other.yaml").exists()
