"""How the general kernel is to compute each case of a scene: its variants, their steps, and what can be left out."""

from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.clock import SCENE
from overturning.dem.kernel.ground import Ground
from overturning.dem.limits import AFTERMATH
from overturning.dem.numerics import ELEMENT_STEP, Numerics
from overturning.dem.path import PlanePath
from overturning.dem.plan import ANSWERS, Plan, check_path, shaking
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.arrays import kernel_column, kernel_layout, kernel_rules, kernel_shapes
from overturning.dem.polygon.path import path_columns, scene_path
from overturning.dem.polygon.prepare import Prepared, prepare
from overturning.dem.polygon.rules import SCHEMES, SceneRules
from overturning.dem.quiet import SAFE_SHARE, quiet_windows
from overturning.dem.time_step import HEAVY_DAMPING, Scheme, samples_divided, scheme_of, steps_per_sample
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.contact import check_precision
from overturning.model.planes import Planes
from overturning.model.scene import Scene
from overturning.model.status import Status
from overturning.motion.motion import Motion

SAFE_UPLIFT: Final = 0.7
"""Share of the uplift acceleration of all that can move as one, below which shaking leaves it standing after another element has
fallen."""


@dataclass(frozen=True, kw_only=True)
class PolygonPlan(Plan):
    """How each of n cases of a scene of polygons is to be computed."""

    halved: ClassVar[bool] = True

    model: Planes
    scheme: Scheme
    variants: list[Prepared]  # the scene at each size
    variant: NDArray[np.int64]  # shape (n,): which of them each case is
    stands_from: FloatArray  # this and the others as of `SceneRules`
    layout: NDArray[np.int64]
    parts: NDArray[np.int64]
    sizes: NDArray[np.int64]
    shapes: FloatArray
    initial: FloatArray
    elements: NDArray[np.void]
    limits: NDArray[np.void]

    def tables(self, count: int) -> dict[str, NDArray[np.void]]:
        """As of `Plan.tables`, and ``each``, shape (n, elements)."""
        return {
            "results": np.zeros(count, t.RESULT),
            "each": np.zeros((count, self.elements.shape[1]), t.ELEMENT_RESULT),
        }

    def rules(self, chosen: NDArray[np.int64], tables: dict[str, NDArray[np.void]], finer: int) -> SceneRules:
        """As of `Plan.rules`, of cases with the same number of steps per sample."""
        cases = self.table[chosen]
        # The shortest step is in ticks, which shrink with the whole one.
        cases["dwell"] *= finer
        return SceneRules(
            scheme=SCHEMES[self.scheme][0],
            cases=cases,
            stands_from=self.stands_from[chosen],
            row=self.row[chosen],
            variant=self.variant[chosen],
            initial=self.initial,
            layout=self.layout,
            parts=self.parts,
            sizes=self.sizes,
            shapes=self.shapes,
            elements=self.elements,
            limits=self.limits,
            results=tables["results"],
            each=tables["each"],
            ground=Ground(self.ground, self.upward, self.motion.samples, self.motion.sampling_interval),
            gravity=self.model.scene.gravity,
            at_once=int(self.steps[chosen[0]]) * finer,
            weight=len(self.model.elements),
            budget=self.numerics.budget // ELEMENT_STEP,
        )

    def answers(self, chosen: NDArray[np.int64], tables: dict[str, NDArray[np.void]]) -> dict[str, Any]:
        """As of `Plan.answers`."""
        out, every, variant = tables["results"], tables["each"], self.variant[chosen]
        edge = np.array([item.edge for item in self.variants])[variant]
        off_the_edge = (every["slip"] >= edge).any(axis=1) & (out["status"] == Status.SIMULATED)
        out["status"][off_the_edge] = Status.UNSTABLE
        every["angle"] /= np.stack([item.unit for item in self.variants])[variant]
        free = self.variants[0].free
        each = every[:, free[0]] if len(free) == 1 else every[:, free]
        return {name: (out if column in (t.RESULT.names or ()) else each)[column] for name, column in ANSWERS.items()}

    def room(self, kept: bool) -> FloatArray:
        """As of `Plan.room`."""
        if not kept:
            return np.zeros((0, 0))
        rows, columns = int(self.table[0]["after"]) - int(self.first[0]) + 3, path_columns(self.variants[0])
        check_path(rows * columns)
        return np.zeros((rows, columns))

    def resting(self, count: int) -> FloatArray:
        """As of `Plan.resting`."""
        prepared = self.variants[0]
        rest, poses_end = np.zeros((count, path_columns(prepared))), 2 + 6 * len(prepared.placed)
        rest[:, poses_end:] = np.nan
        rest[:, t.T_TIME] = np.arange(count) * self.motion.sampling_interval
        rest[:, t.T_GROUND] = self.ground[0, :count] * self.table[0]["amplitude"]
        for index, item in enumerate(prepared.placed):
            pose = np.array([item.x, item.z, 0.0]) + prepared.displacement[index]
            rest[:, 2 + 6 * index : 5 + 6 * index] = pose
        return rest

    def path(self, rows: FloatArray) -> PlanePath:
        """As of `Plan.path`."""
        return scene_path(self.variants[0], rows)


