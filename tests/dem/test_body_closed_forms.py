"""A 3-D body against closed forms and independent integrations."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from overturning.dem.simulate import simulate, simulate_as_arrays
from overturning.dem.trajectory import trajectory
from overturning.model.body import Body, InitialState
from overturning.model.contact import VertexContact
from overturning.model.shapes import RectangularPrism
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from tests.dem.body_starts import body_axis_and_direction_to_lowest_side, motion_at_rest, state_of_leaning_rotating_body
from tests.dem.reference.particles import final_slip_on_horizontal_plane
from tests.dem.reference.rigid_impact import velocities_and_impulses_of_flat_landing_without_bounce as compiled_landing

PARAMETRIZE_SCHEME = pytest.mark.parametrize("scheme", ["centred", pytest.param("cundall", marks=pytest.mark.long)])
pytestmark = pytest.mark.usefixtures("enable_cundall_scheme_for_3d_bodies")


def body_tilt_and_lean_azimuth_by_time(path: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return the tilt of a trajectory's body (rad) and the continuous azimuth of its lean (rad), by time."""
    azimuth = np.unwrap(np.arctan2(path.tilt_east.values, path.tilt_north.values))
    return np.arcsin(np.hypot(path.tilt_north.values, path.tilt_east.values)), azimuth


# Statics
# ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("aspect", [1.0, 2.0])
def test_a_box_overturns_once_the_resultant_force_passes_outside_its_base(aspect: float) -> None:
    ratio, beta = 0.4, np.arange(0.0, 360.0, 24.0)
    b, d, h = 0.5 * ratio, 0.5 * ratio * aspect, 0.5
    across = np.maximum(np.abs(np.sin(np.radians(beta))), 1e-12)
    expected = np.minimum(b / (h * np.abs(np.cos(np.radians(beta)))), d / (h * across))
    # The base acceleration rises slowly to just below or just above the threshold, and stays there.
    t = np.arange(600) * 0.01
    ramp = np.minimum(t / 4.0, 1.0) ** 2 * (3.0 - 2.0 * np.minimum(t / 4.0, 1.0))
    for share, falls in ((0.985, 0), (1.015, 1)):
        for one, threshold in zip(beta[:4], expected[:4], strict=True):
            # A base that accelerates towards β, for a block that faces north.
            east, north = (share * threshold * STANDARD_GRAVITY * ramp * f(np.radians(one)) for f in (np.sin, np.cos))
            found = simulate_as_arrays(
                Motion(north, east, sampling_interval=0.01, trust_data=True),
                Body("rectangle", VertexContact(2e-5)),
                orientation_deg=0.0,
                height=1.0,
                b_over_h=ratio,
                aspect=aspect,
                friction=10.0,
            )
            assert found["overturned"].item() == falls, (one, share)


def test_a_body_falls_above_the_energy_barrier_of_an_edge_or_a_corner() -> None:
    body = RectangularPrism().solid(1.0, 0.4, 1.0)
    for arm in np.array([[0.2, 0.0, -0.5], [0.2, 0.2, -0.5]]):
        rise = np.sqrt(arm @ arm) - body.centre_height
        turn = np.cross([0.0, 0.0, 1.0], arm) / np.hypot(*arm[:2])
        inertia = turn @ body.inertia_per_mass @ turn + arm @ arm
        for share, falls in ((0.97, 0), (1.03, 1)):
            turning = turn * np.sqrt(2.0 * share * STANDARD_GRAVITY * rise / inertia)
            path = trajectory(
                motion_at_rest(4.0),
                Body("rectangle", VertexContact(2e-5), state_of_leaning_rotating_body(0.0, arm, turning)),
                orientation_deg=0.0,
                height=1.0,
                b_over_h=0.4,
                friction=10.0,
            )
            assert int(path.overturned) == falls, (arm, share)


# A cylinder on its rim
# ---------------------------------------------------------------------------------------------------


