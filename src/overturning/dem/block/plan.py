"""How the block's kernel is to compute each case: its contact, its steps, and the time that can be left out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.block import tables as k
from overturning.dem.block.path import block_path
from overturning.dem.block.queue import SCHEMES, Limits, run_queue
from overturning.dem.block.rows import DWELL, FINEST, GENTLE, MOST_HALVINGS, RIGID, SETTLED_DWELL, TICKS
from overturning.dem.block.verdict import GOES_ON
from overturning.dem.cases import Cases
from overturning.dem.contact import check_precision
from overturning.dem.numerics import Numerics
from overturning.dem.plan import (
    AFTERMATH,
    DEEPEST,
    Path,
    Plan,
    check_path,
    rounded,
    shaking,
    sinks_too_far,
    until_balanced,
)
from overturning.dem.quiet import quiet_windows
from overturning.dem.results import Answers
from overturning.dem.scene import Scene
from overturning.dem.single_body import Ground
from overturning.dem.time_step import (
    Scheme,
    contact_time,
    highest_eigenvalue,
    rocking_time,
    scheme_of,
    shortening,
    stable_step,
    steps_per_sample,
)
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY


@dataclass(frozen=True, kw_only=True)
class BlockPlan(Plan):
    """How each case of a single block is to be computed.

    Attributes
    ----------
    table : ndarray, shape (n, PARAMETERS)
        The kernel's case table.
    friction : ndarray, shape (n,)
        μ.
    """

    table: FloatArray
    friction: FloatArray

    @property
    def group(self) -> NDArray[np.int64]:
        """Cases with equal steps, standing and not, all with friction or all without, share a queue."""
        of_all = np.stack([self.steps, self.table[:, k.P_STANDING], self.friction == 0])
        return np.asarray(np.unique(of_all, axis=1, return_inverse=True)[1]).ravel()

    def compute(
        self, chosen: NDArray[np.int64], counter: NDArray[np.int64], path: FloatArray
    ) -> tuple[Answers, FloatArray]:
        """Run cases with the same steps per sample, all with friction or all without; finer those that do not balance."""
        motion, out = self.motion, np.zeros((chosen.size, k.RESULTS))
        upward = None if motion.up is None else np.concatenate([motion.up, np.zeros(3)])
        ground = Ground(self.ground, upward, motion.samples, motion.sampling_interval)
        limits = Limits(STANDARD_GRAVITY, DEEPEST, self.numerics.budget)
        friction = self.friction[chosen] if self.friction[chosen[0]] > 0 else None
        noted = path

        def run(rows: NDArray[np.int64], finer: int) -> None:
            nonlocal noted
            table = self.table[chosen]
            # The shortest step is in ticks, which shrink with the whole one.
            table[:, [k.P_DWELL, k.P_SETTLED]] *= finer
            table[:, k.P_GENTLE] /= finer
            noted = run_queue(
                SCHEMES[self.scheme][0], rows, table, self.row[chosen], friction, ground, int(self.steps[chosen[0]]) * finer,
                limits, counter, path, out,
            )  # fmt: skip

        until_balanced(run, out, k.R_STATUS, k.R_ENERGY)
        if out[0, k.R_STATUS] == GOES_ON:  # its path is full
            check_path(2 * noted.size)
        of_all = (out[:, column] for column in (k.R_STATUS, k.R_DEPTH, k.R_ENERGY, k.R_STEPS))
        each = (out[:, [column]] for column in (k.R_SIDE, k.R_TIME, k.R_ANGLE, k.R_SLIP, k.R_RESIDUAL))
        return Answers(*of_all, *each), noted

    def trace(self) -> tuple[Answers | None, Path]:
        """Answers and path of a plan's only case."""
        answers, path = None, np.zeros((0, k.TRAJECTORY))
        if not (self.never[0] or self.hopeless[0]):
            room = np.zeros((self.motion.samples, k.TRAJECTORY))
            answers, path = self.compute(np.zeros(1, np.int64), np.zeros(1, np.int64), room)
        rest = np.zeros((self.motion.samples if answers is None else int(self.first[0]), k.TRAJECTORY))
        rest[:, k.T_TIME] = np.arange(len(rest)) * self.motion.sampling_interval
        depth = 0.5 * STANDARD_GRAVITY / self.table[0, k.P_STIFFNESS]
        rest[:, k.T_Z] = 0.5 * self.table[0, k.P_HEIGHT] - depth
        rest[:, k.T_GROUND] = self.ground[0, : len(rest)] * self.table[0, k.P_AMPLITUDE]
        return answers, block_path(
            self.scene, self.motion, self.cases, np.concatenate([rest, path]), self.table[0, k.P_ALPHA]
        )