def plan_polygons(model: Planes, motion: Motion, cases: Cases, numerics: Numerics) -> PolygonPlan:
    """Check the arguments and work out what each case of a scene needs; parameters and errors as of `overturning.dem.run.run`."""
    scheme, scene = scheme_of(numerics.scheme), model.scene
    if np.asarray(cases.initial_tilt).any():
        raise ArgumentError("initial_tilt: a scene starts at rest; rotate an element in the scene file instead")
    keys = np.stack([np.asarray(cases.height), np.asarray(cases.b_over_h), np.asarray(cases.damping_factor)], axis=1)
    distinct, variant = np.unique(keys, axis=0, return_inverse=True)
    variant = variant.reshape(-1)
    variants = [prepare(scene, float(height), float(ratio)) for height, ratio, _ in distinct]
    _check_variants(scene, variants)
    row, ground = shaking(motion, cases)
    square = np.array([item.square for item in variants])
    rate = np.array([item.rate for item in variants]) * distinct[:, 2]
    period = np.array([item.period for item in variants])
    per_sample, finest, divided = steps_of(scheme, numerics.time_step, square, rate, motion.sampling_interval, period)
    first, stays_at_rest, stands_from, table = _case_table(
        scene, motion, cases, variants, variant, row, ground, numerics.leave_out
    )
    table["finest"] = finest[variant]
    # A lightly damped contact rings for longer. Where steps are wanted shorter, each is divided.
    dwell = SCENE.dwell * np.clip(np.sqrt(square) / np.maximum(rate, 1e-300), 1.0, 8.0) * divided * numerics.refinement
    table["dwell"] = np.round(dwell)[variant]
    table["standing"], table["settled"] = SCENE.whole, SCENE.settled
    shaped, ruled = [kernel_shapes(item) for item in variants], [kernel_rules(item) for item in variants]
    return PolygonPlan(
        model=model, motion=motion, cases=cases, numerics=numerics, scheme=scheme, row=row, ground=ground,
        steps=per_sample[variant] * numerics.refinement,
        first=first, stays_at_rest=stays_at_rest, too_soft=np.array([item.sinks for item in variants])[variant], variants=variants, variant=variant,
        table=table, stands_from=stands_from,
        layout=kernel_layout(variants[0]), parts=variants[0].parts,
        sizes=shaped[0][0],
        shapes=np.stack([shapes for _, shapes in shaped]),
        initial=np.stack([kernel_column(item) for item in variants]),
        elements=np.stack([rules for rules, _ in ruled]),
        limits=np.stack([limits for _, limits in ruled]),
    )  # fmt: skip


