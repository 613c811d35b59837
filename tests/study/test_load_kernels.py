"""Loading of the kernels of a sweep before the processes of the sweeps are forked."""

import pytest

from overturning.study import sweep
from tests.study.small_study import sine_cycle_record, small_study


@pytest.mark.parametrize(
    ("variant", "keys"),
    [
        ("nominal", {}),
        ("bouncing", {"variants": {"bouncing": {"contact": {"damping_ratio": 0.5}}}}),
        ("nominal", {"amplitude": [0.01, 1.0]}),
    ],
)
def test_loading_the_kernels_simulates_one_case_that_moves(
    monkeypatch: pytest.MonkeyPatch, variant: str, keys: dict[str, object]
) -> None:
    """The one simulated case moves, since a case at rest would not call the kernel."""
    steps, simulate = [], sweep.simulate_variant
    monkeypatch.setattr(
        sweep, "simulate_variant", lambda *given: steps.append(simulate(*given)["block_steps"].ravel().tolist())
    )
    sweep.load_compiled_simulation_code(small_study(**keys), sine_cycle_record(peak=2.0), variant)
    ((count,),) = steps
    assert count > 0