@PARAMETRIZE_SCHEME
@pytest.mark.parametrize(("precession", "axial"), [(18.2597, 4.5573), (9.1286, 0.0)])
def test_a_cylinder_rolls_on_its_rim_with_steady_precession(precession: float, axial: float, scheme: str) -> None:
    R, H, tilt = 0.1, 0.25, 0.1
    up, down = body_axis_and_direction_to_lowest_side(tilt)
    turning = precession * np.array([0.0, 0.0, 1.0]) + (axial - precession * np.cos(tilt)) * up
    contact = VertexContact()
    start = state_of_leaning_rotating_body(
        tilt, R * down - H * up, turning, sunk=4 * contact.static_penetration * 2 * R
    )
    path = trajectory(
        motion_at_rest(3 * 2 * np.pi / precession),
        Body("circle", contact, start),
        orientation_deg=90.0,
        height=2 * H,
        b_over_h=R / H,
        friction=10.0,
        leave_out=False,
        scheme=scheme,
    )
    turns = path.time.values < 3 * 2 * np.pi / precession
    found, azimuth = (values[turns] for values in body_tilt_and_lean_azimuth_by_time(path))
    np.testing.assert_allclose(found, tilt, rtol=1e-2)
    # Anticlockwise from above: azimuths decrease.
    assert (azimuth[0] - azimuth[-1]) / path.time.values[turns][-1] == pytest.approx(precession, rel=1e-2)


@PARAMETRIZE_SCHEME
@pytest.mark.parametrize("slender", [2.5, 3.0, 6.0])
@pytest.mark.parametrize("rolls", [True, False])
def test_contact_point_of_a_nearly_flat_cylinder_turns_by_closed_form_angle(
    slender: float, rolls: bool, scheme: str
) -> None:
    # The closed form is the limit of ever closer passes; slender bodies need a smaller tilt.
    R, H, contact = 0.1, 0.1 * slender, VertexContact(2e-9)
    tilt, turning = (0.1, 0.005) if slender <= 3.0 else (0.2 / slender, 0.0005)
    up, down = body_axis_and_direction_to_lowest_side(tilt)
    start = state_of_leaning_rotating_body(
        tilt, R * down - H * up, turning * down, sunk=4 * contact.static_penetration * 2 * R, rolls=rolls
    )
    path = trajectory(
        motion_at_rest(0.5, 0.001),
        Body("circle", contact, start),
        orientation_deg=0.0,
        height=2 * H,
        b_over_h=R / H,
        friction=10.0 if rolls else 0.0,
        leave_out=False,
        scheme=scheme,
    )
    found, azimuth = body_tilt_and_lean_azimuth_by_time(path)
    lowest = int(np.flatnonzero(np.diff(found) > 0)[0])
    high = lowest + int(np.argmax(found[lowest:] > 0.98 * tilt))
    highest = high + int(np.flatnonzero(np.diff(found[high:]) < 0)[0])
    assert found[highest] == pytest.approx(tilt, rel=1e-2)
    A = (3 * R**2 + 4 * H**2) / 12
    expected = np.pi * np.sqrt((A + H**2 + R**2) / (A + H**2) if rolls else (A + R**2) / A)
    # Most of the turn occurs within a sample, so its sense is ambiguous.
    turn = abs(azimuth[highest] - azimuth[0]) % (2 * np.pi)
    assert max(turn, 2 * np.pi - turn) == pytest.approx(expected, rel=1e-2)


# A flat landing
# ----------------------------------------------------------------------------------------------------------


