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
from overturning.dem.faces import simulate_grid_and_2d_face_planes_of_rectangle
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.dem.simulate import create_case_grid
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.contact import Contact, VertexContact
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.model import Model
from overturning.model.planes import PlanarModel
from overturning.model.scene import Scene, gravestone
from overturning.model.shapes import Polyhedron, RectangularPrism, shape_from_name_or_sides
from overturning.model.stack import Stack
from overturning.motion.motion import Motion
from tests.dem.polygon_scenes import block_element, load_shipped_scene, scene_of_elements


@cache
def motion_for_outcome_digests(up: bool = False, samples: int = 480) -> Motion:
    """Return a piecewise linear motion, weak at start and end; exact in binary, since its knots are eighths of m/s²."""
    dice = np.random.default_rng(11)
    rows = dice.integers(-48, 49, (3, samples // 16 + 1)) / 8.0
    rows[:, :4] /= 64.0
    rows[:, -10:] /= 128.0
    north, east, vertical = (np.interp(np.arange(samples), 16 * np.arange(row.size), row) for row in rows)
    return Motion(north, east, 0.75 * vertical if up else None, sampling_interval=0.01)


def random_cases_of_varied_blocks(
    count: int,
    seed: int,
    height_and_b_over_h: tuple[float, float] | None = None,
    *,
    tilted: bool = False,
    oblong: bool = False,
) -> Cases:
    """Draw random cases: slender to squat, high to low, smooth to rough blocks.

    With `height_and_b_over_h`, a height, m, and a B/H, the blocks are once or twice as high and have this B/H or
    three quarters of it.
    """
    dice = np.random.default_rng(seed)
    heights, ratios = ([0.25, 0.6, 1.5, 4.0], [0.08, 0.15, 0.22, 0.35, 0.7, 2.0])
    if height_and_b_over_h is not None:
        height, b_over_h = height_and_b_over_h
        heights, ratios = [height, 2.0 * height], [b_over_h, 0.75 * b_over_h]
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


MAX_BLOCK_STEPS_PER_CASE = 8_000_000
"""Largest number of block steps of a case: three times the largest number that any case takes."""


def outcomes_under_digest_motion(
    model: Model | Scene, cases: Cases, up: bool = False, **options: Any
) -> dict[str, Any]:
    """Return the outcomes of cases under `motion_for_outcome_digests`, by name."""
    return vars(
        simulate_cases(
            model,
            motion_for_outcome_digests(up),
            cases,
            NumericalOptions(**{"budget": MAX_BLOCK_STEPS_PER_CASE} | options),
        )
    )


def outcomes_of_random_rigid_rocking_blocks(up: bool, order: int) -> dict[str, Any]:
    """Return the outcomes of 60 random rigid rocking blocks, by name; `order` is that of the integration scheme."""
    return simulate_rigid_rocking(
        motion_for_outcome_digests(up), random_cases_of_varied_blocks(60, 4, tilted=True), order
    )._asdict()


def outcomes_of_3d_blocks_and_their_2d_models() -> dict[str, Any]:
    """Return the outcomes of 3-D blocks and of their 2-D models in the planes of their faces, by name."""
    model = Body(RectangularPrism())
    grid = create_case_grid(
        model, [0.6], [0.15, 0.3], orientation_deg=[0.0, 30.0, 90.0], aspect=[1.0, 2.0], friction=[0.6]
    )
    return simulate_grid_and_2d_face_planes_of_rectangle(model, motion_for_outcome_digests(), grid, NumericalOptions())


BLOCK_WITH_SOFT_CONTACT = gravestone(
    Contact(static_penetration=1e-4, damping_ratio=0.05, stiffness_ratio=0.5), density=2000.0
)
BOUNCING_BLOCK = gravestone(Contact(stiffness=4e6, damping=300.0, stiffness_ratio=2.0))
WEDGE = Polyhedron([[0, 0, 0], [0.5, 0, 0], [0.55, 0.4, 0], [0, 0.35, 0], [0.2, 0.2, 1.1], [0.25, 0.1, 1.1]])
BASE_STONE_AND_CAP_SCENE = scene_of_elements(
    block_element("base", 0.5, 0.2),
    {"name": "stone", "vertices": [[-0.15, 0], [0.15, 0], [0.1, 0.7], [-0.12, 0.7]], "stands_on": "base"},
    block_element("cap", 0.4, 0.1, "stone", 0.02, material="wood"),
    materials={"stone": {"density": 2500}, "wood": {"density": 700}},
    contacts=[
        {"between": ["stone", "wood"], "friction": 0.4, "static_penetration": 1e-5},
        {"between": ["stone", "stone"], "damping_ratio": 0.6, "stiffness_ratio": 0.7},
    ],
)
STONES_BESIDE_FIXED_WALL = scene_of_elements(
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
TWO_BLOCKS_IN_A_ROW = scene_of_elements(
    block_element("one", 0.3, 0.9),
    block_element("two", 0.3, 0.9, x=0.33, fallen_rotation_deg=90),
    contacts=[{"between": ["stone", "stone"], "stiffness": 5e6, "damping": 2000, "friction": 0.5}],
    gravity=3.7,
)
SCENES = {
    "three tiers": load_shipped_scene("three-tier"),
    "against a wall": load_shipped_scene("against-a-wall"),
    "boulder": load_shipped_scene("boulder"),
    "cross": load_shipped_scene("cross"),
    "stone and cap": BASE_STONE_AND_CAP_SCENE,
    "beside what is held": STONES_BESIDE_FIXED_WALL,
    "two in a row": TWO_BLOCKS_IN_A_ROW,
}

OUTCOME_FUNCTIONS: dict[str, Callable[[], Mapping[str, Any]]] = {
    "block": partial(outcomes_under_digest_motion, PlanarModel(), random_cases_of_varied_blocks(200, 1)),
    "block, ground up and down": partial(
        outcomes_under_digest_motion, PlanarModel(), random_cases_of_varied_blocks(200, 2, tilted=True), True
    ),
    "block, nothing left out": partial(
        outcomes_under_digest_motion, PlanarModel(), random_cases_of_varied_blocks(100, 3), True, leave_out=False
    ),
    "block, finer": partial(
        outcomes_under_digest_motion, PlanarModel(), random_cases_of_varied_blocks(16, 5), True, refinement=2
    ),
    "block, quarter of the stable step": partial(
        outcomes_under_digest_motion, PlanarModel(), random_cases_of_varied_blocks(8, 6), time_step="0.25 stable"
    ),
    "block, short budget": partial(
        outcomes_under_digest_motion, PlanarModel(), random_cases_of_varied_blocks(30, 5), budget=4000
    ),
    "soft block": partial(
        outcomes_under_digest_motion, BLOCK_WITH_SOFT_CONTACT, random_cases_of_varied_blocks(120, 7), True
    ),
    "bouncing block": partial(
        outcomes_under_digest_motion, BOUNCING_BLOCK, random_cases_of_varied_blocks(120, 8, tilted=True)
    ),
    "block, Cundall": partial(
        outcomes_under_digest_motion, BOUNCING_BLOCK, random_cases_of_varied_blocks(40, 9), True, scheme="cundall"
    ),
    "soft block, Cundall": partial(
        outcomes_under_digest_motion,
        BLOCK_WITH_SOFT_CONTACT,
        random_cases_of_varied_blocks(40, 10, tilted=True),
        scheme="cundall",
    ),
    "rigid block": partial(outcomes_of_random_rigid_rocking_blocks, False, 12),
    "rigid block, ground up and down": partial(outcomes_of_random_rigid_rocking_blocks, True, 8),
    "rectangle": partial(
        outcomes_under_digest_motion, Body(RectangularPrism()), random_cases_of_varied_blocks(80, 11, oblong=True), True
    ),
    "rectangle, level ground": partial(
        outcomes_under_digest_motion,
        Body(RectangularPrism(), VertexContact(1e-4, 0.5, 0.3)),
        random_cases_of_varied_blocks(50, 12, oblong=True),
    ),
    "cylinder": partial(
        outcomes_under_digest_motion,
        Body(shape_from_name_or_sides("circle")),
        random_cases_of_varied_blocks(40, 13),
        True,
    ),
    "octagon": partial(
        outcomes_under_digest_motion,
        Body(shape_from_name_or_sides(8)),
        random_cases_of_varied_blocks(30, 14),
        leave_out=False,
    ),
    "wedge": partial(outcomes_under_digest_motion, Body(WEDGE), random_cases_of_varied_blocks(30, 15), True),
    "rectangle with the planes of its faces": outcomes_of_3d_blocks_and_their_2d_models,
    **{
        f"scene: {name}": partial(
            outcomes_under_digest_motion,
            PlanarModel(one),
            random_cases_of_varied_blocks(20, 20 + number, reference_element_height_and_b_over_h(one)),
            number % 2 == 1,
        )
        for number, (name, one) in enumerate(SCENES.items())
    },
    "scene of a block": partial(
        outcomes_under_digest_motion, PlanarModel(), random_cases_of_varied_blocks(30, 30), True, general=True
    ),
    "scene of a block, Cundall": partial(
        outcomes_under_digest_motion,
        BLOCK_WITH_SOFT_CONTACT,
        random_cases_of_varied_blocks(10, 31),
        general=True,
        scheme="cundall",
    ),
    "stack in 3-D": partial(
        outcomes_under_digest_motion,
        Stack(load_shipped_scene("three-tier")),
        random_cases_of_varied_blocks(16, 33, reference_element_height_and_b_over_h(load_shipped_scene("three-tier"))),
    ),
    "stack, Cundall": partial(
        outcomes_under_digest_motion,
        PlanarModel(TWO_BLOCKS_IN_A_ROW),
        random_cases_of_varied_blocks(6, 32, reference_element_height_and_b_over_h(TWO_BLOCKS_IN_A_ROW)),
        True,
        scheme="cundall",
    ),
}
"""Functions that compute the outcomes, by name: random cases of each kernel and scheme, with fixed seeds."""

BIT_EXACT_OUTCOME_NAME_PREFIXES = (
    "block",
    "soft block",
    "bouncing block",
    "rigid block",
    "rectangle",
    "cylinder",
    "octagon",
    "wedge",
)
"""Prefixes of the names of outcomes that are compared bit by bit. For scenes only flags and statuses are compared:
their statics use LAPACK, whose bits differ between processors."""

DIGEST_FILE = Path(__file__).with_name("digests.json")


def outcome_digest(name: str) -> str:
    """Return the first 16 hexadecimal digits of the SHA-256 of the outcomes that `OUTCOME_FUNCTIONS[name]` computes."""
    with chdir(DIGEST_FILE.parents[2]):  # the names of scenes are relative to the project folder
        found = OUTCOME_FUNCTIONS[name]()
    exact = name.startswith(BIT_EXACT_OUTCOME_NAME_PREFIXES)
    hashed = hashlib.sha256()
    for key in sorted(found):
        if exact or key in ("overturned", "status"):
            hashed.update(key.encode() + np.ascontiguousarray(found[key]).tobytes())
    return hashed.hexdigest()[:16]


if __name__ == "__main__":
    DIGEST_FILE.write_text(
        json.dumps({name: outcome_digest(name) for name in OUTCOME_FUNCTIONS}, indent=1) + "\n", encoding="utf-8"
    )