def steps_of(
    scheme: Scheme, time_step: float | str, square: FloatArray, rate: FloatArray, interval: float, period: FloatArray
) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    """Whole steps per sample of each variant, ticks of its finest step, and how many steps the automatic one is divided into."""
    if scheme != Scheme.CENTRED:
        return steps_per_sample(scheme, time_step, square, rate, interval), np.ones(square.size), np.ones(square.size)
    frequency = np.sqrt(square)
    whole = np.minimum(SCENE.longest * period, interval)
    heavy = np.maximum(0.5 * rate / frequency / HEAVY_DAMPING, 1.0)
    fewest, steps = (samples_divided(whole, whole, wanted, interval) for wanted in ("auto", time_step))
    # As often halved whatever the step: a finer one is finer throughout.
    halvings = np.clip(np.frexp(interval / fewest * frequency * heavy / SCENE.finest)[1], 0, SCENE.halvings)
    return steps, np.ldexp(SCENE.whole, -halvings), steps / fewest


def _check_variants(scene: Scene, variants: list[Prepared]) -> None:
    for item in variants:
        # As of a block H high: as high as the scene.
        height = max(float(part.points[:, 1].max()) for part in item.placed if not part.fixed)
        check_precision(scene.gravity / (2.0 * item.sunk), np.full(item.sunk.size, height), 0.0)
    alike = {
        (tuple(item.pairs), tuple(item.support.tolist()), tuple(kernel_shapes(item)[0].tolist())) for item in variants
    }
    if len(alike) != 1:
        raise ArgumentError(f"scene {scene.name}: different elements can meet at different sizes; sweep them apart")


def _case_table(
    scene: Scene,
    motion: Motion,
    cases: Cases,
    variants: list[Prepared],
    variant: NDArray[np.int64],
    row: NDArray[np.int64],
    ground: FloatArray,
    leave_out: bool,
) -> tuple[NDArray[np.int64], NDArray[np.bool_], FloatArray, NDArray[np.void]]:
    """First sample to compute, whether a case stays at rest, from when on its parts stand for good, and the kernel's case table."""
    samples, amplitude = motion.samples, np.asarray(cases.amplitude)
    # 20/p with p = √(3g/4R).
    period = np.sqrt(np.array([item.radius for item in variants])[variant] / (0.75 * scene.gravity))
    table, stands_from = np.zeros(cases.size, t.CASE), np.full((cases.size, len(variants[0].parts)), np.inf)
    table["amplitude"], table["friction"], table["damping"] = amplitude, cases.friction, cases.damping_factor
    table["calm"], table["after"] = np.inf, samples + np.ceil(AFTERMATH * period / motion.sampling_interval)
    first, stays_at_rest = np.zeros(cases.size, np.int64), np.zeros(cases.size, np.bool_)
    if not leave_out:
        return first, stays_at_rest, stands_from, table
    rocking = np.array([item.threshold for item in variants])[variant]
    friction = np.array([item.fixed_friction for item in variants])[variant]
    swept = np.array([item.swept_friction for item in variants])[variant]
    threshold = np.minimum(rocking, np.where(swept, np.minimum(friction, np.asarray(cases.friction)), friction))
    first, calm, stays_at_rest = quiet_windows(motion, row, amplitude, ground[:, :samples], threshold)
    moving = threshold <= 0
    first[moving], stays_at_rest[moving] = 0, False
    table["first"], table["calm"] = first, np.where(moving, np.inf, calm)
    alike = all(np.array_equal(item.parts, variants[0].parts) for item in variants)
    for part in range(len(variants[0].parts)):
        least = np.array([item.safe[part] if alike else 0.0 for item in variants])
        safe = least[variant] * (SAFE_UPLIFT / SAFE_SHARE)
        stands_from[:, part] = quiet_windows(motion, row, amplitude, ground[:, :samples], safe)[1]
    return first, stays_at_rest, stands_from, table
