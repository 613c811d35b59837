"""The known answer: three of fourteen pulse records overturn B/H = 0.4, in the fault-normal component only."""

import pytest

from overturning.dem.simulate import simulate_arrays
from overturning.model.contact import Contact
from tests.dem.near_field import near_field

FALLING = {7: "Petrolia", 9: "Rinaldi", 10: "Sylmar Olive View"}


@pytest.mark.parametrize("damping_ratio", [0.5, 1.0])
@pytest.mark.parametrize("number", range(1, 15))
def test_known_answer(number: int, damping_ratio: float) -> None:
    motion, normal, parallel = near_field(number)
    found = simulate_arrays(
        motion,
        azimuth_deg=[normal, parallel],
        height=[0.6],
        b_over_h=[0.39, 0.4, 0.42],
        friction=[1.0],
        contact=Contact(damping_ratio=damping_ratio),
    )
    assert (found["status"] <= 1).all()
    falls = (found["overturned"] != 0)[:, 0, :, 0]
    assert falls.tolist() == [[number in FALLING] * 3, [False] * 3]
