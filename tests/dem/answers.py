"""What the kernels find of made-up blocks, bodies and scenes: outcomes, paths and forces."""

from functools import cache, partial
from typing import Any

import numpy as np

from overturning.dem.block.rigid import rocking
from overturning.dem.faces import simulate_further
from overturning.dem.numerics import Numerics
from overturning.dem.run import run
from overturning.dem.simulate import grid_over, simulate
from overturning.dem.time_step import highest_eigenvalue, lowest_eigenvalue, rocking_time
from overturning.dem.trajectory import trajectory
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.contact import Contact, VertexContact
from overturning.model.geometry import native_size
from overturning.model.model import Model
from overturning.model.planes import Planes
from overturning.model.scene import Scene, gravestone
from overturning.model.shapes import Polyhedron, Rectangle, shape_of
from overturning.motion.motion import Motion
from tests.dem.polygon_scenes import block, scene, shipped
from tests.kept import Answers


@cache
def ground(up: bool = False, samples: int = 480) -> Motion:
    """Lines between whole eighths of m/s², weak at first and at the end: no digit of it is rounded."""
    dice = np.random.default_rng(11)
    rows = dice.integers(-48, 49, (3, samples // 16 + 1)) / 8.0
    rows[:, :4] /= 64.0
    rows[:, -10:] /= 128.0
    north, east, vertical = (np.interp(np.arange(samples), 16 * np.arange(row.size), row) for row in rows)
    return Motion(north, east, 0.75 * vertical if up else None, sampling_interval=0.01)


def drawn(
    count: int, seed: int, size: tuple[float, float] | None = None, *, tilted: bool = False, oblong: bool = False
) -> Cases:
    """Cases of every kind: very slender and squat, high and low, smooth and rough; about a size where one is given."""
    dice = np.random.default_rng(seed)
    heights, ratios = ([0.25, 0.6, 1.5, 4.0], [0.08, 0.15, 0.22, 0.35, 0.7, 2.0])
    if size is not None:
        heights, ratios = [size[0], 2.0 * size[0]], [size[1], 0.75 * size[1]]
    ratio = dice.choice(ratios, count)
    return Cases(
        azimuth_deg=dice.integers(0, 24, count) * 15.0,
        height=dice.choice(heights, count),
        b_over_h=ratio,
        friction=dice.choice([0.0, 0.1, 0.35, 0.7, 1.0, 3.0], count, p=[0.1, 0.15, 0.2, 0.25, 0.2, 0.1]),
        amplitude=dice.choice([0.02, 0.5, 1.0, 2.0], count, p=[0.1, 0.25, 0.4, 0.25]),
        damping_factor=dice.choice([0.8, 1.0, 1.25], count),
        initial_tilt=dice.choice([-0.5, 0.0, 0.0, 0.3], count) * ratio if tilted else 0.0,
        aspect=dice.choice([0.5, 1.0, 1.0, 1.7], count) if oblong else 1.0,
    )


BUDGET = 8_000_000
"""Block steps of a case, three times what any of them needs: what never ends is told soon."""


def of_cases(model: Model | Scene, cases: Cases, up: bool = False, **options: Any) -> dict[str, Any]:
    return vars(run(model, ground(up), cases, Numerics(**{"budget": BUDGET} | options)))


def of_path(model: Any, up: bool = True, rows: int = 6, **case: Any) -> dict[str, Any]:
    """A path and its forces, all of it and a few moments."""
    path = trajectory(ground(up), model, budget=BUDGET, **case)
    found: dict[str, Any] = {name: one.to_numpy() for name, one in path.variables.items() if one.dtype.kind in "fi"}
    return found | {"attributes": dict(path.attrs), "places": path.sizes["time"], "times": path.time.to_numpy()[:rows]}


def of_rigid(up: bool, order: int) -> dict[str, Any]:
    return rocking(ground(up), drawn(60, 4, tilted=True), order)._asdict()


def of_dataset(model: Any, **rows: Any) -> dict[str, Any]:
    found = simulate(ground(), model, **rows)
    return {name: values.to_numpy() for name, values in found.variables.items() if values.dtype.kind in "fi"} | {
        "attributes": found.attrs | {name: sorted(values.attrs) for name, values in found.variables.items()}
    }


def of_faces() -> dict[str, Any]:
    model = Body(Rectangle())
    grid = grid_over(model, [0.6], [0.15, 0.3], orientation_deg=[0.0, 30.0, 90.0], aspect=[1.0, 2.0], friction=[0.6])
    return simulate_further(model, ground(), grid, Numerics())


def of_steps() -> dict[str, Any]:
    """What steps hang on, of contacts stiffer across than along and the other way round, slender and squat."""
    normal, tangential, width, height = (
        one.ravel() for one in np.meshgrid([1e6, 4e6], [0, 1e6, 9e6], [0.1, 1], [0.3, 2])
    )
    ends = [of(normal, tangential, width, height) for of in (highest_eigenvalue, lowest_eigenvalue)]
    return {"highest": ends[0], "lowest": ends[1], "rocking": rocking_time(width, height)}


SOFT = gravestone(Contact(static_penetration=1e-4, damping_ratio=0.05, stiffness_ratio=0.5), density=2000.0)
BOUNCING = gravestone(Contact(stiffness=4e6, damping=300.0, stiffness_ratio=2.0))
WEDGE = Polyhedron([[0, 0, 0], [0.5, 0, 0], [0.55, 0.4, 0], [0, 0.35, 0], [0.2, 0.2, 1.1], [0.25, 0.1, 1.1]])
STONE_AND_CAP = scene(
    block("base", 0.5, 0.2),
    {"name": "stone", "vertices": [[-0.15, 0], [0.15, 0], [0.1, 0.7], [-0.12, 0.7]], "stands_on": "base"},
    block("cap", 0.4, 0.1, "stone", 0.02, material="wood"),
    materials={"stone": {"density": 2500}, "wood": {"density": 700}},
    contacts=[
        {"between": ["stone", "wood"], "friction": 0.4, "static_penetration": 1e-5},
        {"between": ["stone", "stone"], "damping_ratio": 0.6, "stiffness_ratio": 0.7},
    ],
)
BESIDE_WHAT_IS_HELD = scene(
    {"name": "wall", "kind": "held", "width": 0.2, "height": 1.5, "at": [0.35, 0.02]},
    {"name": "stone", "width": 0.24, "height": 0.6, "stands_on": "ground", "fallen_rotation_deg": 60},
    {
        "name": "ball",
        "vertices": [[-0.1, 0], [0.1, 0], [0.2, 0.2], [0, 0.35], [-0.2, 0.2]],
        "stands_on": "ground",
        "at": [-0.8, 0],
        "rotation_deg": 0,
    },
)
LOOSE = scene(
    block("one", 0.3, 0.9),
    block("two", 0.3, 0.9, x=0.33, fallen_rotation_deg=90),
    contacts=[{"between": ["stone", "stone"], "stiffness": 5e6, "damping": 2000, "friction": 0.5}],
    gravity=3.7,
)
SCENES = {
    "three tiers": shipped("three-tier"),
    "against a wall": shipped("against-a-wall"),
    "boulder": shipped("boulder"),
    "cross": shipped("cross"),
    "stone and cap": STONE_AND_CAP,
    "beside what is held": BESIDE_WHAT_IS_HELD,
    "two in a row": LOOSE,
}

ANSWERS: Answers = {
    "block": partial(of_cases, Planes(), drawn(200, 1)),
    "block, ground up and down": partial(of_cases, Planes(), drawn(200, 2, tilted=True), True),
    "block, nothing left out": partial(of_cases, Planes(), drawn(100, 3), True, leave_out=False),
    "block, finer": partial(of_cases, Planes(), drawn(16, 5), True, refinement=2),
    "block, quarter of the stable step": partial(of_cases, Planes(), drawn(8, 6), time_step="0.25 stable"),
    "block, short budget": partial(of_cases, Planes(), drawn(30, 5), budget=4000),
    "soft block": partial(of_cases, SOFT, drawn(120, 7), True),
    "bouncing block": partial(of_cases, BOUNCING, drawn(120, 8, tilted=True)),
    "block, Cundall": partial(of_cases, BOUNCING, drawn(40, 9), True, scheme="cundall"),
    "soft block, Cundall": partial(of_cases, SOFT, drawn(40, 10, tilted=True), scheme="cundall"),
    "rigid block": partial(of_rigid, False, 12),
    "rigid block, ground up and down": partial(of_rigid, True, 8),
    "block as a dataset": partial(of_dataset, None, azimuth_deg=[0, 90, 180, 225], height=[0.6], b_over_h=[0.2, 0.4]),
    "path of a block": partial(of_path, None, azimuth_deg=60.0, height=0.6, b_over_h=0.35, friction=0.7),
    "path of a sliding block": partial(
        of_path, SOFT, up=False, azimuth_deg=75.0, height=0.6, b_over_h=0.5, friction=0.2, initial_tilt=0.01
    ),
    "path of a falling block": partial(
        of_path, BOUNCING, azimuth_deg=60.0, height=0.6, b_over_h=0.12, friction=0.7, scheme="cundall", amplitude=1.5
    ),
    "rectangle": partial(of_cases, Body(Rectangle()), drawn(80, 11, oblong=True), True),
    "rectangle, level ground": partial(
        of_cases, Body(Rectangle(), VertexContact(1e-4, 0.5, 0.3)), drawn(50, 12, oblong=True)
    ),
    "cylinder": partial(of_cases, Body(shape_of("circle")), drawn(40, 13), True),
    "octagon": partial(of_cases, Body(shape_of(8)), drawn(30, 14), leave_out=False),
    "wedge": partial(of_cases, Body(WEDGE), drawn(30, 15), True),
    "rectangle as a dataset": partial(
        of_dataset, "rectangle", orientation_deg=[0, 45, 90, 225], height=[0.6], b_over_h=[0.3], aspect=[1.0, 1.5]
    ),
    "rectangle with the planes of its faces": of_faces,
    "path of a rectangle": partial(
        of_path, "rectangle", orientation_deg=20.0, height=0.6, b_over_h=0.3, aspect=1.5, friction=0.5
    ),
    "path of a cylinder": partial(of_path, "circle", orientation_deg=0.0, height=0.6, b_over_h=0.3, amplitude=1.4),
    **{
        f"scene: {name}": partial(of_cases, Planes(one), drawn(20, 20 + number, native_size(one)), number % 2 == 1)
        for number, (name, one) in enumerate(SCENES.items())
    },
    "scene of a block": partial(of_cases, Planes(), drawn(30, 30), True, general=True),
    "scene of a block, Cundall": partial(of_cases, SOFT, drawn(10, 31), general=True, scheme="cundall"),
    "stack, Cundall": partial(of_cases, Planes(LOOSE), drawn(6, 32, native_size(LOOSE)), True, scheme="cundall"),
    "path of a stack, Cundall": partial(of_path, LOOSE, azimuth_deg=60.0, scheme="cundall"),
    "stable steps": of_steps,
    "path of three tiers": partial(of_path, SCENES["three tiers"], azimuth_deg=60.0, friction=0.6),
    "path of a boulder": partial(of_path, SCENES["boulder"], up=False, azimuth_deg=60.0, friction=0.6),
    "path beside what is held": partial(of_path, BESIDE_WHAT_IS_HELD, azimuth_deg=240.0, friction=0.4),
}
