"""The paper's study on files in KiK-net's format that the test writes itself."""

from pathlib import Path

import numpy as np
import pytest
from snakemake_interface_common.exceptions import WorkflowError

from overturning.findings.collect import read_findings
from overturning.study.cube import open_cube
from tests.records.record_writers import write_knet_component_files
from tests.workflow.conftest import StudyWorkflowCopyWithPlanning
from verification.tables import ROOT

pytestmark = [pytest.mark.workflow, pytest.mark.long]


def test_published_tottori_values_are_compared_for_every_size_and_contact(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Which motions came along is asked in tests/surveys: here that of the study is enough.
    for name in ("candidate_motions_from_shipped_records", "synthetic_pulse_motions"):
        monkeypatch.setattr(f"overturning.surveys.library.{name}", lambda: ())
    study = (ROOT / "config" / "tottori.yaml").read_text(encoding="utf-8")
    study = study.replace("stop: 360, step: 1,", "stop: 360, step: 45,").replace("step: 0.1", "step: 0.55")
    checkout = StudyWorkflowCopyWithPlanning(
        tmp_path / "checkout",
        study + "surveys: [{stones: config/stones.csv}]\nfigures: {formats: [svg]}\n"
        "ensemble: {members: 0}\nverification: none\n",
    )
    stones = checkout.folder / "config" / "stones.csv"
    stones.write_text("octant,count,b_over_h,height_m,round\nNE,5,0.4,0.7,yes\nHE,1,0.4,0.7,yes\n", encoding="utf-8")
    # One cycle of a sine along N60E, strong enough to overturn B/H = 0.4, and nothing across.
    time = np.arange(0.0, 8.0, 0.01)
    pulse = np.where((time > 2) & (time < 3), 10.233 * np.sin(2 * np.pi * (time - 2)), 0.0)
    folder = checkout.folder / "resources" / "records"
    folder.mkdir(parents=True)
    counts = pulse / 0.01 * 8388608 / 2000  # Gal over the gain of the format's scale factor
    write_knet_component_files(
        folder,
        "TTRH020010061330",
        counts * 0.5,
        counts * np.sqrt(0.75),
        counts * 0.0,
        kik=2,
        station="TTRH02",
        magnitude="7.3",
    )
    with pytest.raises(WorkflowError, match=r"stones\.csv line 3: column octant 'HE': use one of N NE E"):
        checkout.planned_rules()
    assert not (checkout.folder / "results").exists()
    stones.write_text("octant,count,b_over_h,height_m,round\nNE,5,0.4,0.7,yes\nSW,1,0.4,0.7,yes\n", encoding="utf-8")
    checkout.execute_steps_in_this_process(checkout.plan().commands)
    results = checkout.folder / "results" / "tottori"
    for name in ("cube.nc", "cube.paper-damping.nc"):
        with open_cube(results / name) as cube:
            assert {60, 330} <= set(cube["azimuth"].to_numpy().tolist())
            assert (np.abs(cube["overturned"].sel(azimuth=60)) == 1).all()
            assert (cube["overturned"].sel(azimuth=330) == 0).all()
    report = (results / "report.html").read_text(encoding="utf-8")
    assert "1023.3" in report
    found = read_findings(results / "findings.json")
    assert [(one.variant, one.fully_agreeing_block_count, one.blocks, one.heights_agreeing_at_some_friction_m)
            for one in found.published_agreement] == [
        ("nominal", 3, 3, [0.4, 0.95, 1.5]), ("paper-damping", 3, 3, [0.4, 0.95, 1.5]),
    ]  # fmt: skip
    assert "stones.csv" in report
    # The map of station and epicentre, as the files' headers have them.
    assert (results / "figures" / "maps" / "1.svg").is_file()
    assert "differs" in report  # nothing moves across, where the paper has 580.6 Gal