def vertex_arms_inertia_and_lean_direction(
    body: int | str, over: str, ratio: float, half: float = 0.5
) -> tuple[np.ndarray, float, float]:
    """Return the arms of a base's vertices along the lean (m), inertia per mass (m²), and direction of the lean (rad).

    The body is a regular prism with apothem `half` · `ratio` and height 2 `half`, or a cylinder, whose rim has 720
    vertices. It leans over a vertex of the base if `over` is "vertex", otherwise over an edge.
    """
    apothem, rim = half * ratio, body == "circle"
    n = 720 if rim else int(body)
    turn = np.pi / n if over == "vertex" else 0.0
    outer = apothem if rim else apothem / np.cos(np.pi / n)
    angle = 2 * np.pi * (np.arange(n) + (0.0 if rim else 0.5)) / n
    square = outer**2 / 4 if rim else outer**2 * (2 + np.cos(2 * np.pi / n)) / 12
    return outer * np.cos(angle - turn), square + half**2 / 3, turn


def angular_velocity_ratio_of_flat_plastic_landing(x: np.ndarray, inertia: float, height: float) -> float:
    """Return the ratio of angular velocities after and before a flat plastic landing, by a complementarity problem.

    The base does not slip, so the centre of a body rotating with w about a horizontal axis moves with w · height, and
    (inertia + height²) w balances the moments of the vertical impulses p at the arms x, with 0 ≤ p ⟂ upward
    velocity ≥ 0. Solved by Gauss-Seidel iteration.
    """
    distinct = np.unique(np.round(x, 12))
    v, w, p = compiled_landing(distinct, inertia + height**2)
    assert (v - w * distinct > -1e-9).all()
    assert np.abs(p * (v - w * distinct)).max() < 1e-9
    return float(w)


def simulated_landing_velocity_ratio(
    body: int | str, over: str, ratio: float, contact: VertexContact, scheme: str, half: float = 0.5
) -> float:
    """Return the simulated ratio of the angular velocities after and before a flat landing.

    The body is released at a tilt of 0.45 α; the ratio follows from the height to which it rises on the opposite side.
    """
    x, _, turn = vertex_arms_inertia_and_lean_direction(body, over, ratio, half)
    a = x.max()
    radius, alpha = np.hypot(a, half), np.arctan2(a, half)
    tilt = 0.45 * alpha
    cosine, sine, out = np.cos(turn), np.sin(turn), a - radius * np.sin(alpha - tilt)
    start = InitialState(
        (out * cosine, out * sine, radius * np.cos(alpha - tilt)),
        (np.cos(tilt / 2), -sine * np.sin(tilt / 2), cosine * np.sin(tilt / 2), 0.0),
    )
    path = trajectory(
        motion_at_rest(0.6, 0.002),
        Body(body, contact, start),
        orientation_deg=0.0,
        height=2 * half,
        b_over_h=ratio,
        friction=10.0,
        leave_out=False,
        scheme=scheme,
    )
    lean = np.arcsin(path.tilt_north.values * cosine - path.tilt_east.values * sine)
    rise = lambda angle: np.cos(alpha - angle) - np.cos(alpha)  # noqa: E731
    return float(np.sqrt(rise(-lean[path.time.values < 0.6].min()) / rise(tilt)))


CRITICALLY_DAMPED, OVERDAMPED = VertexContact(damping_ratio=1.0), VertexContact(damping_ratio=4.0)


