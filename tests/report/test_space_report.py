"""The report of a study in space: sections, figures, sentences."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from overturning.commands.explore import explore
from overturning.model.variables import BODY_ENSEMBLE_VARIABLES
from overturning.report.blocks import Answer, Figure, Section, Table, each_block
from overturning.report.build import build_report
from overturning.report.pdf import render_pdf
from overturning.report.results import open_results
from overturning.report.sections.space import twists
from overturning.study.sections import BodySettings
from tests.report.reading import of_study, render_html
from tests.report.tiny_studies import make_results, pulse_record

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    records = [
        pulse_record("one", 60, 6.0, fault_strike_deg=330.0, extra={"pulse": True}),
        pulse_record("two", 10, 5.0, fault_strike_deg=300.0, extra={"pulse": False}),
    ]
    return make_results(
        tmp_path_factory.mktemp("space"),
        records,
        body={"aspect": [1, 1.5]},
        orientation={"step": 45},
    )


def test_it_has_the_sections_of_space_and_none_of_planes(folder: Path) -> None:
    with open_results(folder) as results:
        report = build_report(results)
        anchors = {block.anchor: block for block in each_block(report) if isinstance(block, Section)}
        assert {"answer", "rose", "follows", "planes", "twist", "uncertainty"} <= anchors.keys()
        assert "intensity" not in anchors
        for figure in (block for block in each_block(report) if isinstance(block, Figure)):
            assert figure.path.is_file(), figure.path
        tables = [block for block in each_block(anchors["planes"]) if isinstance(block, Table)]
        assert [row[0] for row in tables[0].rows] == ["one", "two"]
        page, paper = render_html(report), render_pdf(report)
    assert 'class="film"' in page
    assert ">B/H 0.2</th>" in page, "it was B/H 0.2 to 0.2"
    assert "drag" in page.lower()
    assert "record × orientation × height × B/H × aspect × friction" in page
    assert "orientations of one record are the same motion" in page
    assert paper.startswith(b"%PDF")
    with open_results(folder) as results:
        assert render_html(build_report(results)) == page


def test_twist_of_cylinders_is_noted_as_rolling(folder: Path) -> None:
    with open_results(folder) as results:
        assert "rolls on its rim" not in repr(twists(results))
        assert "rolls on its rim" in repr(twists(of_study(results, body=BodySettings(plan="circle"))))


def test_where_every_body_falls_its_falls_still_have_directions(folder: Path) -> None:
    """The report said that every block overturned in every plane, and that there was no axis."""
    turn = np.random.default_rng(4)
    with open_results(folder) as opened:
        cube = opened.cube.drop_vars(one.name for one in BODY_ENSEMBLE_VARIABLES).load()
        normals = cube["fault_normal"].to_numpy()
        towards = normals[:, None] + 20.0 * turn.normal(size=(2, cube["overturned"][0].size))
        found = {"overturned": 0 * cube["status"] + 1.0, "fall_azimuth": cube["fall_azimuth"].copy()}
        found["fall_azimuth"][:] = (towards % 360.0).reshape(cube["fall_azimuth"].shape)
        results = replace(opened, cube=cube.assign(found), cubes={"nominal": cube.assign(found)})
        report = build_report(results)
        said = [text for block in each_block(report) if isinstance(block, Answer) for text in block.sentences]
    means = np.cos(np.radians(2 * (towards - normals[:, None]))).mean(axis=1)
    assert not any("every plane" in text or "no axis" in text for text in said)
    largest = np.abs(np.exp(2j * np.radians(towards)).mean(axis=1))
    value = f"{means[0]:.2f} of at most {largest[0]:.2f}"
    assert f"with the fault normal (1 normal to the fault, −1 along it) is {value} (1 earthquake)" in said[0]
    assert "the alignment stays at" in said[1]
    value = f"{means[1]:.2f} of at most {largest[1]:.2f}"
    assert f"{value} (1 earthquake) without a pulse" in said[2]


def test_the_explorer_takes_a_cube_in_space(folder: Path) -> None:
    explore(folder / "cube.nc")
    page = (folder / "explore.html").read_text(encoding="utf-8")
    assert '"space":true' in page
    assert '"orientation' in page
