"""A small study on SLURM and in chunks: the bytes of one process that computes it in one piece."""

from collections.abc import Iterator

import pytest

from tests.expect import lacking
from verification.one_node_slurm import missing
from verification.scale import same_bytes

pytestmark = pytest.mark.workflow


@pytest.fixture(scope="module")
def whole_and_chunks() -> Iterator[tuple[same_bytes.Run, same_bytes.Run]]:
    with same_bytes.fresh(same_bytes.SMALL) as folder:
        chunks = same_bytes.made(folder, "chunks", "--cores", "2", "--set-scatter", "sweep=3")
        yield same_bytes.without_snakemake(folder, "whole"), chunks


def test_a_study_in_chunks_has_the_bytes_of_one_piece(
    whole_and_chunks: tuple[same_bytes.Run, same_bytes.Run],
) -> None:
    whole, chunks = whole_and_chunks
    assert chunks.sha256 == whole.sha256
    assert chunks.kept == 3, "the default profile keeps parts"


def test_a_study_on_slurm_has_the_bytes_of_one_piece(whole_and_chunks: tuple[same_bytes.Run, same_bytes.Run]) -> None:
    if why := missing():
        lacking(why)
    (run,) = same_bytes.on_slurm(same_bytes.SMALL, chunks=2)
    assert run.sha256 == whole_and_chunks[0].sha256
    assert run.kept == 0, "this profile lets them go"
