"""The draw of mutants, and the copy of the project in which they are put to the tests."""

from pathlib import Path

import pytest

from verification.mutants.drawing import LAYERS, PACKAGE, Mutant, draw
from verification.mutants.trial import Trial


@pytest.mark.long
def test_each_mutant_is_one_token_of_a_layer_and_has_tests(tmp_path: Path) -> None:
    drawn, trial = draw(12, 1), Trial(tmp_path)
    assert [mutant.file.partition("/")[0] for mutant in drawn] == 2 * list(LAYERS)
    (tmp_path / "times.json").write_text("{}")
    for mutant in drawn:
        before = (PACKAGE / mutant.file).read_text(encoding="utf-8").splitlines()
        after = mutant.applied("\n".join(before)).splitlines()
        assert sum(one != other for one, other in zip(before, after, strict=True)) == 1
        assert trial.tests_of(mutant)
    assert trial._tests(["tests/dem/test_run.py"], 300)[0], "with kernels kept by what they are made of"
    assert trial.notices(Mutant("dem/block/centred.py", "half = 0.5 * dt", 0, 7, "0.5", "0.65"))
