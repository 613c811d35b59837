"""How each case in space is to be computed: its body, contact and steps, and the time that can be left out."""

from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.contact import check_precision
from overturning.dem.numerics import BODY_STEP, Numerics
from overturning.dem.plan import AFTERMATH, DEEPEST, check_path, sinks_too_far, until_balanced
from overturning.dem.quiet import quiet_windows
from overturning.dem.single_body import Ground
from overturning.dem.solid import tables as k
from overturning.dem.solid.body import Body
from overturning.dem.solid.cases import SpaceCases
from overturning.dem.solid.contact import VertexContact, highest_mode, rest
from overturning.dem.solid.queue import SCHEMES, Bodies, Limits, Rim, Vertices, run_queue
from overturning.dem.solid.results import SpaceResults
from overturning.dem.solid.shapes import Shape
from overturning.dem.solid.steps import pace_of
from overturning.dem.solid.verdict import GOES_ON
from overturning.dem.status import Status
from overturning.dem.time_step import Scheme, scheme_of
from overturning.dem.variables import INT8_MISSING
from overturning.motion.direction import direction_cosines
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

SPACE_SCHEMES: Final = ("centred", "cundall")
"""Names of the schemes in space, the default first."""


@dataclass(frozen=True)
class Start:
    """How a body begins, where not at rest: in its own axes turned to its orientation.

    Parameters
    ----------
    place : tuple
        Of the centre, m; z above the base.
    quaternion : tuple
        Rotation from the rest position (w, x, y, z).
    velocity, angular_velocity : tuple
        m/s and rad/s.
    """

    place: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angular_velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class SpacePlan:
    """How each of n cases is to be computed: functions of the case and its motion alone."""

    halved: ClassVar[bool] = True
    free: ClassVar[int] = 1

    motion: Motion
    numerics: Numerics
    scheme: Scheme
    shape: Shape
    made: list[Body]
    bodies: Bodies
    orientation: FloatArray  # shape (n,), degrees
    cosines: FloatArray  # shape (n, 2): of the orientation, north and east
    row: NDArray[np.int64]  # shape (n,): row of `along`
    along: FloatArray  # shape (orientations, 2, samples + 3): acceleration of the base along x and y, m/s²
    steps: NDArray[np.int64]  # shape (n,), per sample
    first: NDArray[np.int64]  # shape (n,): sample from which it is computed
    never: NDArray[np.bool_]  # shape (n,): below the thresholds of rocking and sliding for the whole record
    hopeless: NDArray[np.bool_]  # shape (n,): the weight alone `sinks_too_far`; no answer, and not computed
    table: FloatArray  # shape (n, PARAMETERS): the kernel's case table

    @property
    def group(self) -> NDArray[np.int64]:
        """Cases with the same number share a queue."""
        return self.steps

    def uncomputed(self) -> SpaceResults:
        """Results of all cases as long as none is computed: at rest, or without an answer."""
        results = SpaceResults.at_rest(self.never.size)
        results.status[self.hopeless], results.overturned[self.hopeless] = Status.UNSTABLE, INT8_MISSING
        return results

    def compute(
        self, chosen: NDArray[np.int64], counter: NDArray[np.int64], path: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Results of chosen cases with the same steps per sample, finer of those that do not balance; rows of the first one's path."""
        motion, out = self.motion, np.zeros((chosen.size, k.RESULTS))
        up = np.zeros(motion.samples + 3)
        if motion.up is not None:
            up[: motion.samples] = motion.up
        ground, noted = Ground(self.along, up, motion.samples, motion.sampling_interval), path

        def run(rows: NDArray[np.int64], finer: int) -> None:
            nonlocal noted
            table = self.table[chosen]
            # The shortest step is in ticks, which shrink with the whole one.
            table[:, k.P_DWELL] *= finer
            noted = run_queue(
                SCHEMES[self.scheme][0], Rim() if self.bodies.round else Vertices(), rows, table, self.row[chosen], self.bodies, ground,
                int(self.steps[chosen[0]]) * finer, Limits(STANDARD_GRAVITY, self.numerics.budget // BODY_STEP), counter, path, out,
            )  # fmt: skip

        until_balanced(run, out, k.R_STATUS, k.R_ENERGY)
        if out[0, k.R_STATUS] == GOES_ON:  # its path is full
            check_path(2 * noted.size)
        return out, noted

    def store(self, results: SpaceResults, chosen: NDArray[np.int64], out: FloatArray) -> None:
        """Put what the kernel found into the results."""
        body = self.table[chosen, k.P_BODY].astype(np.int64)
        faces = [self.made[index].faces for index in body]
        results.store(chosen, out, self.orientation[chosen], self.cosines[chosen], faces)


def plan_in_space(
    shape: Shape,
    motion: Motion,
    cases: SpaceCases,
    numerics: Numerics,
    contact: VertexContact,
    start: Start | None = None,
) -> SpacePlan:
    """Check the arguments and work out what each case needs; parameters and errors as of `run_in_space`."""
    scheme = scheme_of(numerics.scheme)
    sizes, which = np.unique(cases.table[:, 1:4], axis=0, return_inverse=True)
    made = [shape.body(*(float(value) for value in size)) for size in sizes]
    laws = np.array([contact.specific(body) for body in made])
    modes = np.array([highest_mode(body) for body in made])
    foot, reach = np.array([body.foot for body in made]), np.array([body.reach for body in made])
    base = made[0].base
    check_precision(0.5 * base * laws[:, 0], 2.0 * foot, 0.0)
    square = np.maximum(laws[:, 0], laws[:, 1]) * modes
    period = np.sqrt(np.sqrt(foot**2 + reach**2) / (0.75 * STANDARD_GRAVITY))
    interval, samples = motion.sampling_interval, motion.samples
    dashpot = laws[which, 2] * np.asarray(cases.damping_factor)
    pace = pace_of(scheme, numerics, square[which], dashpot * modes[which], interval, period[which])
    friction, amplitude = np.asarray(cases.friction), np.asarray(cases.amplitude)
    row, cosines, along = _shaking(motion, cases)
    first, calm, never = np.zeros(cases.size, np.int64), np.full(cases.size, np.inf), np.zeros(cases.size, np.bool_)
    if numerics.leave_out and start is None:
        # Uplift over the nearest edge needs the least; between samples the length of the vector is convex, and so largest at one.
        strongest = np.sqrt(motion.north**2 + motion.east**2)[None, :]
        threshold = np.minimum((reach / foot)[which], friction)
        first, quiet, never = quiet_windows(motion, np.zeros(cases.size, np.int64), amplitude, strongest, threshold)
        calm = quiet.astype(np.float64)
    table = np.zeros((cases.size, k.PARAMETERS))
    columns = {
        k.P_BODY: which,
        k.P_STIFFNESS: laws[which, 0],
        k.P_TANGENTIAL: laws[which, 1],
        k.P_DASHPOT: dashpot,
        k.P_FRICTION: friction,
        k.P_AMPLITUDE: amplitude,
        k.P_FIRST: first,
        k.P_CALM: calm,
        k.P_FINEST: pace.finest,
        k.P_DWELL: pace.dwell,
        k.P_AFTER: samples + np.ceil(AFTERMATH * period[which] / interval),
    }
    for column, values in columns.items():
        table[:, column] = values
    poses = [rest(body, float(law[0])) for body, law in zip(made, laws, strict=True)]
    sunk = np.array([_deepest(body, pose) for body, pose in zip(made, poses, strict=True)])
    table[:, k.P_START :] = (
        np.array([_at_rest(pose) for pose in poses])[which]
        if start is None
        else [*start.place, *start.quaternion, *start.velocity, *start.angular_velocity]
    )
    return SpacePlan(
        motion=motion, numerics=numerics, scheme=scheme, shape=shape, made=made, bodies=_bodies(made), cosines=cosines,
        orientation=np.asarray(cases.orientation_deg), row=row, along=along, steps=pace.steps, first=first, never=never, table=table,
        hopeless=sinks_too_far(sunk, 2.0 * np.minimum(foot, reach))[which],
    )  # fmt: skip


def _shaking(motion: Motion, cases: SpaceCases) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    """Row of each case, cosines of its orientation, and rows of the base's acceleration along x and y of each orientation."""
    distinct, row = np.unique(np.asarray(cases.orientation_deg), return_inverse=True)
    along = np.zeros((distinct.size, 2, motion.samples + 3))
    cosines = np.array([direction_cosines(float(value)) for value in distinct])
    for index, orientation in enumerate(distinct):
        along[index, 0, : motion.samples] = motion.along(float(orientation))
        along[index, 1, : motion.samples] = motion.along(float(orientation) - 90.0)
    return row, cosines[row], along


def _deepest(body: Body, pose: FloatArray) -> float:
    """How far the deepest vertex of its base has sunk in, m, in the pose at rest."""
    x, y = body.points[: body.base, :2].T
    return float(np.max(body.foot - pose[2] - (pose[3] * y - pose[4] * x)))


def _at_rest(pose: FloatArray) -> FloatArray:
    """Place, quaternion and velocities of a body at rest on its springs, from its `rest`."""
    begin = np.zeros(k.START)
    half = 0.5 * pose[3:]
    begin[:3] = pose[:3]
    begin[3:7] = np.array([1.0, *half]) / np.sqrt(1.0 + np.sum(half * half))
    return begin


def _bodies(made: list[Body]) -> Bodies:
    """The kernel's table of bodies; the vertices are made even in number by one at the centre, which never touches."""
    count = len(made[0].points)
    points = np.zeros((len(made), count + count % 2, 3))
    table = np.zeros((len(made), k.BODY))
    for index, body in enumerate(made):
        points[index, :count] = body.points
        inverse, critical = body.inverse_inertia, body.reach**2 / (body.reach**2 + body.foot**2)
        smallest = min(body.reach, body.foot)
        table[index] = [
            inverse[0, 0], inverse[1, 1], inverse[2, 2], inverse[0, 1], inverse[0, 2], inverse[1, 2], body.foot, body.radius,
            body.reach, critical, np.round(np.cos(body.fallen), 12), DEEPEST * smallest, body.ends,
            body.inertia[0, 0], body.inertia[1, 1], body.inertia[2, 2], body.inertia[0, 1], body.inertia[0, 2], body.inertia[1, 2],
        ]  # fmt: skip
    return Bodies(table, points, made[0].base, made[0].radius > 0)
