"""How each case in space is to be computed: its body, contact and steps, and the time that can be left out."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.cases import SpaceCases
from overturning.dem.body.results import SpaceResults
from overturning.dem.body.rules import BODY, CASE, RESULT, ROW, START, BodyRules, Rim, Vertices
from overturning.dem.body.statics import highest_mode, rest
from overturning.dem.body.steps import pace_of
from overturning.dem.kernel.balance import until_balanced
from overturning.dem.kernel.clock import BODY as PACE
from overturning.dem.kernel.ground import Ground
from overturning.dem.kernel.queue import run_queue
from overturning.dem.numerics import BODY_STEP, Numerics
from overturning.dem.plan import AFTERMATH, DEEPEST, check_path, most_rows, sinks_too_far
from overturning.dem.quiet import quiet_windows
from overturning.dem.time_step import Scheme, scheme_of
from overturning.errors import ArgumentError
from overturning.model.contact import VertexContact, check_precision
from overturning.model.shapes import Shape
from overturning.model.solid import Solid
from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING
from overturning.motion.direction import direction_cosines
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY


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
    queue: ClassVar[Any] = staticmethod(run_queue)

    motion: Motion
    numerics: Numerics
    shape: Shape
    made: list[Solid]
    bodies: NDArray[np.void]  # table of bodies, of `overturning.dem.body.rules.BODY`
    points: FloatArray  # shape (bodies, vertices, 3): from the centre, m
    orientation: FloatArray  # shape (n,), degrees
    cosines: FloatArray  # shape (n, 2): of the orientation, north and east
    row: NDArray[np.int64]  # shape (n,): row of `along`
    along: FloatArray  # shape (orientations, 2, samples + 3): acceleration of the base along x and y, m/s²
    steps: NDArray[np.int64]  # shape (n,), per sample
    first: NDArray[np.int64]  # shape (n,): sample from which it is computed
    never: NDArray[np.bool_]  # shape (n,): below the thresholds of rocking and sliding for the whole record
    hopeless: NDArray[np.bool_]  # shape (n,): the weight alone `sinks_too_far`; no answer, and not computed
    table: NDArray[np.void]  # shape (n,): the kernel's cases, of `overturning.dem.body.rules.CASE`

    @property
    def group(self) -> NDArray[np.int64]:
        """Cases with the same number share a queue."""
        return self.steps

    @property
    def kind(self) -> Any:
        """Mark of the bodies, by which the kernel takes its loops."""
        return Rim() if self.made[0].radius > 0 else Vertices()

    def uncomputed(self) -> SpaceResults:
        """Results of all cases as long as none is computed: at rest, or without an answer."""
        results = SpaceResults.at_rest(self.never.size)
        results.status[self.hopeless], results.overturned[self.hopeless] = Status.UNSTABLE, INT8_MISSING
        return results

    def compute(
        self, chosen: NDArray[np.int64], counter: NDArray[np.int64], path: NDArray[np.void] | None = None
    ) -> tuple[NDArray[np.void], NDArray[np.void]]:
        """Results of chosen cases with the same steps per sample, finer of those that do not balance; rows of the first one's path."""
        motion, out, table = self.motion, np.zeros(chosen.size, RESULT), self.table[chosen]
        up = np.zeros(motion.samples + 3)
        if motion.up is not None:
            up[: motion.samples] = motion.up
        kept = np.zeros(0, ROW)

        def run(rows: NDArray[np.int64], finer: int) -> None:
            nonlocal kept
            cases = table.copy()
            # The shortest step is in ticks, which shrink with the whole one.
            cases["dwell"] *= finer
            rules = BodyRules(
                kind=self.kind,
                cases=cases,
                row=self.row[chosen],
                bodies=self.bodies,
                points=self.points,
                base=self.made[0].base,
                results=out,
                ground=Ground(self.along, up, motion.samples, motion.sampling_interval),
                at_once=int(self.steps[chosen[0]]) * finer,
                budget=self.numerics.budget // BODY_STEP,
                most_rows=most_rows(ROW),
            )
            kept, noted = self.queue(rules, rows, counter, np.zeros(0, ROW) if path is None else path)
            if noted < 0:  # there was no room
                check_path(2 * kept.nbytes // 8)
            kept = kept[:noted]

        until_balanced(run, out["status"], out["energy"])
        return out, kept

    def store(self, results: SpaceResults, chosen: NDArray[np.int64], out: NDArray[np.void]) -> None:
        """Put what the kernel found into the results."""
        faces = [self.made[index].faces for index in self.table["body"][chosen]]
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
    if scheme_of(numerics.scheme) != Scheme.CENTRED:
        raise ArgumentError(f"scheme: {numerics.scheme!r}; a body in space has 'centred' alone")
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
    pace = pace_of(numerics, square[which], dashpot * modes[which], interval, period[which])
    friction, amplitude = np.asarray(cases.friction), np.asarray(cases.amplitude)
    row, cosines, along = _shaking(motion, cases)
    first, calm, never = np.zeros(cases.size, np.int64), np.full(cases.size, np.inf), np.zeros(cases.size, np.bool_)
    if numerics.leave_out and start is None:
        # Uplift over the nearest edge needs the least; between samples the length of the vector is convex, and so largest at one.
        strongest = np.sqrt(motion.north**2 + motion.east**2)[None, :]
        threshold = np.minimum((reach / foot)[which], friction)
        first, quiet, never = quiet_windows(motion, np.zeros(cases.size, np.int64), amplitude, strongest, threshold)
        calm = quiet.astype(np.float64)
    table = np.zeros(cases.size, CASE)
    columns = {
        "body": which,
        "stiffness": laws[which, 0],
        "tangential": laws[which, 1],
        "dashpot": dashpot,
        "friction": friction,
        "amplitude": amplitude,
        "first": first,
        "calm": calm,
        "after": samples + np.ceil(AFTERMATH * period[which] / interval),
        "finest": pace.finest,
        "standing": PACE.whole,
        "dwell": pace.dwell,
        "settled": PACE.settled,
    }
    for name, values in columns.items():
        table[name] = values
    poses = [rest(body, float(law[0])) for body, law in zip(made, laws, strict=True)]
    sunk = np.array([_deepest(body, pose) for body, pose in zip(made, poses, strict=True)])
    if start is None:
        table["start"] = np.array([_at_rest(pose) for pose in poses])[which]
    else:
        table["start"] = (*start.place, *start.quaternion, *start.velocity, *start.angular_velocity)
    bodies, points = _bodies(made)
    return SpacePlan(
        motion=motion, numerics=numerics, shape=shape, made=made, bodies=bodies, points=points, cosines=cosines,
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


def _deepest(body: Solid, pose: FloatArray) -> float:
    """How far the deepest vertex of its base has sunk in, m, in the pose at rest."""
    x, y = body.points[: body.base, :2].T
    return float(np.max(body.foot - pose[2] - (pose[3] * y - pose[4] * x)))


def _at_rest(pose: FloatArray) -> NDArray[np.void]:
    """Place, rotation and velocities of a body at rest on its springs, of `START`, from its `rest`."""
    half = 0.5 * pose[3:]
    begin = np.zeros((), START)
    begin["x"], begin["y"], begin["z"] = pose[:3]
    begin["qw"], begin["qx"], begin["qy"], begin["qz"] = np.array([1.0, *half]) / np.sqrt(1.0 + np.sum(half * half))
    return begin


def _bodies(made: list[Solid]) -> tuple[NDArray[np.void], FloatArray]:
    """The kernel's table of bodies and their vertices, which are made even in number by one at the centre that never touches."""
    count = len(made[0].points)
    points, table = np.zeros((len(made), count + count % 2, 3)), np.zeros(len(made), BODY)
    pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    for index, body in enumerate(made):
        points[index, :count] = body.points
        for name, at in pairs.items():
            table[index][f"i{name}"], table[index][f"a{name}"] = body.inverse_inertia[at], body.inertia[at]
        foot, reach = body.foot, body.reach
        values = {
            "foot": foot, "radius": body.radius, "reach": reach, "critical": reach**2 / (reach**2 + foot**2),
            "fallen": np.round(np.cos(body.fallen), 12), "deepest": DEEPEST * min(reach, foot),
            "ends": body.ends,
        }  # fmt: skip
        for name, value in values.items():
            table[index][name] = value
    return table, points
