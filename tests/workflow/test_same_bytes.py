"""A small study computed otherwise: killed and resumed, and on a cluster, it has the bytes of one run on two cores."""

import random
import time
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from hashlib import sha256
from pathlib import Path

import pytest

from tests.expect import skip_test_unless_skipping_is_forbidden
from tests.workflow.conftest import SMALL_STUDY, StudyWorkflowCopyWithPlanning, reproducible_result_file_contents
from verification import one_node_slurm
from verification.faults.__main__ import cause_fault_and_describe_failure
from verification.faults.kinds import FAULT_KINDS, InjectedFaultKind
from verification.scale.same_bytes import StudyRunTimeAndResultHash, run_study_on_slurm

pytestmark = [pytest.mark.workflow, pytest.mark.long]


@pytest.fixture(scope="module", autouse=True)
def slurm_runs() -> Iterator[Future[list[StudyRunTimeAndResultHash]]]:
    """Runs of the small study on a one-node SLURM cluster, started in the background for a later test."""
    with ThreadPoolExecutor(1) as pool:
        yield pool.submit(run_study_on_slurm, SMALL_STUDY, 2)


def test_a_resumed_run_gives_results_with_the_same_bytes(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning, tmp_path: Path
) -> None:
    """The resumed run computes each record in one piece, the uninterrupted run in two.

    The steps after the cube run in the process of the test.
    """

    def kill_snakemake_after_first_motion_file(
        place: StudyWorkflowCopyWithPlanning, _dice: random.Random, _seconds: float
    ) -> None:
        """Kill only Snakemake, as soon as a motion file exists; a random moment might come before that."""
        run = place.start()
        while run.poll() is None and not list(place.results.glob("motion/*.nc")):
            time.sleep(0.02)
        run.kill()
        run.wait()
        assert list(place.results.glob("motion/*.nc"))
        assert not place.cube_path.exists()

    faults = {kind.label: kind for kind in FAULT_KINDS}
    assert sum(kind.repetition_count for kind in FAULT_KINDS) == 50
    place, wanted = (
        StudyWorkflowCopyWithPlanning(tmp_path / "elsewhere", cores=1),
        checkout_with_finished_run.cube_path.read_bytes(),
    )
    for kind in (
        InjectedFaultKind("killed", kill_snakemake_after_first_motion_file, 1),
        faults["a byte of a partial result changed"],
    ):
        assert (
            cause_fault_and_describe_failure(
                kind, place, random.Random(1), 0.0, wanted, skips_check_that_rerun_does_nothing=True
            )
            == ""
        )
    place.execute_steps_in_this_process(place.plan().commands)
    one, other = (
        reproducible_result_file_contents(checkout_with_finished_run.results),
        reproducible_result_file_contents(place.results),
    )
    assert {"cube.nc", "report.html", "intensity.nc", "figures/rose.svg"} <= one.keys() == other.keys()
    assert [name for name in one if one[name] != other[name]] == []


def test_a_study_on_slurm_gives_the_same_bytes_as_a_local_run(
    checkout_with_finished_run: StudyWorkflowCopyWithPlanning, slurm_runs: Future[list[StudyRunTimeAndResultHash]]
) -> None:
    if why := one_node_slurm.slurm_unavailable_reason():
        skip_test_unless_skipping_is_forbidden(why)
    (run,) = slurm_runs.result()
    assert run.sha256_of_result == sha256(checkout_with_finished_run.cube_path.read_bytes()).hexdigest()
    assert run.sweep_part_count == 4, "of which figures may be drawn later"


@pytest.mark.parametrize(("killed", "stays"), [(False, True), (True, False)])
def test_a_slurm_configuration_is_restored_unless_a_killed_test_left_it(
    killed: bool, stays: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "slurm" / "slurm.conf"
    monkeypatch.setattr(one_node_slurm, "SLURM_CONFIGURATION_FILE", file)
    with one_node_slurm._temporary_slurm_configuration("ClusterName=one\n"):
        written = file.read_text(encoding="utf-8")
    assert "ClusterName=one\n" in written
    assert not file.exists()
    file.write_text(written if killed else "ClusterName=mine\n", encoding="utf-8")
    with one_node_slurm._temporary_slurm_configuration("ClusterName=one\n"):
        pass
    assert file.exists() == stays
