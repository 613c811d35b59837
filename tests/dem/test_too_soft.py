"""A contact so soft that the weight alone presses it in too far has no answer, shaken or not."""

import numpy as np
import pytest

from overturning.dem.run import run_cases
from overturning.dem.simulate import simulate_arrays
from overturning.dem.trajectory import trajectory
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.contact import Contact, VertexContact
from overturning.model.scene import gravestone, load_scene
from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion

SHAKEN = pytest.mark.parametrize("peak", [0.0, 0.1, 5.0])
ALL = pytest.mark.parametrize("leave_out", [True, False])


@SHAKEN
@ALL
def test_a_block_pressed_in_too_far_is_marked(peak: float, leave_out: bool) -> None:
    north = peak * np.sin(np.arange(200) * 0.1)
    motion = Motion(north, np.zeros(200), sampling_interval=0.01)
    cases = Cases(0.0, 1.0, [0.3, 0.3], 0.6)
    soft = run_cases(motion, cases, gravestone(Contact(stiffness=1e4)), leave_out=leave_out)
    assert soft.status.tolist() == [Status.UNSTABLE] * 2
    assert soft.overturned.tolist() == [INT8_MISSING] * 2
    stiff = run_cases(motion, cases, gravestone(Contact(stiffness=1e8)), leave_out=leave_out)
    assert (stiff.overturned != INT8_MISSING).all()


@SHAKEN
@ALL
@pytest.mark.parametrize(("plan", "times"), [("rectangle", 1), ("circle", 2), (6, 3)])
def test_a_body_in_space_pressed_in_too_far_is_marked(
    peak: float, leave_out: bool, plan: str | int, times: int
) -> None:
    """Too far is a tenth of the smaller side: 0.1 B, or 0.1 H of a squat one.

    Its static penetration is that of a rectangle's vertices, or of two of the four points of a rim or the six vertices,
    all of which carry it at rest.
    """
    north = peak * np.sin(np.arange(200) * 0.1)
    motion = Motion(north, np.zeros(200), sampling_interval=0.01)
    size = {"orientation_deg": 0.0, "height": 0.4, "friction": 0.6}
    for ratio, deepest in ((0.3, 0.1), (2.0, 0.05)):
        soft, stiff = (
            simulate_arrays(
                motion,
                Body(plan, VertexContact(share * times * deepest)),
                b_over_h=ratio,
                leave_out=leave_out,
                **size,
            )
            for share in (1.01, 0.01)
        )
        assert soft["status"].item() == Status.UNSTABLE
        assert soft["overturned"].item() == INT8_MISSING
        assert stiff["overturned"].item() != INT8_MISSING
    path = trajectory(motion, Body(plan, VertexContact(0.06 * times)), b_over_h=2.0, **size)
    assert (int(path.status), path.sizes["time"]) == (Status.UNSTABLE, 200)
    assert np.isnan(path.overturned)


@SHAKEN
def test_a_stone_as_wide_as_to_overlap_its_wall_has_no_answer(peak: float) -> None:
    """The face of the wall is at 0.22 m: of a stone of 0.6 m a B/H of 0.7333; wider, the wall would throw it."""
    motion = Motion(peak * np.sin(np.arange(200) * 0.1), np.zeros(200), sampling_interval=0.01)
    ratios = [0.4, 0.73, 0.44 / 0.6, 0.7334, 0.75, 0.9]
    found = simulate_arrays(motion, load_scene("against-a-wall"), azimuth_deg=[0, 180], b_over_h=ratios)
    none = found["status"] == Status.UNSTABLE
    assert none.reshape(2, -1).tolist() == [[False, False, False, True, True, True]] * 2
    assert ((found["overturned"] == INT8_MISSING) == none).all()
    way = trajectory(motion, load_scene("against-a-wall"), azimuth_deg=0, b_over_h=0.75)
    assert way.status == Status.UNSTABLE
    assert np.isnan(way.overturned.sel(element="stone"))