@pytest.mark.parametrize("ratio", [0.35, 0.2])
@pytest.mark.parametrize("over", ["edge", "vertex"])
def test_a_flat_landing_is_plastic_on_any_number_of_vertices(over: str, ratio: float) -> None:
    bodies = (8, 24, 96) if over == "vertex" else (4, 6, 8, 24, 96, "circle")
    expected = {
        body: angular_velocity_ratio_of_flat_plastic_landing(
            *vertex_arms_inertia_and_lean_direction(body, over, ratio)[:2], 0.5
        )
        for body in bodies
    }
    for body, share in expected.items():
        x, inertia, _ = vertex_arms_inertia_and_lean_direction(body, over, ratio)
        far = x.max() ** 2
        assert share == pytest.approx((inertia + 0.25 - far) / (inertia + 0.25 + far), abs=1e-6)
        # The remaining error at a damping ratio of 1 is bouncing of an end; it is of first order in the finest step.
        assert simulated_landing_velocity_ratio(body, over, ratio, OVERDAMPED, "centred") == pytest.approx(
            share, abs=1e-3
        )
        assert simulated_landing_velocity_ratio(body, over, ratio, CRITICALLY_DAMPED, "centred") == pytest.approx(
            share, abs=3e-3
        )
    if over == "edge":
        assert expected[4] == pytest.approx(1.0 - 1.5 * ratio**2 / (1.0 + ratio**2), abs=1e-6)  # Housner
        cylinder = simulated_landing_velocity_ratio("circle", over, ratio, OVERDAMPED, "centred")
        apart = [
            abs(simulated_landing_velocity_ratio(body, over, ratio, OVERDAMPED, "centred") - cylinder)
            for body in (4, 8, 96)
        ]
        assert apart[2] < 5e-4
        assert apart[2] < apart[0]


@pytest.mark.long
@pytest.mark.parametrize("body", [8, "circle"])
def test_a_flat_landing_is_plastic_with_cundalls_scheme_and_strong_damping(body: int | str) -> None:
    soft = VertexContact(2e-5, damping_ratio=2.0)
    share = angular_velocity_ratio_of_flat_plastic_landing(
        *vertex_arms_inertia_and_lean_direction(body, "edge", 0.35)[:2], 0.5
    )
    assert simulated_landing_velocity_ratio(body, "edge", 0.35, soft, "cundall") == pytest.approx(share, abs=1e-3)


# Sliding and flying
# ------------------------------------------------------------------------------------------------------


@PARAMETRIZE_SCHEME
def test_a_squat_block_slides_as_a_particle_with_isotropic_friction(scheme: str) -> None:
    t = np.arange(45) * 0.05
    shakes = t < 1.2
    motion = Motion(5.0 * np.sin(6.0 * t) * shakes, (4.0 * np.cos(9.0 * t) - 1.0) * shakes, sampling_interval=0.05)
    found = simulate_as_arrays(
        motion, "rectangle", orientation_deg=[0.0, 25.0], height=0.1, b_over_h=10.0, friction=0.2, scheme=scheme
    )
    slip = final_slip_on_horizontal_plane(motion.horizontal_components, motion.sampling_interval, 0.2)
    for name, expected in zip(("residual_slip_north", "residual_slip_east"), slip, strict=True):
        np.testing.assert_allclose(found[name].ravel(), expected, rtol=1e-2)
    assert (np.abs(found["residual_twist"]) < 0.01).all()


def angular_momentum_per_mass_by_time(path: xr.Dataset, inertia: np.ndarray) -> np.ndarray:
    """Return the angular momentum per mass in fixed axes, shape (time, 3), from rotation and angular velocity."""
    w, *v = path.quaternion.values.T
    v = np.stack(v, axis=1)

    def rotate_by_body_rotation_or_inverse(vectors: np.ndarray, sign: int) -> np.ndarray:
        """Rotate vectors by the body's rotation (sign 1) or back (sign −1)."""
        return vectors + 2.0 * np.cross(sign * v, np.cross(sign * v, vectors) + w[:, None] * vectors)

    return rotate_by_body_rotation_or_inverse(
        rotate_by_body_rotation_or_inverse(path.angular_velocity.values, -1.0) * np.diag(inertia), 1.0
    )


