"""The command that the explorer shows for a cell simulates that cell."""

import json
from pathlib import Path
from typing import Any

import pytest

from overturning.cli import main
from overturning.records.pulses import parse_pulse, record_of_pulse
from overturning.records.store import round_samples_to_stored_decimals
from overturning.study.film_options import film_command_options_and_stone_sizes
from overturning.study.small import run_study
from overturning.translation.texts import translate, use_translation_language

PULSE = "sine amplitude_gal=420 period_s=1 azimuth_deg=30"
BLOCK_STUDY_SETTINGS: dict[str, Any] = {
    "b_over_h": [0.2],
    "height": [0.6],
    "friction": [0.7],
    "ensemble": {"members": 0},
}
STACK_STUDY_SETTINGS: dict[str, Any] = {"scene": "three-tier", "azimuth": {"step": 30}}


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        (BLOCK_STUDY_SETTINGS | {"azimuth": {"step": 30}}, ""),
        (
            BLOCK_STUDY_SETTINGS | {"contact": {"damping_ratio": 1.0}, "density": 2000},
            "--damping-ratio 1 --density 2000",
        ),
        (BLOCK_STUDY_SETTINGS | {"orientation": {"step": 15}, "body": {"plan": 8}}, "--body --plan 8"),
        (STACK_STUDY_SETTINGS, "--scene three-tier"),
    ],
)
def test_the_film_command_reproduces_the_outcome_of_its_cell(
    keys: dict[str, Any], words: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(Path(__file__).parents[2])  # scenes are named from the project's folder
    cube = run_study([round_samples_to_stored_decimals(record_of_pulse(parse_pulse(PULSE)))], **keys)
    film = film_command_options_and_stone_sizes(cube)
    assert (film["missing"], " ".join(film["options"])) == ("", words)
    direction = "orientation" if "body" in keys else "azimuth"
    sizes = ["--height", str(film["heights"][0]), "--b-over-h", str(film["ratios"][0])]
    friction = ["--friction", "0.7"] if film["friction"] else []
    capsys.readouterr()
    for place in (0, 2):
        cell = cube.isel({"record": 0, direction: place, "height": 0, "b_over_h": 0, "friction": 0})
        turned = [f"--{direction}", str(float(cell[direction]))]
        with pytest.raises(SystemExit, match=r"^0$"):
            main(["one", "--record", PULSE, *film["options"], *turned, *sizes, *friction])
        assert ("falls towards" in capsys.readouterr().out) == bool((abs(cell["overturned"]) == 1).any())


def test_a_reason_is_given_if_no_film_command_can_reproduce_a_study() -> None:
    record = round_samples_to_stored_decimals(record_of_pulse(parse_pulse(PULSE)))
    cube = run_study([record], **BLOCK_STUDY_SETTINGS, azimuth={"step": 90}, simulation={"time_step": 0.0001})
    assert film_command_options_and_stone_sizes(cube)["missing"] == "the study has numerical settings of its own"


def test_no_film_command_for_record_table_outside_project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No film command is given if the study's record table is not in the project's folder.

    The results state only the file name of a record table with an absolute path, and this name is valid only in that
    folder.
    """
    cube = run_study(
        [round_samples_to_stored_decimals(record_of_pulse(parse_pulse(PULSE)))],
        **BLOCK_STUDY_SETTINGS,
        azimuth={"step": 90},
    )
    study = json.loads(cube.attrs["study"])
    study["records"] |= {"table": "table é.tsv", "folder": "data/records"}
    cube.attrs["study"] = json.dumps(study)
    monkeypatch.chdir(tmp_path)
    missing = film_command_options_and_stone_sizes(cube)["missing"]
    assert missing == "the record table table é.tsv is not in the project's folder"
    with use_translation_language("ja"):
        assert translate(missing) == "記録表 table é.tsv がプロジェクトのフォルダーにない"
    (tmp_path / "table é.tsv").touch()
    film = film_command_options_and_stone_sizes(cube)
    assert (film["missing"], film["options"]) == ("", ["--table", "'table é.tsv'", "--folder", "data/records"])
