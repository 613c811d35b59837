"""Soil below a cemetery: its comparison is that with a study whose records all pass through the same soil."""

import json
import os
from importlib.util import find_spec
from pathlib import Path

import pytest

from overturning.records.store import read_record_from_motion_file
from overturning.study.cube import open_cube
from overturning.surveys.stored_comparison import read_survey_comparison
from overturning.units import STANDARD_GRAVITY
from tests.workflow.conftest import StudyWorkflowCopyWithPlanning

if find_spec("pystrata") is None and "OVERTURNING_NO_SKIP" not in os.environ:
    pytest.skip("pystrata is not installed (`make soil`)", allow_module_level=True)

pytestmark = [pytest.mark.workflow, pytest.mark.long]

SOIL = {"layers": [{"thickness_m": 15, "velocity_m_s": 120}], "rock": {"velocity_m_s": 760}}
STUDY = """\
name: mine
records: {use: [rinaldi]}
azimuth: {step: 45}
b_over_h: [0.2, 0.4, 0.6]
height: [0.6]
ensemble: {members: 0}
verification: none
"""
SURVEY_CSV = "site,outcome,azimuth_deg,b_over_h,face_azimuth_deg\n" + "".join(
    f"{site},{outcome},{azimuth},0.5,{face}\n"
    for site in ("Rock", "River bank")
    for outcome, azimuth, face in (("fell", 45, 45), ("fell", 225, 45), ("fell", 10, ""), ("stands", "", 90))
)


def run_survey_steps(folder: Path, **more: object) -> Path:
    """Execute the workflow steps that the survey comparison needs, and return the folder of the results."""
    checkout = StudyWorkflowCopyWithPlanning(folder, STUDY)
    (folder / "config" / "stones.csv").write_text(SURVEY_CSV, encoding="utf-8")
    plan = checkout.plan(**more)
    wanted = ("read", "describe", "surface", "sweep", "gather", "survey")
    checkout.execute_steps_in_this_process([one for one in plan.commands if one.split()[1] in wanted])
    return folder / "results" / "mine"


def test_soil_given_for_a_cemetery_or_for_the_study_gives_the_same_results(tmp_path: Path) -> None:
    survey = {"stones": "config/stones.csv", "backwards": False}
    mixed = run_survey_steps(
        tmp_path / "mixed", surveys=[survey | {"sites": {"River bank": SOIL}}, survey | {"site": SOIL}]
    )
    soft = run_survey_steps(tmp_path / "soft", site=SOIL, surveys=[survey])
    rock = run_survey_steps(tmp_path / "rock", surveys=[survey])
    (cube,) = mixed.glob("cube.soil-*.nc")
    variant = run_survey_steps(
        tmp_path / "variant", variants={"clay": {"site": SOIL}}, surveys=[survey | {"site": SOIL}]
    )
    assert not [*variant.glob("cube.soil-*.nc")], "the cube of the variant with these layers is used"
    with open_cube(cube) as here, open_cube(variant / "cube.clay.nc") as there, open_cube(mixed / "cube.nc") as bare:
        assert here.attrs["content_sha256"] == there.attrs["content_sha256"]
        with open_cube(soft / "cube.nc") as whole:  # from the motion before it is rounded for its file
            assert here["overturned"].equals(whole["overturned"])
        with open_cube(rock / "cube.nc") as alone:
            assert bare.attrs["content_sha256"] == alone.attrs["content_sha256"]
        assert here.attrs["content_sha256"] != bare.attrs["content_sha256"]
        assert json.loads(here.attrs["study"])["surveys"] == []
    first, second = (read_survey_comparison(mixed / "survey" / f"{number}.json") for number in (1, 2))
    on_soil, on_rock = (
        dict(read_survey_comparison(one / "survey" / "1.json").comparisons_by_site) for one in (soft, rock)
    )
    sites = dict(first.comparisons_by_site)
    assert sites["River bank"].log_likelihood_ratio == on_soil["River bank"].log_likelihood_ratio
    assert sites["River bank"].computed_fall_share == on_soil["River bank"].computed_fall_share
    assert sites["Rock"].log_likelihood_ratio == on_rock["Rock"].log_likelihood_ratio
    assert dict(second.comparisons_by_site)["Rock"].log_likelihood_ratio == on_soil["Rock"].log_likelihood_ratio
    # What is reported of the ground, by hand from the motions.
    ((site, ground),) = first.soil_by_site
    assert (site, ground.thickness_m, ground.mean_shear_wave_velocity_m_s) == ("River bank", 15, pytest.approx(120))
    peaks = [
        max(abs(one).max() for one in read_record_from_motion_file(path).components[:2])
        for path in (mixed / "motion" / "rinaldi.nc", next(mixed.glob("motion/soil-*/rinaldi.nc")))
    ]
    assert [ground.rock_pga, ground.surface_pga] == pytest.approx(peaks, rel=1e-6)
    assert abs(peaks[1] - peaks[0]) > 0.05 * STANDARD_GRAVITY, "the soil changes the motion"
    assert [one[0] for one in second.soil_by_site] == [""]
