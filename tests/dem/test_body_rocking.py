"""A 3-D box rocking over corners and edges and through impacts, against an independent loop of the same equations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from overturning.dem.trajectory import trajectory
from overturning.model.body import Body
from overturning.model.contact import VertexContact
from overturning.motion.motion import Motion
from tests.dem.reference.scalar_body import box_trajectory

pytestmark = pytest.mark.long


@pytest.mark.parametrize(
    ("b_over_h", "aspect", "amplitude", "rate", "friction", "vertical"),
    [
        (0.25, 1.6, 3.0, 12.0, 1.0, 0.0),
        (0.25, 1.6, 4.0, 6.0, 0.5, 0.3),
        (0.4, 1.6, 5.0, 12.0, 0.5, 0.4),
        (0.4, 1.0, 4.0, 6.0, 1.0, -0.6),
        (0.25, 1.0, 3.0, 6.0, 0.5, 0.3),
    ],
)
def test_a_shaken_box_agrees_with_an_independent_integration(
    b_over_h: float, aspect: float, amplitude: float, rate: float, friction: float, vertical: float
) -> None:
    """Two sine cycles to the north, another frequency to the east; compared until the box leans by 0.6 rad."""
    time, height, orientation = np.arange(250) * 0.01, 0.8, 20.0
    north, east = (
        np.where(time < 4 * np.pi / rate, peak * np.sin(factor * rate * time), 0.0)
        for peak, factor in ((amplitude, 1.0), (0.6 * amplitude, 1.3))
    )
    motion = Motion(north, east, vertical * north if vertical else None, sampling_interval=0.01)
    for step, bound in (("0.03 stable", 2e-4), ("auto", 2e-3)):
        path = trajectory(
            motion,
            Body("rectangle", VertexContact(2e-5, damping_ratio=1.0)),
            height=height,
            b_over_h=b_over_h,
            aspect=aspect,
            orientation_deg=orientation,
            friction=friction,
            leave_out=False,
            time_step=step,
        )
        times = path.time.to_numpy()[path.time < 2.4]
        size = height * np.array([b_over_h, aspect * b_over_h, 1.0])
        places, rotations = box_trajectory(times, motion, orientation, size, friction, 2e-5)
        leans = np.arccos(np.clip(rotations[:, 2, 2], -1, 1))
        end = int(np.argmax(leans > 0.6)) or len(times)
        assert leans[:end].max() > 0.015
        signs = [np.sign(axis[np.abs(axis) > 1e-3]) for axis in rotations[:end, :2, 2].T]
        assert sum(int((np.diff(sign) != 0).sum()) for sign in signs) >= 2
        found = Rotation.from_quat(path.quaternion.to_numpy()[:end], scalar_first=True).as_matrix()
        np.testing.assert_allclose(found, rotations[:end], rtol=0, atol=bound)
        moved = path.place.to_numpy()[:end] - [0.0, 0.0, path.place.to_numpy()[0, 2] - places[0, 2]]
        np.testing.assert_allclose(moved, places[:end], rtol=0, atol=bound)
