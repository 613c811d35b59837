"""The 3-D kernel: agreement with the 2-D kernel, symmetry, bits, stable step, energy balance, end of a case."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

from overturning.dem import run as run_module
from overturning.dem.body.statics import largest_squared_frequency_on_springs_of_any_face
from overturning.dem.body.tables import TRAJECTORY_ROW_DTYPE
from overturning.dem.kernel import balance
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import plan_simulation
from overturning.dem.simulate import simulate, simulate_as_arrays
from overturning.dem.time_step import IntegrationScheme, longest_stable_or_accurate_step
from overturning.dem.trajectory import trajectory
from overturning.model.body import Body, InitialState
from overturning.model.cases import Cases
from overturning.model.contact import Contact, VertexContact
from overturning.model.scene import gravestone
from overturning.model.shapes import Cylinder, RectangularPrism, RegularPrism
from overturning.model.status import CaseStatus
from overturning.model.variables import BODY_OUTCOME_VARIABLES, INT8_MISSING
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from tests.dem.body_starts import motion_at_rest
from tests.dem.near_field import near_field_motion_and_fault_component_azimuths, strong_part_of_near_field_record
from verification.reference.sliding import peak_and_final_slip

SOFT_CONTACT = VertexContact(2e-5)
RECTANGLE = Body("rectangle", SOFT_CONTACT)
COMPARED_OUTCOME_NAMES = [item.name for item in BODY_OUTCOME_VARIABLES if item.name != "repeated"]


def strong_part_of_record_with_artificial_vertical(number: int) -> Motion:
    """Return the strong part of a near-field record, with artificial vertical motion."""
    motion = strong_part_of_near_field_record(number, 8.0, 12.0)
    up = 0.4 * (motion.north - motion.east)
    return Motion(motion.north, motion.east, up, sampling_interval=motion.sampling_interval)


PARAMETRIZE_SCHEME = pytest.mark.parametrize("scheme", ["centred", pytest.param("cundall", marks=pytest.mark.long)])
pytestmark = pytest.mark.usefixtures("enable_cundall_scheme_for_3d_bodies")


@pytest.mark.long
@pytest.mark.parametrize("number", [1, 7])
def test_a_3d_body_shaken_along_a_face_normal_equals_the_2d_model(number: int) -> None:
    motion, normal, _ = near_field_motion_and_fault_component_azimuths(number)
    along = motion.acceleration_along(normal)
    motion = Motion(along, 0.0 * along, sampling_interval=motion.sampling_interval)
    grid = {"height": [0.6], "b_over_h": [0.15, 0.25, 0.35, 0.45], "friction": [0.4, 0.8]}
    same = {"scheme": "cundall", "time_step": 3e-5, "leave_out": False}
    plane = simulate_as_arrays(motion, gravestone(Contact(static_penetration=2e-5)), azimuth_deg=[0.0], **same, **grid)
    space = simulate_as_arrays(motion, RECTANGLE, orientation_deg=[0.0], **same, **grid)
    in_space = {name: space[name][:, :, :, 0, :] for name in COMPARED_OUTCOME_NAMES}
    ahead = np.cos(np.radians(np.nan_to_num(in_space["fall_azimuth"])))
    sides = np.where(in_space["overturned"] == 1, np.round(ahead), in_space["overturned"])
    np.testing.assert_array_equal(sides, plane["overturned"])
    assert (plane["overturned"] != 0).any()
    stood = plane["overturned"] == 0
    peak = plane["peak_rotation"] * np.degrees(np.arctan(reshape_b_over_h_to_broadcast(grid)))
    np.testing.assert_allclose(in_space["peak_tilt"][stood], peak[stood], rtol=1e-6)
    # Both errors are relative to the same work, or to the same energy barrier if that is larger.
    np.testing.assert_allclose(in_space["energy_error"], plane["energy_error"], rtol=0.02, atol=1e-8)


def reshape_b_over_h_to_broadcast(grid: dict[str, list[float]]) -> np.ndarray:
    """Return the B/H of a grid of cases as an array that broadcasts over the outcomes of the 2-D model."""
    return np.array(grid["b_over_h"])[None, None, :, None]


def test_orientations_that_symmetry_makes_equal_are_computed_once() -> None:
    motion = strong_part_of_record_with_artificial_vertical(10)
    grid = {"height": [0.6], "b_over_h": [0.25], "friction": [0.6], "aspect": [1.0, 2.0]}
    found = simulate_as_arrays(motion, RECTANGLE, orientation_deg=[20.0, 110.0, 200.0, 380.0], **grid)
    assert (found["block_steps"][:, 0, 0, 0, 0] > 0).tolist() == [True, False, False, False]
    assert (found["block_steps"][:, 0, 0, 1, 0] > 0).tolist() == [True, True, False, False]
    every = simulate_as_arrays(motion, RECTANGLE, orientation_deg=[20.0, 110.0, 200.0, 380.0], leave_out=False, **grid)
    np.testing.assert_array_equal(found["overturned"], every["overturned"])
    np.testing.assert_array_equal(found["fall_face"], every["fall_face"])
    np.testing.assert_allclose(found["fall_azimuth"], every["fall_azimuth"], atol=0.1)


def test_results_do_not_depend_on_order_threads_or_other_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    motion = strong_part_of_record_with_artificial_vertical(10)
    grid = {"height": [0.5, 0.8], "b_over_h": [0.2, 0.35], "friction": [0.5]}
    turned = np.arange(0.0, 90.0, 6.0)
    whole = simulate_as_arrays(motion, RECTANGLE, orientation_deg=turned, **grid)
    threaded = simulate_as_arrays(motion, RECTANGLE, orientation_deg=turned[::-1], threads=2, **grid)
    monkeypatch.setattr(run_module, "MAX_CASES_PER_KERNEL_CALL", 3)
    few = simulate_as_arrays(motion, RECTANGLE, orientation_deg=turned[::5], **grid)
    for name in COMPARED_OUTCOME_NAMES:
        np.testing.assert_array_equal(whole[name], threaded[name][::-1])
        np.testing.assert_array_equal(whole[name][::5], few[name])
    cell = trajectory(motion, RECTANGLE, orientation_deg=6.0, height=0.5, b_over_h=0.2, friction=0.5)
    for name in COMPARED_OUTCOME_NAMES:
        np.testing.assert_array_equal(float(cell[name]), float(whole[name][1, 0, 0, 0, 0]))


SHAPES_WITH_B_OVER_H_AND_D_OVER_B = [
    (RectangularPrism(), 0.4, 1.0),
    (RectangularPrism(), 1.5, 2.0),
    (RegularPrism(5), 0.3, 1.0),
    (Cylinder(), 0.5, 1.0),
]


@pytest.mark.long
@pytest.mark.parametrize(
    ("shape", "ratio", "aspect"),
    SHAPES_WITH_B_OVER_H_AND_D_OVER_B,
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_vibrations_grow_with_steps_above_the_stable_limit_and_not_below(
    shape: object, ratio: float, aspect: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(balance, "MAX_RERUNS_UNTIL_ENERGY_BALANCES", 0)  # a rerun with finer steps would be stable
    body = shape.solid(0.6, ratio, aspect)
    normal, _, dashpot = SOFT_CONTACT.corner_stiffness_and_damping_per_mass(body)
    mode = largest_squared_frequency_on_springs_of_any_face(body)
    limit = float(
        longest_stable_or_accurate_step(IntegrationScheme.CUNDALL, np.array(normal * mode), np.array(dashpot * mode))
    )
    sunk = STANDARD_GRAVITY / (body.base_vertex_count * normal)
    for share, grows in ((0.95, False), (1.05, True)):
        # One step per sample, since a plan would refuse a longer step; all contacts stay closed.
        motion = motion_at_rest(400 * share * limit, share * limit)
        slow = 1e-4 * sunk * np.sqrt(normal)
        turning = tuple(slow / body.centre_height * np.array([1.0, 0.7, 0.3]))
        start = InitialState(
            (0.0, 0.0, body.centre_height - sunk), (1.0, 0.0, 0.0, 0.0), (slow, 0.5 * slow, 0.2 * slow), turning
        )
        cases = Cases(0.0, 0.6, ratio, 10.0, aspect=aspect)
        plan = plan_simulation(
            Body(shape, SOFT_CONTACT, start), motion, cases, NumericalOptions(scheme="cundall", leave_out=False)
        )
        one, only = replace(plan, steps_per_sample=np.ones(1, np.int64)), np.zeros(1, np.int64)
        path = one.simulate_group_with_reruns_on_energy_error(
            only, np.zeros(1, np.int64), np.zeros(400, TRAJECTORY_ROW_DTYPE)
        )[1]
        moves = sum(
            np.max([np.abs(path[name]) for name in names], axis=0) for names in (("vx", "vy", "vz"), ("wx", "wy", "wz"))
        )
        late, early = moves[300:380].max(), moves[1:20].max()
        assert (not late < 10.0 * early) == grows, (share, early, late)


def test_no_contact_frequency_on_an_edge_or_vertex_exceeds_that_on_the_base() -> None:
    body = RectangularPrism().solid(0.6, 0.4, 1.3)
    whole = largest_squared_frequency_on_springs_of_any_face(body)
    for kept in ([0, 1], [1, 2], [2]):
        part_of = replace(
            body,
            contact_points_from_centre_of_mass=body.contact_points_from_centre_of_mass[[0, 1, 2, 3]],
            point_indices_by_non_base_contact_face=(np.array(kept),),
        )
        assert largest_squared_frequency_on_springs_of_any_face(part_of) == whole
    # On a single vertex: mass and inertia reduced to it.
    r = body.contact_points_from_centre_of_mass[0]
    cross = np.array([[0, r[2], -r[1]], [-r[2], 0, r[0]], [r[1], -r[0], 0]])
    alone = np.linalg.eigvalsh(np.eye(3) + cross @ np.linalg.inv(body.inertia_per_mass) @ cross.T).max()
    assert 1.0 < alone < whole


def test_a_case_whose_energy_does_not_balance_is_rerun_with_shorter_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = {"orientation_deg": np.arange(0.0, 90.0, 15.0), "height": [0.6], "b_over_h": [0.2, 0.35], "friction": [0.4]}
    first, finer = (
        simulate_as_arrays(strong_part_of_record_with_artificial_vertical(10), "rectangle", refinement=times, **grid)
        for times in (1, balance.STEP_DIVISOR_PER_RERUN)
    )
    bound = float(np.median(first["energy_error"]))
    monkeypatch.setattr(balance, "MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO", bound)
    monkeypatch.setattr(balance, "MAX_RERUNS_UNTIL_ENERGY_BALANCES", 1)
    found, again = (
        simulate_as_arrays(strong_part_of_record_with_artificial_vertical(10), "rectangle", **grid),
        first["energy_error"] > bound,
    )
    never = again & (finer["energy_error"] > bound)
    np.testing.assert_array_equal(found["status"] == CaseStatus.UNSTABLE, never)
    for name in (*COMPARED_OUTCOME_NAMES, "block_steps"):
        expected = np.where(again, finer[name] + (first[name] if name == "block_steps" else 0), first[name])
        np.testing.assert_array_equal(found[name][~never], expected[~never], err_msg=name)
    cell = {"orientation_deg": 15.0, "height": 0.6, "b_over_h": 0.2, "friction": 0.4}
    path = trajectory(strong_part_of_record_with_artificial_vertical(10), "rectangle", **cell)
    assert path.attrs["block_steps"] == found["block_steps"][1, 0, 0, 0, 0]
    assert (np.diff(path.time) > 0).all()
    # A case that never balances is marked.
    monkeypatch.setattr(balance, "MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO", -1.0)
    marked = simulate_as_arrays(
        strong_part_of_record_with_artificial_vertical(10),
        "rectangle",
        **{name: [value] for name, value in cell.items()},
    )
    assert (marked["status"].item(), marked["overturned"].item()) == (CaseStatus.UNSTABLE, INT8_MISSING)
    assert np.isnan(marked["fall_azimuth"].item())


@PARAMETRIZE_SCHEME
def test_energy_and_angular_momentum_balance_on_real_records(scheme: str) -> None:
    for number in (2, 10):
        found = simulate_as_arrays(
            strong_part_of_record_with_artificial_vertical(number),
            "rectangle",
            orientation_deg=np.arange(0.0, 90.0, 18.0),
            height=[0.6],
            b_over_h=[0.15, 0.3, 0.45],
            friction=[0.3, 0.6],
            scheme=scheme,
        )
        assert found["energy_error"].max() < 1e-2
        assert found["angular_momentum_error"].max() < (1e-9 if scheme == "cundall" else 1e-3)
        assert (found["status"] == 0).all()


@pytest.mark.long
def test_both_integration_schemes_find_nearly_the_same_falls_of_a_body() -> None:
    motion, turned = strong_part_of_record_with_artificial_vertical(10), np.arange(0.0, 90.0, 15.0)
    grid = {"orientation_deg": turned, "height": [0.6], "b_over_h": [0.2, 0.4], "friction": [0.6]}
    found = {
        scheme: simulate_as_arrays(motion, "rectangle", scheme=scheme, **grid) for scheme in ("centred", "cundall")
    }
    fell = found["centred"]["overturned"] == 1
    assert fell.any()
    assert (found["centred"]["overturned"] == found["cundall"]["overturned"]).mean() > 0.9
    azimuths = [np.radians(one["fall_azimuth"][fell & (found["cundall"]["overturned"] == 1)]) for one in found.values()]
    assert np.median(np.abs(np.angle(np.exp(1j * (azimuths[0] - azimuths[1]))))) < np.radians(2.0)


@pytest.mark.parametrize(("peak", "height", "b_over_h"), [(3.0, 1.2, 0.25), (4.5, 1.2, 0.4)])
def test_a_cylinder_that_wobbles_on_its_rim_counts_as_standing(peak: float, height: float, b_over_h: float) -> None:
    """A base that moves in a circle makes the cylinder roll round; its tilt then repeats without loss for minutes."""
    time = np.arange(300) * 0.01
    radius, turn = peak * np.minimum(time, 1.0) * (time < 2.5), 4.0 * np.pi * time
    north, east = (np.append(radius * wave(turn), np.zeros(2000)) for wave in (np.cos, np.sin))
    case: dict[str, Any] = {"height": height, "b_over_h": b_over_h, "friction": 0.8}
    short = Motion(north[:300], east[:300], sampling_interval=0.01)
    found = simulate(short, "circle", orientation_deg=[0.0], **case)
    assert found.status.item() == CaseStatus.SIMULATED
    assert found.overturned.item() == 0
    path = trajectory(Motion(north, east, sampling_interval=0.01), "circle", orientation_deg=0.0, **case)
    tilt = np.arcsin(np.hypot(path.tilt_north, path.tilt_east).to_numpy())
    peaks = [tilt[(path.time > begin) & (path.time < begin + 4.0)].max() for begin in (4.0, 10.0, 16.0)]
    np.testing.assert_allclose(peaks, peaks[0], rtol=5e-3)
    assert peaks[0] > 0.03  # it does not come to rest


SLIDING_PULSE = 5.0 * np.sin(0.5 * np.pi * 0.005 * np.arange(401))
"""Acceleration of the base that makes a body slide for long, m/s²; a sample every 0.005 s."""


@cache
def outcomes_of_sliding_body_by_friction(shape: str | int) -> xr.Dataset:
    """Return the outcomes of a body that slides under `SLIDING_PULSE`, for several coefficients of friction."""
    motion = Motion(0.6 * SLIDING_PULSE, 0.8 * SLIDING_PULSE, sampling_interval=0.005)
    axes = {"height": [0.6], "b_over_h": [0.3], "friction": [0.002, 0.01, 0.02]}
    return simulate(motion, shape, orientation_deg=[20.0], **axes)


@pytest.mark.parametrize("shape", ["rectangle", "circle", 6])
@pytest.mark.parametrize("friction", [0.002, 0.01, 0.02])
def test_a_body_that_slides_for_long_is_simulated_to_its_stop(friction: float, shape: str | int) -> None:
    """The body slides for 10 s to 3 min, longer than the usual end of a case, 20/p (Housner's p) after the record."""
    found = outcomes_of_sliding_body_by_friction(shape).sel(friction=friction)
    peak, residual = peak_and_final_slip(SLIDING_PULSE, 0.005, friction)
    assert found.overturned.item() == 0
    assert found.peak_slip.item() == pytest.approx(peak, rel=5e-3)
    assert found.residual_slip_north.item() == pytest.approx(0.6 * residual, rel=5e-3)
    assert found.residual_slip_east.item() == pytest.approx(0.8 * residual, rel=5e-3)


def reference_stopping_displacement_of_sliding_plate(
    corners: np.ndarray, gyration: float, friction: float, start: np.ndarray
) -> np.ndarray:
    """Return the displacement (m) and rotation (rad) over which friction stops a plate with n equal loads.

    `start` has the velocity along x and y (m/s) and the angular velocity (rad/s).
    """

    def sliding_plate_state_derivative(_: float, state: np.ndarray) -> np.ndarray:
        """Return the time derivative of the plate's state: position, rotation, velocity and angular velocity."""
        cosine, sine = np.cos(state[2]), np.sin(state[2])
        arms = corners @ np.array([[cosine, sine], [-sine, cosine]])
        along = state[3:5] + state[5] * np.column_stack([-arms[:, 1], arms[:, 0]])
        drag = -friction * STANDARD_GRAVITY * along / np.maximum(np.linalg.norm(along, axis=1), 1e-9)[:, None]
        moment = (arms[:, 0] * drag[:, 1] - arms[:, 1] * drag[:, 0]).mean() / gyration**2
        return np.concatenate([state[3:], drag.mean(axis=0), [moment]])

    def remaining_speed(_: float, state: np.ndarray) -> float:
        """Return the speed of sliding and rotation minus a small bound; the plate stops where it is 0."""
        return float(np.hypot(state[3], state[4]) + gyration * abs(state[5])) - 1e-5

    remaining_speed.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(
        sliding_plate_state_derivative,
        (0.0, 1e4),
        np.append(np.zeros(3), start),
        events=remaining_speed,
        rtol=1e-8,
        atol=1e-9,
    )
    return np.asarray(found.y[:3, -1])


@cache
def outcomes_of_spinning_plate_by_friction(speed: float, spin: float, aspect: float) -> xr.Dataset:
    """Return the outcomes of a plate that starts with a velocity and a rotation, for two coefficients of friction."""
    start = InitialState((0.0, 0.0, 0.05), (1.0, 0.0, 0.0, 0.0), (speed, 0.0, 0.0), (0.0, 0.0, spin))
    return simulate(
        motion_at_rest(0.1), Body("rectangle", start=start), orientation_deg=[0.0], height=[0.1], b_over_h=[5.0],
        friction=[0.005, 0.02], aspect=[aspect], leave_out=False,
    )  # fmt: skip


@pytest.mark.parametrize("friction", [0.005, 0.02])
@pytest.mark.parametrize(("speed", "spin", "aspect"), [(2.0, 0.5, 1.0), (1.0, 3.0, 1.0), (0.1, 1.5, 20.0)])
def test_a_body_that_slides_and_spins_for_long_is_simulated_to_its_stop(
    friction: float, speed: float, spin: float, aspect: float
) -> None:
    """The body slides and spins for 5 s to 40 s, and stops where a plate with equal loads on its corners would stop."""
    found = outcomes_of_spinning_plate_by_friction(speed, spin, aspect).sel(friction=friction)
    corners = 0.25 * np.array([[1.0, aspect], [1.0, -aspect], [-1.0, -aspect], [-1.0, aspect]])
    gyration = 0.5 * np.sqrt((1.0 + aspect**2) / 12.0)
    along, left, turned = reference_stopping_displacement_of_sliding_plate(
        corners, gyration, friction, np.array([speed, 0.0, spin])
    )
    assert found.overturned.item() == 0
    assert found.residual_slip_north.item() == pytest.approx(along, rel=0.01)
    assert found.residual_slip_east.item() == pytest.approx(-left, abs=0.01 * along)
    assert found.residual_twist.item() == pytest.approx((-np.degrees(turned) + 180.0) % 360.0 - 180.0, abs=3.0)


@pytest.mark.parametrize(
    ("shape", "options"),
    [("rectangle", {"orientation_deg": [0.0]}), ("circle", {"orientation_deg": [0.0]}),
     (None, {"azimuth_deg": [0.0]}), (None, {"azimuth_deg": [0.0], "scheme": "cundall"})],
)  # fmt: skip
def test_a_stone_in_the_air_at_the_end_of_the_record_is_undecided(shape: str | None, options: dict[str, Any]) -> None:
    """The base falls twice as fast as the stone for 2 s, so the stone is 20 m above it, upright, as the record ends."""
    up, along = np.full(200, -20.0), 0.5 * np.sin(0.08 * np.arange(200))
    motion = Motion(along, 0.0 * along, up, sampling_interval=0.01, trust_data=True)
    found = simulate(motion, shape, height=[0.6], b_over_h=[0.2], friction=[0.5], **options)
    assert found.status.item() == CaseStatus.UNDECIDED
    assert np.isnan(found.overturned.item())
