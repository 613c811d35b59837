"""Digests of the bits of outcomes: ``python -m tests.dem.digests`` writes them, `test_digests.py` compares them.

Closed forms and independent solvers test whether an outcome is right. A digest detects any change: the same cells have
the same bits on every machine and in every version, except for changes named in CHANGELOG.md.
"""

import hashlib
import json
from collections.abc import Callable, Mapping
from contextlib import chdir
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from overturning.dem.block.rigid import simulate_rigid_rocking
from overturning.dem.faces import simulate_grid_and_body_face_planes
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.dem.simulate import create_case_grid
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.contact import Contact, VertexContact
from overturning.model.geometry import size_reference_height_and_b_over_h
from overturning.model.model import Model
from overturning.model.planes import PlanarModel
from overturning.model.scene import Scene, gravestone
from overturning.model.shapes import Polyhedron, RectangularPrism, shape_from_name_or_sides
from overturning.model.stack import Stack
from overturning.motion.motion import Motion
from tests.dem.polygon_scenes import block, scene, shipped


@cache
def ground(up: bool = False, samples: int = 480) -> Motion:
    """Return a piecewise linear motion, weak at start and end; exact in binary, since its knots are eighths of m/s²."""
    dice = np.random.default_rng(11)
    rows = dice.integers(-48, 49, (3, samples // 16 + 1)) / 8.0
    rows[:, :4] /= 64.0
    rows[:, -10:] /= 128.0
    north, east, vertical = (np.interp(np.arange(samples), 16 * np.arange(row.size), row) for row in rows)
    return Motion(north, east, 0.75 * vertical if up else None, sampling_interval=0.01)


def drawn(
    count: int, seed: int, size: tuple[float, float] | None = None, *, tilted: bool = False, oblong: bool = False
) -> Cases:
    """Draw `count` varied cases: slender to squat, high to low, smooth to rough; or near `size`: height (m), B/H."""
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
"""Largest number of block steps of a case: three times the largest number that any case takes."""


def of_cases(model: Model | Scene, cases: Cases, up: bool = False, **options: Any) -> dict[str, Any]:
    return vars(simulate_cases(model, ground(up), cases, NumericalOptions(**{"budget": BUDGET} | options)))


def of_rigid(up: bool, order: int) -> dict[str, Any]:
    return simulate_rigid_rocking(ground(up), drawn(60, 4, tilted=True), order)._asdict()


def of_faces() -> dict[str, Any]:
    model = Body(RectangularPrism())
    grid = create_case_grid(
        model, [0.6], [0.15, 0.3], orientation_deg=[0.0, 30.0, 90.0], aspect=[1.0, 2.0], friction=[0.6]
    )
    return simulate_grid_and_body_face_planes(model, ground(), grid, NumericalOptions())


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

OUTCOMES: dict[str, Callable[[], Mapping[str, Any]]] = {
    "block": partial(of_cases, PlanarModel(), drawn(200, 1)),
    "block, ground up and down": partial(of_cases, PlanarModel(), drawn(200, 2, tilted=True), True),
    "block, nothing left out": partial(of_cases, PlanarModel(), drawn(100, 3), True, leave_out=False),
    "block, finer": partial(of_cases, PlanarModel(), drawn(16, 5), True, refinement=2),
    "block, quarter of the stable step": partial(of_cases, PlanarModel(), drawn(8, 6), time_step="0.25 stable"),
    "block, short budget": partial(of_cases, PlanarModel(), drawn(30, 5), budget=4000),
    "soft block": partial(of_cases, SOFT, drawn(120, 7), True),
    "bouncing block": partial(of_cases, BOUNCING, drawn(120, 8, tilted=True)),
    "block, Cundall": partial(of_cases, BOUNCING, drawn(40, 9), True, scheme="cundall"),
    "soft block, Cundall": partial(of_cases, SOFT, drawn(40, 10, tilted=True), scheme="cundall"),
    "rigid block": partial(of_rigid, False, 12),
    "rigid block, ground up and down": partial(of_rigid, True, 8),
    "rectangle": partial(of_cases, Body(RectangularPrism()), drawn(80, 11, oblong=True), True),
    "rectangle, level ground": partial(
        of_cases, Body(RectangularPrism(), VertexContact(1e-4, 0.5, 0.3)), drawn(50, 12, oblong=True)
    ),
    "cylinder": partial(of_cases, Body(shape_from_name_or_sides("circle")), drawn(40, 13), True),
    "octagon": partial(of_cases, Body(shape_from_name_or_sides(8)), drawn(30, 14), leave_out=False),
    "wedge": partial(of_cases, Body(WEDGE), drawn(30, 15), True),
    "rectangle with the planes of its faces": of_faces,
    **{
        f"scene: {name}": partial(
            of_cases, PlanarModel(one), drawn(20, 20 + number, size_reference_height_and_b_over_h(one)), number % 2 == 1
        )
        for number, (name, one) in enumerate(SCENES.items())
    },
    "scene of a block": partial(of_cases, PlanarModel(), drawn(30, 30), True, general=True),
    "scene of a block, Cundall": partial(of_cases, SOFT, drawn(10, 31), general=True, scheme="cundall"),
    "stack in 3-D": partial(
        of_cases, Stack(shipped("three-tier")), drawn(16, 33, size_reference_height_and_b_over_h(shipped("three-tier")))
    ),
    "stack, Cundall": partial(
        of_cases, PlanarModel(LOOSE), drawn(6, 32, size_reference_height_and_b_over_h(LOOSE)), True, scheme="cundall"
    ),
}
"""Functions that compute the outcomes, by name: random cases of each kernel and scheme, with fixed seeds."""

EXACT = ("block", "soft block", "bouncing block", "rigid block", "rectangle", "cylinder", "octagon", "wedge")
"""Prefixes of the names of outcomes that are compared bit by bit. For scenes only flags and statuses are compared:
their statics use LAPACK, whose bits differ between processors."""

FILE = Path(__file__).with_name("digests.json")


def digest(name: str) -> str:
    """Return the first 16 hexadecimal digits of the SHA-256 of an outcome."""
    with chdir(FILE.parents[2]):  # the names of scenes are relative to the project folder
        found = OUTCOMES[name]()
    exact = name.startswith(EXACT)
    hashed = hashlib.sha256()
    for key in sorted(found):
        if exact or key in ("overturned", "status"):
            hashed.update(key.encode() + np.ascontiguousarray(found[key]).tobytes())
    return hashed.hexdigest()[:16]


if __name__ == "__main__":
    FILE.write_text(json.dumps({name: digest(name) for name in OUTCOMES}, indent=1) + "\n", encoding="utf-8")
