"""A small study on SLURM and in chunks: the bytes of one core."""

import pytest

from tests.expect import lacking
from verification.one_node_slurm import missing
from verification.scale import same_bytes

pytestmark = pytest.mark.workflow


@pytest.fixture(scope="module")
def on_one_core() -> same_bytes.Run:
    return same_bytes.local(same_bytes.SMALL, cores=1, chunks=1)


def test_a_study_in_chunks_has_the_bytes_of_one_core(on_one_core: same_bytes.Run) -> None:
    run = same_bytes.local(same_bytes.SMALL, cores=2, chunks=3)
    assert run.sha256 == on_one_core.sha256
    assert run.kept == 3, "the default profile keeps parts"


def test_a_study_on_slurm_has_the_bytes_of_one_core(on_one_core: same_bytes.Run) -> None:
    if why := missing():
        lacking(why)
    (run,) = same_bytes.on_slurm(same_bytes.SMALL, chunks=2)
    assert run.sha256 == on_one_core.sha256
    assert run.kept == 0, "this profile lets them go"
