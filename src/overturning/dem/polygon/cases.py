"""Many cases of a scene under one motion: planned, shared out to threads, collected in their own order."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.blocks import Cases
from overturning.dem.cases import BUDGET, QUEUE, CaseResults, Progress, check_positive, run_queues, shared_out
from overturning.dem.contact import check_precision
from overturning.dem.plan import AFTERMATH, shaking
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.arrays import kernel_column, kernel_rules, kernel_shapes
from overturning.dem.polygon.prepare import Prepared, prepare
from overturning.dem.polygon.scene import Scene
from overturning.dem.quiet import SAFE_SHARE, quiet_windows
from overturning.dem.status import Status
from overturning.dem.time_step import DEFAULT_SCHEME, Scheme, scheme_of, steps_per_sample
from overturning.dem.variables import INT8_MISSING
from overturning.errors import ArgumentError
from overturning.motion.motion import Motion

SAFE_UPLIFT: Final = 0.7
"""Share of the uplift acceleration of an element alone, below which shaking leaves it standing after another has fallen."""


@dataclass(frozen=True)
class SceneResults(CaseResults):
    """What came of each case.

    Attributes
    ----------
    overturned, overturning_time, peak_rotation, peak_slip, residual_slip : ndarray, shape (n, free elements)
        As in `overturning.dem.cases.CaseResults`, of each free element; α is that of the element alone on what it
        stands on, slip is relative to it.
    status : ndarray of int8, shape (n,)
        A `Status`.
    peak_penetration, energy_error : ndarray of float32, shape (n,)
        Of the whole scene; m, and the residual over the larger of input and the least energy to overturn an element.
    block_steps : ndarray of int64, shape (n,)
        Steps computed, times free elements.
    """


@dataclass(frozen=True)
class ScenePlan:
    """How each case of a scene is to be computed: functions of the case and its record alone."""

    scheme: Scheme
    variants: list[Prepared]
    variant: NDArray[np.int64]
    row: NDArray[np.int64]
    ground: FloatArray
    upward: FloatArray
    steps: NDArray[np.int64]
    table: FloatArray
    never: NDArray[np.bool_]
    layout: NDArray[np.int64]
    sizes: NDArray[np.int64]
    shapes: FloatArray
    initial: FloatArray
    rules: FloatArray
    limits: FloatArray

    @property
    def gravity(self) -> float:
        """Acceleration of gravity, m/s²."""
        return self.variants[0].scene.gravity

    def run(
        self,
        motion: Motion,
        chosen: NDArray[np.int64],
        counter: NDArray[np.int64],
        path: FloatArray,
        budget: int = BUDGET,
    ) -> tuple[FloatArray, FloatArray, int]:
        """Run cases with the same number of steps per sample; results per case, per element, rows of the path."""
        from overturning.dem.polygon.queue import SCHEMES, run_queue

        out = np.zeros((chosen.size, t.RESULTS))
        each = np.zeros((chosen.size, self.sizes.size, t.ELEMENT_RESULTS))
        noted = run_queue(
            SCHEMES[self.scheme][0], np.arange(chosen.size), np.ascontiguousarray(self.table[chosen]), self.row[chosen], self.variant[chosen],
            self.initial, self.layout, self.sizes, self.shapes, self.rules, self.limits, self.ground, self.upward if self.upward.size else None,
            motion.samples, motion.sampling_interval, int(self.steps[chosen[0]]), self.gravity, budget, counter, path,
            out, each,
        )  # fmt: skip
        return out, each, int(noted)


def plan_scene(
    scene: Scene,
    motion: Motion,
    cases: Cases,
    *,
    scheme: str | None = None,
    time_step: float | str = "auto",
    leave_out: bool = True,
    refinement: int = 1,
) -> ScenePlan:
    """Check the arguments and work out what each case needs."""
    method = scheme_of(scheme or DEFAULT_SCHEME)
    if np.asarray(cases.initial_tilt).any():
        raise ArgumentError("initial_tilt: a scene starts at rest; rotate an element in the scene file instead")
    keys = np.stack([np.asarray(cases.height), np.asarray(cases.b_over_h), np.asarray(cases.damping_factor)], axis=1)
    distinct, variant = np.unique(keys, axis=0, return_inverse=True)
    variant = variant.reshape(-1)
    variants = [prepare(scene, float(height), float(ratio)) for height, ratio, _ in distinct]
    for item in variants:
        # As of a block H high: as high as the scene.
        height = max(float(part.points[:, 1].max()) for part in item.placed if not part.fixed)
        check_precision(scene.gravity / (2.0 * item.sunk), np.full(item.sunk.size, height), 0.0)
    if len({(tuple(item.pairs), tuple(item.support.tolist())) for item in variants}) != 1:
        raise ArgumentError(f"scene {scene.name}: different elements can meet at different sizes; sweep them apart")
    row, ground = shaking(motion, cases)
    square = np.array([item.square for item in variants])
    rate = np.array([item.rate for item in variants]) * distinct[:, 2]
    steps = steps_per_sample(method, time_step, square, rate, motion.sampling_interval)[variant] * refinement
    samples = motion.samples
    radius = np.array([item.radius for item in variants])[variant]
    # 20/p with p = √(3g/4R).
    period = np.sqrt(radius / (0.75 * scene.gravity))
    after = samples + np.ceil(AFTERMATH * period / motion.sampling_interval)
    table = np.zeros((cases.size, t.PARAMETERS + len(scene.elements)))
    table[:, t.PARAMETERS :] = np.inf
    table[:, t.P_AMPLITUDE], table[:, t.P_FRICTION] = cases.amplitude, cases.friction
    table[:, t.P_DAMPING], table[:, t.P_AFTER] = cases.damping_factor, after
    never = np.zeros(cases.size, np.bool_)
    table[:, t.P_CALM] = np.inf
    if leave_out:
        rocking = np.array([item.threshold for item in variants])[variant]
        friction = np.array([item.fixed_friction for item in variants])[variant]
        swept = np.array([item.swept_friction for item in variants])[variant]
        friction = np.where(swept, np.minimum(friction, np.asarray(cases.friction)), friction)
        first, calm, never = quiet_windows(
            motion, row, np.asarray(cases.amplitude), ground[:, :samples], np.minimum(rocking, friction)
        )
        moving = np.minimum(rocking, friction) <= 0
        first[moving], never[moving] = 0, False
        table[:, t.P_FIRST], table[:, t.P_CALM] = first, np.where(moving, np.inf, calm)
        for element in variants[0].free:
            # Rounded, since libm differs between processors in the last digit.
            tangent = np.tan(np.array([item.critical[element] for item in variants], dtype=np.float64))
            alone = np.round(tangent, 12)[variant].astype(np.float64)
            weak = quiet_windows(
                motion, row, np.asarray(cases.amplitude), ground[:, :samples], alone * (SAFE_UPLIFT / SAFE_SHARE)
            )
            table[:, t.PARAMETERS + element] = weak[1]
    upward = np.zeros(0) if motion.up is None else np.concatenate([motion.up, np.zeros(3)])
    shaped = [kernel_shapes(item) for item in variants]
    ruled = [kernel_rules(item) for item in variants]
    return ScenePlan(
        method, variants, variant, row, ground, upward, steps, table, never,
        np.array(variants[0].pairs, dtype=np.int64).reshape(-1, 2), shaped[0][0],
        np.stack([shapes for _, shapes in shaped]), np.stack([kernel_column(item) for item in variants]),
        np.stack([rules for rules, _ in ruled]), np.stack([limits for _, limits in ruled]),
    )  # fmt: skip


def run_scene_cases(
    scene: Scene,
    motion: Motion,
    cases: Cases,
    *,
    scheme: str | None = None,
    time_step: float | str = "auto",
    leave_out: bool = True,
    refinement: int = 1,
    budget: int = BUDGET,
    threads: int = 1,
    progress: Progress | None = None,
) -> SceneResults:
    """Run cases of a scene under one motion with the general kernel.

    Parameters
    ----------
    scene : Scene
        The scene.
    motion : Motion
        The ground's.
    cases : Cases
        `height` and `b_over_h` are those of the scene's reference element, `friction` that of every contact law
        without one.
    scheme : str, optional
        Integration scheme, "centred" (the default) or "cundall".
    time_step : float or str
        Largest step, s; "auto"; or a fraction of the stable step such as "0.25 stable".
    leave_out : bool
        Leave out cases below the thresholds of rocking and sliding, and the time before and after anything can move.
    refinement : int
        Each step is divided into so many; for verification.
    budget : int
        Steps of one case, beyond which it is given up and marked `over_budget`.
    threads : int
        The bits do not depend on it.
    progress : callable, optional
        Called now and then with the element steps done and those expected.

    Returns
    -------
    SceneResults
        In the order of the cases.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    check_positive(threads=threads, refinement=refinement, budget=budget)
    how = plan_scene(
        scene, motion, cases, scheme=scheme, time_step=time_step, leave_out=leave_out, refinement=refinement
    )
    free = how.variants[0].free
    results = SceneResults.at_rest(cases.size, free.size)
    counter = np.zeros(1, np.int64)
    # A scene that its weight alone presses in too far has no answer; its faces may even have passed one another.
    soft = ~np.array([item.bears for item in how.variants])[how.variant]
    results.status[soft], results.overturned[soft] = Status.UNSTABLE, INT8_MISSING
    moving = np.flatnonzero(~how.never & ~soft)
    length = how.steps[moving] * np.maximum(motion.samples - how.table[moving, t.P_FIRST], 1).astype(np.int64)
    order = moving[np.lexsort((-length, how.steps[moving]))]
    total = int(length.sum()) * free.size

    def run(chosen: NDArray[np.int64]) -> None:
        out, each, _ = how.run(motion, chosen, counter, np.zeros((0, 2 + 6 * how.sizes.size)), budget)
        each = each[:, free]
        results.store(
            chosen, out[:, t.R_STATUS], out[:, t.R_DEPTH], out[:, t.R_ENERGY], out[:, t.R_STEPS] * free.size,
            each[:, :, t.E_SIDE], each[:, :, t.E_TIME], each[:, :, t.E_ANGLE], each[:, :, t.E_SLIP], each[:, :, t.E_RESIDUAL],
        )  # fmt: skip

    queues = shared_out(order, how.steps, lambda count: max(-(-count // QUEUE), min(2, count // 64)))
    run_queues(run, queues, threads, counter, total, progress)
    return results