@PARAMETRIZE_SCHEME
def test_free_flight_conserves_angular_momentum_and_energy(scheme: str) -> None:
    inertia = (
        RectangularPrism().solid(0.6, 0.4, 1.5).inertia_per_mass[[1, 0, 2]][:, [1, 0, 2]]
    )  # the first side faces north
    path = trajectory(
        motion_at_rest(1.0),
        Body("rectangle", start=InitialState((0.0, 0.0, 10.0), (1.0, 0.0, 0.0, 0.0), (0.3, 0.1, 2.0), (0.5, 0.4, 0.3))),
        orientation_deg=0.0,
        height=0.6,
        b_over_h=0.4,
        aspect=1.5,
        leave_out=False,
        scheme=scheme,
    )
    path = path.isel(time=path.time.values < 1.0)  # before it lands
    momentum = angular_momentum_per_mass_by_time(path, inertia)
    np.testing.assert_allclose(momentum, momentum[:1].repeat(len(momentum), 0), atol=1e-10 * np.abs(momentum).max())
    energy = 0.5 * (path.velocity.values**2).sum(axis=1) + 0.5 * (path.angular_velocity.values * momentum).sum(axis=1)
    energy += STANDARD_GRAVITY * path.place.values[:, 2]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-10)


@PARAMETRIZE_SCHEME
def test_a_frictionless_body_keeps_its_vertical_angular_momentum(scheme: str) -> None:
    arm = np.array([0.12, 0.12, -0.3])
    path = trajectory(
        motion_at_rest(1.0),
        Body("rectangle", start=state_of_leaning_rotating_body(0.0, arm, np.array([-0.5, 0.4, 0.3]), rolls=False)),
        orientation_deg=0.0,
        height=0.6,
        b_over_h=0.4,
        friction=0.0,
        leave_out=False,
        scheme=scheme,
    )
    momentum = angular_momentum_per_mass_by_time(path, RectangularPrism().solid(0.6, 0.4, 1.0).inertia_per_mass)
    assert np.ptp(momentum[:, :2]) > 1e-3
    np.testing.assert_allclose(momentum[:, 2], momentum[0, 2], rtol=1e-10)


@pytest.mark.parametrize(
    ("b_over_h", "friction", "along", "down"),
    [(0.5, 0.3, 2.0, 3.0), (0.3, 0.2, 2.0, 1.0), (0.3, 0.2, 4.0, 5.0), (0.5, 0.3, 4.0, 5.0)],
)
@pytest.mark.parametrize("damping_ratio", [1.0, 3.0, 10.0])
def test_a_moving_body_dropped_flat_stays_flat_if_friction_is_below_b_over_h(
    b_over_h: float, friction: float, along: float, down: float, damping_ratio: float
) -> None:
    """With µ < B/H a plastic landing reduces the horizontal velocity u by µ·v; the body then slides (u − µv)²/2µg."""
    found = outcome_of_moving_prism_dropped_flat(b_over_h, friction, along, down, damping_ratio)
    assert found.overturned.item() == 0
    assert found.peak_tilt.item() < 0.1
    slip = (along - friction * down) ** 2 / (2.0 * friction * STANDARD_GRAVITY)
    assert found.residual_slip_north.item() == pytest.approx(slip, rel=5e-3)


@pytest.mark.parametrize(
    ("shape", "b_over_h", "friction", "along", "down", "angle", "tips"),
    [
        ("rectangle", 0.3, 0.35, 2.0, 1.5, 45.0, False),
        ("rectangle", 0.3, 0.35, 3.0, 1.0, 45.0, False),
        ("rectangle", 0.3, 0.35, 2.0, 1.5, 0.0, True),
        ("rectangle", 0.5, 0.6, 3.0, 1.0, 45.0, False),
        ("rectangle", 0.4, 0.5, 3.0, 1.0, 40.0, False),
        (6, 0.3, 0.32, 2.0, 1.5, 30.0, False),
        (6, 0.3, 0.32, 2.0, 1.5, 0.0, True),
        ("circle", 0.3, 0.29, 2.0, 1.5, 20.0, False),
        ("circle", 0.3, 0.31, 2.0, 1.5, 20.0, True),
    ],
)
def test_whether_a_sliding_body_tips_as_it_lands_flat_depends_on_direction(
    shape: str | int, b_over_h: float, friction: float, along: float, down: float, angle: float, tips: bool
) -> None:
    """A body stays flat if the resultant impulse, µ × centre height ahead of the centre, is within the base (LCP)."""
    found = outcome_of_moving_prism_dropped_flat(b_over_h, friction, along, down, 3.0, shape, angle)
    assert found.status.item() == CaseStatus.SIMULATED
    assert found.overturned.item() == tips
    if not tips:
        assert found.peak_tilt.item() < 0.1
        slip = (along - friction * down) ** 2 / (2.0 * friction * STANDARD_GRAVITY)
        north, east = found.residual_slip_north.item(), found.residual_slip_east.item()
        assert np.hypot(north, east) == pytest.approx(slip, rel=5e-3)
        assert np.degrees(np.arctan2(-east, north)) == pytest.approx(angle, abs=0.1)


