"""Cases with excessive static penetration have no valid outcome, with or without motion."""

import numpy as np
import pytest

from overturning.dem.run import run_cases
from overturning.dem.simulate import simulate_as_arrays
from overturning.dem.trajectory import trajectory
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.contact import Contact, VertexContact
from overturning.model.scene import gravestone, load_scene
from overturning.model.status import CaseStatus
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion

PARAMETRIZE_PEAK_ACCELERATION = pytest.mark.parametrize("peak", [0.0, 0.1, 5.0])
PARAMETRIZE_SKIPPING_OF_TIMES_AT_REST = pytest.mark.parametrize("leave_out", [True, False])


@PARAMETRIZE_PEAK_ACCELERATION
@PARAMETRIZE_SKIPPING_OF_TIMES_AT_REST
def test_a_block_with_excessive_static_penetration_is_marked_unstable(peak: float, leave_out: bool) -> None:
    north = peak * np.sin(np.arange(200) * 0.1)
    motion = Motion(north, np.zeros(200), sampling_interval=0.01)
    cases = Cases(0.0, 1.0, [0.3, 0.3], 0.6)
    soft = run_cases(motion, cases, gravestone(Contact(stiffness=1e4)), leave_out=leave_out)
    assert soft.status.tolist() == [CaseStatus.UNSTABLE] * 2
    assert soft.overturned.tolist() == [INT8_MISSING] * 2
    stiff = run_cases(motion, cases, gravestone(Contact(stiffness=1e8)), leave_out=leave_out)
    assert (stiff.overturned != INT8_MISSING).all()


@PARAMETRIZE_PEAK_ACCELERATION
@PARAMETRIZE_SKIPPING_OF_TIMES_AT_REST
@pytest.mark.parametrize(("plan", "times"), [("rectangle", 1), ("circle", 2), (6, 3)])
def test_a_3d_body_with_excessive_static_penetration_is_marked_unstable(
    peak: float, leave_out: bool, plan: str | int, times: int
) -> None:
    """The limit of the penetration at rest is a tenth of the smaller side: 0.1 B, or 0.1 H for a squat body.

    The contact law states the penetration of a rectangle on four vertices, of a cylinder on two points of its rim, or
    of a hexagon on two vertices. At rest, four points of the rim or all six vertices of the hexagon share the weight,
    so that the law may state a penetration `times` as large.
    """
    north = peak * np.sin(np.arange(200) * 0.1)
    motion = Motion(north, np.zeros(200), sampling_interval=0.01)
    size = {"orientation_deg": 0.0, "height": 0.4, "friction": 0.6}
    for ratio, deepest in ((0.3, 0.1), (2.0, 0.05)):
        soft, stiff = (
            simulate_as_arrays(
                motion,
                Body(plan, VertexContact(share * times * deepest)),
                b_over_h=ratio,
                leave_out=leave_out,
                **size,
            )
            for share in (1.01, 0.01)
        )
        assert soft["status"].item() == CaseStatus.UNSTABLE
        assert soft["overturned"].item() == INT8_MISSING
        assert stiff["overturned"].item() != INT8_MISSING
    path = trajectory(motion, Body(plan, VertexContact(0.06 * times)), b_over_h=2.0, **size)
    assert (int(path.status), path.sizes["time"]) == (CaseStatus.UNSTABLE, 200)
    assert np.isnan(path.overturned)


@PARAMETRIZE_PEAK_ACCELERATION
def test_a_stone_too_wide_for_its_gap_to_the_wall_has_a_missing_outcome(peak: float) -> None:
    """The wall is 0.22 m from the centre: a stone 0.6 m high overlaps it from B/H 0.7333 and would be thrown off."""
    motion = Motion(peak * np.sin(np.arange(200) * 0.1), np.zeros(200), sampling_interval=0.01)
    ratios = [0.4, 0.73, 0.44 / 0.6, 0.7334, 0.75, 0.9]
    found = simulate_as_arrays(motion, load_scene("against-a-wall"), azimuth_deg=[0, 180], b_over_h=ratios)
    none = found["status"] == CaseStatus.UNSTABLE
    assert none.reshape(2, -1).tolist() == [[False, False, False, True, True, True]] * 2
    assert ((found["overturned"] == INT8_MISSING) == none).all()
    way = trajectory(motion, load_scene("against-a-wall"), azimuth_deg=0, b_over_h=0.75)
    assert way.status == CaseStatus.UNSTABLE
    assert np.isnan(way.overturned.sel(element="stone"))