def plan_block(scene: Scene, motion: Motion, cases: Cases, numerics: Numerics) -> BlockPlan:
    """Check the arguments and work out what each case of a single block needs.

    Parameters
    ----------
    scene : Scene
        Of a single block, whose contact law and density count; height and B/H are those of the cases.
    motion, cases, numerics
        As of `overturning.dem.run.run`.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    ground_element, block = scene.elements
    law, density = scene.law(ground_element, block), scene.materials[block.material].density
    scheme = scheme_of(numerics.scheme)
    height, ratio = np.asarray(cases.height), np.asarray(cases.b_over_h)
    friction = np.asarray(cases.friction) if law.friction is None else np.full(cases.size, law.friction)
    amplitude, tilt = np.asarray(cases.amplitude), np.asarray(cases.initial_tilt)
    width = ratio * height
    normal, tangential, dashpot = law.contact.specific(width, height, density)
    dashpot = dashpot * np.asarray(cases.damping_factor)
    row, ground = shaking(motion, cases)
    check_precision(normal, height, 0.0)
    square = highest_eigenvalue(normal, tangential, 0.5 * width, 0.5 * height)
    rate = highest_eigenvalue(dashpot, dashpot, 0.5 * width, 0.5 * height)
    period = rocking_time(width, height)
    interval, samples = motion.sampling_interval, motion.samples
    steps = steps_per_sample(scheme, numerics.time_step, square, rate, interval, period) * numerics.refinement
    standing = np.ones_like(steps)
    if scheme == Scheme.CENTRED:
        # Samples are steps enough while a block stands on a contact that is rigid to them, each divided where steps are wanted shorter.
        usual = steps_per_sample(scheme, "auto", square, rate, interval, period)
        standing = np.where(np.sqrt(square) * interval >= RIGID, np.gcd(usual, steps), 1)
    # A step that is wanted shorter has a shorter finest one, too.
    shorter = shortening(scheme, numerics.time_step, stable_step(scheme, square, rate, period)) / numerics.refinement
    finest = FINEST * shorter * contact_time(square, rate)
    halvings = np.frexp(interval / steps / finest)[1].astype(np.int64)
    if scheme == Scheme.CENTRED:
        # Where that many halvings are not to be had, the whole step is shorter.
        steps = steps << np.maximum(halvings - MOST_HALVINGS, 0)
    first, calm, never = np.zeros(cases.size, np.int64), np.full(cases.size, np.inf), np.zeros(cases.size, np.bool_)
    if numerics.leave_out:
        first, quiet, never = quiet_windows(motion, row, amplitude, ground[:, :samples], np.minimum(ratio, friction))
        first[tilt != 0], never[tilt != 0] = 0, False
        calm = quiet.astype(np.float64)
    columns = {
        k.P_WIDTH: width,
        k.P_HEIGHT: height,
        k.P_STIFFNESS: normal,
        k.P_TANGENTIAL: tangential,
        k.P_DASHPOT: dashpot,
        k.P_ALPHA: rounded(np.arctan, ratio),
        k.P_AMPLITUDE: amplitude,
        k.P_TILT: tilt,
        k.P_TILT_COS: rounded(np.cos, tilt),
        k.P_TILT_SIN: rounded(np.sin, tilt),
        k.P_FIRST: first,
        k.P_CALM: calm,
        k.P_AFTER: samples + np.ceil(AFTERMATH * period / interval),
        k.P_FINEST: np.ldexp(1.0, MOST_HALVINGS - np.clip(halvings, 0, MOST_HALVINGS)),
        # A lightly damped contact rings for longer.
        k.P_DWELL: np.round(DWELL * np.clip(np.sqrt(square) / np.maximum(rate, 1e-300), 1.0, 8.0) / shorter),
        k.P_SETTLED: np.round(SETTLED_DWELL / shorter),
        k.P_STANDING: TICKS * standing,
        k.P_GENTLE: GENTLE * finest * width * rounded(np.arctan, ratio) / period,
    }
    table = np.zeros((cases.size, k.PARAMETERS))
    for column, values in columns.items():
        table[:, column] = values
    return BlockPlan(
        scene=scene, motion=motion, cases=cases, numerics=numerics, scheme=scheme, row=row, ground=ground, steps=steps,
        first=first, never=never, table=table, friction=friction,
        hopeless=sinks_too_far(0.5 * STANDARD_GRAVITY / normal, np.minimum(width, height)),
    )  # fmt: skip