@pytest.mark.parametrize(
    ("b_over_h", "friction", "up", "along"), [(0.3, 0.2, -1.5, 0.5), (0.3, 0.25, -1.3, 0.5), (0.4, 0.3, -1.5, 0.6)]
)
def test_a_sliding_body_thrown_up_by_the_base_lands_flat_and_balances_energy(
    b_over_h: float, friction: float, up: float, along: float
) -> None:
    """The slip equals that of the block in the 2-D model."""
    vertical, horizontal = np.zeros(400), np.zeros(400)
    vertical[100:125], horizontal[95:125] = up * STANDARD_GRAVITY, along * STANDARD_GRAVITY
    motion = Motion(horizontal, 0.0 * horizontal, vertical, sampling_interval=0.01, trust_data=True)
    case: dict[str, Any] = {"height": [0.6], "b_over_h": [b_over_h], "friction": [friction], "leave_out": False}
    found = simulate(motion, "rectangle", orientation_deg=[0.0], **case)
    planar = simulate(motion, azimuth_deg=[0.0], **case)
    assert found.status.item() == planar.status.item() == CaseStatus.SIMULATED
    assert found.overturned.item() == planar.overturned.item() == 0
    assert found.energy_error.item() < 3e-3
    assert planar.energy_error.item() < 3e-3
    assert found.residual_slip_north.item() == pytest.approx(planar.residual_slip.item(), rel=5e-3)


def outcome_of_moving_prism_dropped_flat(
    b_over_h: float, friction: float, along: float, down: float, damping_ratio: float,
    shape: str | int = "rectangle", angle: float = 0.0,
) -> xr.Dataset:  # fmt: skip
    """Return the outcome of a prism 0.6 m high that is dropped flat while it moves; velocities in m/s.

    The horizontal velocity `along` points `angle` degrees anticlockwise from north.
    """
    direction = np.radians(angle)
    velocity = (along * float(np.cos(direction)), along * float(np.sin(direction)), -down)
    start = InitialState(
        centre_position=(0.0, 0.0, 0.3 + 1e-6),
        rest_to_initial_quaternion_wxyz=(1.0, 0.0, 0.0, 0.0),
        centre_velocity=velocity,
    )
    contact = VertexContact(damping_ratio=damping_ratio, static_penetration=2e-6)
    body, quiet = Body(shape, contact, start), np.zeros(600)
    motion = Motion(quiet, quiet, sampling_interval=0.01, trust_data=True)
    return simulate(
        motion, body, orientation_deg=[0.0], height=[0.6], b_over_h=[b_over_h], friction=[friction], leave_out=False
    )


@pytest.mark.parametrize("damping_ratio", [1.0, 3.0])
@pytest.mark.parametrize(("along", "down"), [(2.0, 3.0), (4.0, 5.0)])
def test_a_moving_body_dropped_flat_tips_with_high_friction(along: float, down: float, damping_ratio: float) -> None:
    """With µ > B/H the impulse lies outside the base; the outcome is valid, since the energy balances."""
    found = outcome_of_moving_prism_dropped_flat(0.3, 0.6, along, down, damping_ratio)
    assert found.overturned.item() == 1
    assert found.status.item() == CaseStatus.SIMULATED
