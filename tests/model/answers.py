"""What the model says of made-up shapes, scenes, bodies and grids; and which of them are refused."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import xarray as xr

from overturning.model import (
    cases,
    contact,
    element,
    geometry,
    pieces,
    planes,
    polygon,
    polyhedron,
    rest,
    scene,
    shapes,
)
from overturning.model.body import Body, Start
from overturning.model.edges import edge_chances, first_edge
from overturning.model.falls import as_model, model_of
from overturning.model.grid import AXES, Grid
from overturning.model.mesh import read_mesh
from overturning.model.model import Model
from overturning.model.planes import Planes
from overturning.model.results import Results
from overturning.model.shapes import Circle, Polyhedron, Rectangle, Regular, orientation_grid, shape_of
from overturning.model.symmetry import nearest, nearest_planes, representatives
from overturning.model.variables import (
    BODY_ENSEMBLE_VARIABLES,
    BODY_VARIABLES,
    FACE_VARIABLES,
    PLANE_ENSEMBLE_VARIABLES,
    VARIABLES,
    answered,
)
from tests.kept import Answers, interface_of, keys_of, refusals

ROOT = Path(__file__).parents[2]
BOULDER = np.array([[-0.2, -0.15, 0], [-0.2, 0.15, 0], [0.2, -0.15, 0], [0.2, 0.15, 0], [0.05, 0, 0.7]])
WEDGE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.4, 0.4, 0.8], [0.4, 0.6, 0.8]])
LUMP = np.array(
    [
        [x, y, z]
        for z, r in ((0, 0.2), (0.25, 0.32), (0.5, 0.18))
        for x, y in r * np.array([[1, 0], [0.5, 0.9], [-0.5, 0.8], [-1, 0.1], [-0.6, -0.9], [0.4, -0.8]])
    ]
)
SHAPES: dict[str, shapes.Shape] = {
    "rectangle": Rectangle(),
    "circle": Circle(),
    "triangle": Regular(3),
    "octagon": Regular(8),
    "boulder": Polyhedron(BOULDER),
    "wedge": Polyhedron(WEDGE),
    "lump": Polyhedron(LUMP),
}
POLYGONS = {
    "triangle": [[0, 0], [2, 0], [0.5, 1.5]],
    "L": [[0, 0], [1, 0], [1, 0.3], [0.4, 0.3], [0.4, 1.2], [0, 1.2]],
    "cross": [
        [-0.1, 0],
        [0.1, 0],
        [0.1, 0.6],
        [0.35, 0.6],
        [0.35, 0.8],
        [0.1, 0.8],
        [0.1, 1.1],
        [-0.1, 1.1],
        [-0.1, 0.8],
        [-0.35, 0.8],
        [-0.35, 0.6],
        [-0.1, 0.6],
    ],
    "far": [[100, 50], [101, 50], [101, 52], [100.2, 52.1]],
    "trapezium": [[-0.4, 0], [0.4, 0], [0.2, 1], [-0.2, 1]],
    "S": [[0, 0], [3, 0], [3, 2], [1, 2], [1, 3], [3, 3], [3, 4], [0, 4], [0, 1.5], [2, 1.5], [2, 1], [0, 1]],
    "boulder": [
        [-0.18, 0],
        [0.22, 0],
        [0.52, 0.31],
        [0.61, 0.78],
        [0.38, 1.22],
        [-0.12, 1.37],
        [-0.49, 1.02],
        [-0.56, 0.47],
    ],
}


def of_solids() -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, shape in SHAPES.items():
        body = shape.body(1.4, 0.3, 1.5)
        parts = {
            item: getattr(body, item)
            for item in ("edges", "reach", "foot", "carriers", "b_over_h", "inverse_inertia", "ends")
        }
        found[name] = parts | {"body": body, "scaled": body.scaled(2.0), "outline": list(shape.outline(1.4, 0.3, 1.5))}
        found[name] |= {"springs": contact.VertexContact(1e-5, 0.7, 0.2).specific(body), "name": shape.name}
        found[name]["orientations"] = orientation_grid(15.0, shape, [1.0, 2.0])
    found["wide"] = contact.VertexContact().specific(Rectangle().body(4.0, 1.0, 1.0))
    hull = polyhedron._hull(LUMP)
    return found | {"hull": hull._asdict(), "rests": rest.can_rest(hull.normals, hull.offsets, 1.0)}


def of_polygons() -> dict[str, Any]:
    found: dict[str, Any] = {"rectangle": polygon.polygon("r", polygon.rectangle(0.3, 0.8))}
    for name, points in POLYGONS.items():
        one = polygon.polygon(name, points)
        faces = [part.faces for part in one.parts]
        about = {item: getattr(one, item) for item in ("width", "height", "fallen", "symmetric")}
        found[name] = about | {"polygon": one, "faces": faces, "pieces": pieces.convex_pieces(one.vertices)}
    joined = [
        [[0, 0], [1, 0], [1, 1], [0, 1]],
        [[1, 0.25], [2, 0.25], [2, 0.75], [1, 0.75]],
        [[0.5, 1], [1, 1], [1, 2], [0.5, 2]],
    ]
    outline = pieces.outline("joined", [np.array(piece) for piece in joined])
    return found | {"outline": outline, "bend": pieces.bend(*np.array([[0, 0], [2, 1], [1, 3.0]]))}


def of_scenes() -> dict[str, Any]:
    found: dict[str, Any] = {}
    for path in sorted((ROOT / "config" / "scenes").glob("*.yaml")):
        one = scene.load_scene(path)
        for height, ratio in ((None, None), (2.0, 0.5), (0.1, None)):
            placed = geometry.place(one, height, ratio)
            pairs = geometry.pairs_of(placed)
            found[f"{path.stem} {height} {ratio}"] = {
                "at": [[p.x, p.z, p.mass, p.inertia, p.drop, p.fallen, p.size] for p in placed],
                "pairs": pairs,
                "touches": [[t.pair, t.side, *t.end.point, *t.end.normal] for t in geometry.resting(placed, pairs)],
            }
        about = (
            geometry.ground_of(one),
            geometry.plane_period(one),
            geometry.native_size(one),
            one.free,
            one.single_block,
        )
        found[path.stem] = [*about, one.sweeps_friction, one.shown_name, one.reference_name, Planes(one).cost]
    wall = {"name": "wall", "kind": "held", "width": 10, "height": 1, "at": [-20, 0]}
    grounds = (
        [GROUND, STONE, wall],
        [GROUND, STONE],
        [GROUND, {**STONE, "height": 3}],
        [GROUND, {**STONE, "width": 3}],
    )
    found["grounds"] = [
        [geometry.ground_of(one), one.single_block]
        for one in (scene.check_scene({"name": "t", "elements": elements}) for elements in grounds)
    ]
    tilted = element.Element(name="t", width=0.3, height=0.8, rotation_deg=30, at=(1, 2))
    return found | {"tilted": tilted.points, "own": list(tilted.own_size), "separations": _gaps_of_two()}


def _gaps_of_two() -> list[Any]:
    one = scene.check_scene({"name": "t", "elements": [GROUND, STONE, {**STONE, "name": "b", "at": [0.5, 0]}]})
    return [
        [end.gap, *end.point, *end.normal, *end.tangent]
        for pair in geometry.pairs_of(geometry.place(one))
        for end in geometry.common_stretch(*(geometry.place(one)[k] for k in pair[:2]))
    ]


GROUND = {"name": "ground", "kind": "driven", "width": 40, "height": 1, "at": [0, -1]}
STONE = {"name": "stone", "width": 0.24, "height": 0.6, "stands_on": "ground"}


def checked(*elements: dict[str, Any], **keys: Any) -> Callable[[], Any]:
    return lambda: scene.check_scene({"name": "t", "elements": list(elements), **keys})


def of_refused_scenes() -> dict[str, Any]:
    law = {"between": ["stone", "stone"]}
    stones = [{**STONE, "name": f"s{k}", "at": [0.3 * k, 0]} for k in range(65)]
    forms = (
        {"width": 1},
        {"width": 1, "height": 1, "vertices": POLYGONS["L"]},
        {"pieces": []},
        {"vertices": POLYGONS["L"]},
        {},
        {"pieces": [POLYGONS["triangle"]], "width": 1},
    )
    alone = [{**STONE, "kind": "held", "fallen_rotation_deg": 30}, {**STONE, "kind": "held", "fallen_drop": 1}]
    return refusals(
        checked(GROUND, STONE),
        checked(GROUND),
        checked(STONE, {**STONE, "name": "b"}),
        checked(GROUND, {**STONE, "kind": "held"}),
        checked(GROUND, STONE, STONE),
        checked({**STONE, "stands_on": "later"}, GROUND),
        checked(GROUND, STONE, gravity=0),
        checked(GROUND, STONE, gravity=1e-3),
        checked(GROUND, STONE, reference="x"),
        checked(GROUND, STONE, reference="ground"),
        checked(GROUND, {**STONE, "material": "wood"}),
        checked(GROUND, STONE, contacts=[law, law]),
        checked(GROUND, STONE, contacts=[law]),
        checked(GROUND, STONE, contacts=[{"between": ["wood", "stone"]}]),
        checked(GROUND, {**STONE, "at": [0, 0.1]}),
        checked(GROUND, {**STONE, "at": [0, 5e-8]}),
        checked(GROUND, {**STONE, "at": [0, 1e-7]}),
        checked(GROUND, {**STONE, "at": [0, -1e-6]}),
        checked(GROUND, {**STONE, "at": [0, -2e-7]}),
        checked(GROUND, {**STONE, "at": [30, 0]}),
        checked(GROUND, *stones),
        checked(GROUND, *stones[:63]),
        checked(GROUND, STONE, {**STONE, "name": "b", "at": [0.2, 0]}),
        *(checked(GROUND, {"name": "x", "stands_on": "ground", **form}) for form in forms),
        *(checked(GROUND, STONE, one) for one in alone),
        *(
            checked(GROUND, {**STONE, key: value})
            for key, values in {
                "fallen_rotation_deg": (0, 1, 180, 181),
                "fallen_drop": (0, 0.1),
                "depth": (0, 0.1),
                "width": (0, -1, np.inf),
                "name": ("", "-", "a-1", "A"),
            }.items()
            for value in values
        ),
        *(
            checked(GROUND, STONE, contacts=[law | more])
            for more in (
                {"friction": -0.1},
                {"friction": 0},
                {"stiffness": 0},
                {"stiffness": 1, "static_penetration": 1e-6},
                {"damping": -1},
                {"damping": 0},
                {"damping": 1, "damping_ratio": 1},
                {"stiffness_ratio": -1},
                {"stiffness_ratio": 0},
                {"damping_ratio": -0.1},
                {"static_penetration": 0},
            )
        ),
        lambda: scene.load_scene("monolit"),
        lambda: scene.gravestone(density=0.0),
        lambda: scene.gravestone(density=np.inf),
        lambda: scene.gravestone(density=1e-3),
    )


def of_refusals() -> dict[str, Any]:
    box = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (0.0, 0.6)])
    lean = BOULDER + np.where(BOULDER[:, 2:] > 0, [[3.0, 0, 0]], 0.0)
    boulder = Polyhedron(BOULDER)
    given = (
        box * 1000,
        box[:4],
        box[:3],
        box * [1, 1, 0],
        box * [1, 1, 1e-7],
        np.append(box, [[0, 0, 0.3]], axis=0),
        lean,
        box[:, [2, 1, 0]] @ [[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]],
        box,
        np.append(box, [[0.1, 0.2, 0.6 + 5e-7]], axis=0),
        BOULDER * [1, 1, -1],
        np.full((5, 3), np.nan),
        BOULDER / 71,
        BOULDER * 71,
    )
    ring = [[x, 0.9 * np.sin(t)] for t in np.linspace(0, 6, 7) for x in [np.cos(t)]]
    outlines = (
        [[0, 0], [1, 0]],
        [[0, 0], [1, 0], [2, 0]],
        [[0, 0], [0, 1], [1, 0]],
        [[0, 0], [1, 1], [1, 0], [0, 1]],
        [[0, 0]] * 3,
        [[0, 0], [1, 0], [1, 0], [0, 1]],
        [[0, 0], [1, 0], [2, 0], [0, 1]],
        [[0, 0], [2, 0], [2, 2], [1, 0], [0, 2]],
        [[0, 0, 0]] * 3,
        [[0, 0], [np.inf, 0], [0, 1]],
        ring,
        [[0, 0], [1, 0], [1, 1e-8], [0, 1e-8]],
    )
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    joints = (
        [square, square + np.array([0.9, 0])],
        [square, square + np.array([2, 0])],
        [square, square + np.array([1, 0])],
        [square, square + np.array([1 - 1e-7, 0])],
        [square + s for s in ([0, 0], [1, 0], [2, 0], [0, 1], [2, 1], [0, 2], [1, 2], [2, 2])],
    )
    numbers = {
        "stiffness": (0, -1, 1.0, "soft", np.inf),
        "stiffness_ratio": (-1, 0),
        "damping_ratio": (-1, 0),
        "damping": (-1, 0, np.nan),
        "static_penetration": (0, 1e-9),
    }
    columns = {
        "height": (0.01, 0.0099, 50, 50.1, 0),
        "b_over_h": (0, -1, np.nan),
        "friction": (-0.1, 0),
        "amplitude": (-1, 0),
        "damping_factor": (-1, 0),
        "initial_tilt": (0.2, 0.19, -0.2, 1.6),
        "aspect": (0, 1),
        "azimuth_deg": (np.inf, -720),
    }
    case = {"azimuth_deg": 0.0, "height": 0.6, "b_over_h": 0.2, "friction": 1.0}
    return refusals(
        *(lambda one=one: Polyhedron(one) for one in given),
        *(lambda one=one: polygon.polygon("p", one) for one in outlines),
        *(lambda one=one: pieces.outline("j", one) for one in joints),
        *(lambda one=one: shape_of(one) for one in (2, 3, 96, 97, "oval", 1.5, "circle")),
        *(lambda key=key, one=one: contact.Contact(**{key: one}) for key, ones in numbers.items() for one in ones),
        lambda: contact.Contact(damping=1.0, damping_ratio=1.0),
        lambda: contact.Contact(stiffness=1.0, static_penetration=1e-6),
        *(
            lambda one=one: contact.VertexContact(**one)
            for one in ({"static_penetration": 0}, {"stiffness_ratio": 0}, {"damping_ratio": -1})
        ),
        *(
            lambda one=one: contact.check_precision(np.array([one]), np.array([0.6]), 3.0)
            for one in (7e10, 7.4e10, 1e12)
        ),
        *(lambda key=key, one=one: cases.Cases(**case | {key: one}) for key, ones in columns.items() for one in ones),
        lambda: cases.Cases([[0.0]], 0.6, 0.2, 1.0),
        lambda: cases.Cases([0, 1], [1, 2, 3], 0.2, 1.0),
        lambda: cases.check_count(0),
        lambda: cases.check_count(50_000_000),
        lambda: cases.check_count(50_000_001),
        lambda: cases.check_count(80_000_000),
        *(
            lambda s=s, b=b: orientation_grid(s, shape_of(b))
            for s, b in (
                (90, 4),
                (91, 4),
                (89.9999999, 4),
                (120 + 5e-8, boulder),
                (120 + 2e-7, boulder),
                (0.02, boulder),
                (1e-9, boulder),
                (0, 4),
                (7, "circle"),
                (-5, 4),
            )
        ),
        lambda: Grid.over(azimuth_deg=[], height=[1.0]),
        lambda: Grid.over(azimuth_deg=[[0.0]]),
        lambda: Body("rectangle").sizes(None, 0.2),
        lambda: Body("rectangle").sizes(0.6, None),
        lambda: Body(Polyhedron(BOULDER)).sizes(None, 0.2),
        lambda: Body(8).periods(np.array([2.0])),
        lambda: Body("rectangle", contact.Contact()),
        lambda: Planes().periods(np.array([2.0])),
        lambda: planes.fall_probability(xr.Dataset()),
        *(
            lambda at=at: Body(4, start=Start((0, 0, 1), (1, 0, 0, 0))).sources(grid_of(orientation=at))
            for at in ([0, 89], [0, 90], [90])
        ),
    )


def grid_of(**direction: Any) -> Grid:
    rows = {name: np.asarray(values, float) for name, values in direction.items()}
    return Grid(rows | {"height": np.array([0.6, 1.2]), "b_over_h": np.array([0.2]), "aspect": np.array([1.0, 2.0])})


def of_grids() -> dict[str, Any]:
    grid = Grid({"azimuth": np.arange(0, 360, 45.0), "height": np.array([0.6, 1.2])}, ("a", "b"), (1.0, 2.0))
    made = Grid.over(azimuth_deg=[0, 10], height=0.6, b_over_h=[0.1, 0.2])
    asked, direction = (
        np.array([0, 4, 44, 44.9, 45, 89, 134, 180, 200, 269.9, 359, 400, -20.0]),
        np.array([10, 40, 100.0, 130, 170]),
    )
    directions = np.array([0.0, 30, 90, 120, 180, 210, 359.9999999999])
    at = [np.array([0, 3, 7]), np.array([1, 0, 1])]
    case = Grid({name: np.array([0.3, 0.6]) for name in ("azimuth", "height", "b_over_h", "friction")}).cases(
        [np.array([0, 1])] * 4, 5.0
    )
    return {
        "shapes": [list(grid.shape_of(item)) for item in VARIABLES[:4]],
        "dimensions": [list(grid.dimensions(item)) for item in VARIABLES[:4]],
        "over": [list(made.names), list(made.shape), made.size],
        "case": case,
        "axes": AXES,
        "all": grid.over_all(np.arange(8).reshape(8, 1)),
        "changed": grid.changed(height=np.array([1.0])).size,
        "at": [row.tolist() for row in at],
        "directions": grid.directions,
        **{f"nearest {p}": nearest(direction, asked, p) for p in (0.0, 90.0, 180.0, 360.0, 360 / 7)},
        "planes": nearest_planes(direction, asked),
        "representatives": representatives(directions, [180.0, 90.0, 0.0, 360.0]),
        "index": planes.plane_index(directions),
        "index of none": planes.plane_index([]),
        "gaps": list(planes.gaps_of([0, 10, 20, 25, 30, 100, 110])),
        **{
            f"weights {p} {w}": planes.plane_weight([0, 10, 20, 25, 30, 100, 110], p, whole_circle=w)
            for p in (180, 360)
            for w in (True, False)
        },
        "azimuths": planes.azimuth_weight([0, 10, 20, 60, 180, 190, 350]),
    }


def of_falls() -> dict[str, Any]:
    dice = np.random.default_rng(3)
    flags, time = dice.choice([0, 1, 1, np.nan], (3, 60)), dice.choice([1.0, 2.0, 3.0, np.nan], (3, 60))
    shape, members = (1, 8, 2, 1, 2, 1), dice.choice([-128, -1, 0, 1], (30, 16), p=[0.1, 0.2, 0.4, 0.3]).astype(np.int8)
    scramble, angle = np.repeat([0, 1], 8), dice.integers(0, 360, (30, 16)).astype(float)
    names = ("orientation", "height", "b_over_h", "aspect", "friction")
    rows = {
        "orientation": np.arange(0, 360, 45.0),
        "height": [0.6, 1.2],
        "b_over_h": [0.2],
        "aspect": [1.0, 2.0],
        "friction": [0.5],
    }
    fell = dice.choice([0.0, 1.0, np.nan], shape, p=[0.4, 0.5, 0.1])
    parts: dict[str, Any] = {
        "overturned": fell,
        "fall_azimuth": np.where(fell == 1, dice.integers(0, 360, shape), np.nan),
    }
    parts |= {
        name: dice.integers(-9, 10, shape) / 8
        for name in ("residual_slip_north", "residual_slip_east", "residual_twist")
    }
    parts |= {
        name: dice.integers(-8, 9, shape) / 8
        for name in ("fall_north", "fall_east", "fall_axis_cosine", "fall_axis_sine")
    }
    parts["probability_falls"] = np.where(dice.random(shape) < 0.2, np.nan, dice.integers(0, 9, shape) / 8)
    space = xr.Dataset({name: (("amplitude", *names), values) for name, values in parts.items()}, rows).isel(
        amplitude=0
    )
    flat = space.isel(aspect=0, drop=True).rename(orientation="azimuth")
    flat = flat.assign(overturned=flat["overturned"] * np.where(dice.random(flat["overturned"].shape) < 0.5, 1, -1))
    flat["overturning_time"] = flat["residual_slip_north"] ** 2
    cells = {"height": np.array([0, 1, 1, 0]), "b_over_h": np.zeros(4, int), "friction": np.zeros(4, int)}
    face = np.array([3.0, 50.0, 100.0, 359.0])
    turned: dict[str, Any] = {}
    for name, model, grid in (
        ("planes", Planes(), grid_of(azimuth=[0, 20, 180, 200])),
        ("body", Body(4), grid_of(orientation=[0, 90, 180, 355])),
    ):
        grid = Grid({key: row[:1] if key == "aspect" else row for key, row in grid.rows.items()})
        arrays = vars(Results.at_rest(model.variables, grid.size))
        arrays = {key: (np.arange(grid.size) % 3).reshape(grid.shape).astype(one.dtype) for key, one in arrays.items()}
        model.turned(arrays, grid, model.sources(grid))
        turned[name] = arrays
    return {
        "first edge": list(first_edge(flags, time, np.arange(180.0).reshape(3, 60))),
        "turned": turned,
        "chances": edge_chances(dice.integers(0, 9, (2, 60)) / 8, time[:2]),
        "planes": Planes().tally(members, angle, scramble),
        "elements": Planes().tally(np.stack([members, members[::-1]], axis=-1), angle, scramble),
        "body": Body().tally(abs(members), angle, scramble),
        "falls in planes": Planes().falls(flat),
        "nominal falls": Planes().falls(flat, ensemble=False),
        "falls in space": Body().falls(space),
        "nominal in space": Body().falls(space, ensemble=False),
        "spread": Body().spread(space),
        "outcomes": Body().outcomes(space, face, cells),
        "outcomes in planes": Planes().outcomes(flat, face, cells),
        "models": [type(model_of(one)).__name__ for one in (space, flat)],
        "answered": answered(np.array([-128.0, -1, 0, 1, 2, np.nan])),
        "cells of all": Planes().representative(flat),
    }


def of_variables() -> dict[str, Any]:
    values = {"i1": np.array([0, 1, -1, -128]), "i2": np.array([0, 5, -32768]), "f4": np.array([0.0, -0.5, np.nan])}
    kinds = (VARIABLES, BODY_VARIABLES, PLANE_ENSEMBLE_VARIABLES, FACE_VARIABLES, BODY_ENSEMBLE_VARIABLES)
    found: dict[str, Any] = {}
    for number, kind in enumerate(kinds):
        for item in kind:
            arrays = {other.name: values[other.dtype][:3] + 0 * k for k, other in enumerate(kind)}
            found[f"{number} {item.name}"] = [
                item.dtype,
                item.units,
                item.per_element,
                item.of_falls,
                item.odd,
                item.exchanged,
                float(item.fill_value),
                float(item.missing),
                sorted(item.all_attributes),
                item.stored(values[item.dtype]),
                item.mirrored(arrays),
                item.attributes.get("flag_values", []),
            ]
    models: list[tuple[str, Model]] = [
        ("planes", Planes()),
        ("body", Body()),
        ("boulder", Body(Polyhedron(BOULDER))),
        ("octagon", as_model(8)),
    ]
    models.append(("stack", Planes(scene.load_scene("three-tier", ROOT))))
    for name, model in models:
        stiff = model.stiffer(8.0)
        aspect = np.array([1.0, 2.0]) if model.oblong else np.ones(1)
        found[name] = [
            model.cost,
            list(model.elements),
            model.attributes,
            model.sized,
            model.oblong,
            list(model.dims),
            model.direction_attributes,
            [item.name for item in model.further_variables],
            model.periods(aspect),
            str(getattr(stiff, "contact", "")),
            [str(law) for law in stiff.scene.contacts] if isinstance(stiff, Planes) else [],
        ]
    hard = scene.gravestone(contact.Contact(stiffness=2e6, damping=5.0))
    found["stiffer"] = [str(law) for law in Planes(hard).stiffer(8.0).scene.contacts]
    springs = (
        contact.Contact(),
        contact.Contact(stiffness=1e7, damping=500.0, stiffness_ratio=0.5),
        contact.Contact(damping_ratio=0.1),
    )
    found["springs"] = [list(one.specific([0.2, 0.5], [0.6, 2.0], 2700.0)) for one in springs]
    stored = Results.at_rest(VARIABLES, 4, 2)
    stored.store(
        np.array([1, 3]), {"status": [0, 2], "overturned": [[1, 0], [1, 1]], "overturning_time": [[2, 3], [4, 5.0]]}
    )
    return found | {"stored": vars(stored)}


MESHES = {
    "a.obj": "# a\nv 0 0 0\nv 1 0 0 # here\nv 0 1 0\nv 0.2 0.2 1\n\nf 1/1 3/2 2/3\nf -4 -3 -1\nf 2 3 4\nf 3 1 4\n",
    "notched.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.2 1\nv 1 1 0\nf 1 5 2\nf 1 2 4\n",
    "few.obj": "v 0 0 0\nv 1 0 0\n",
    "x.obj": "v a b c\n",
    "a.ply": "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty uchar red\nproperty float y\n"
    "property float z\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    "0 9 0 0\n1 9 0 0\n0 9 1 0\n0.2 9 0.2 1\n3 0 2 1\n3 0 1 3\n",
    "faces.ply": "ply\nformat ascii 1.0\nelement face 1\nproperty int a\nelement vertex 0\n"
    "property float x\nend_header\n",
    "a.stl": "solid a\n"
    + "".join(f"vertex {v}\n" for v in ("0 0 0", "0 1 0", "1 0 0", "0 0 0", "1 0 0", ".2 .2 1"))
    + "endsolid\n",
    "odd.stl": "solid a\n"
    + "".join(f"vertex {v}\n" for v in ("0 0 0", "0 1 0", "1 0 0", "0 0 0", "1 0 0", ".2 .2 1", "0 1 0")),
    "a.txt": "",
    "A.OBJ": "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.2 1\n",
}


def of_meshes() -> dict[str, Any]:
    corners = [
        np.array(face, float) for face in ([[0, 0, 0], [0, 1, 0], [1, 0, 0]], [[0, 0, 0], [1, 0, 0], [0.2, 0.2, 1]])
    ]
    triangles = b"".join(np.concatenate([np.zeros(3), *one]).astype("<f4").tobytes() + b"\0\0" for one in corners)
    stl = b"h" * 80 + len(corners).to_bytes(4, "little") + triangles
    binary: dict[str, bytes] = {"b.stl": stl, "cut.stl": stl[:-1]}
    for name, order in (("little", "<"), ("big", ">")):
        head = f"ply\nformat binary_{name}_endian 1.0\nelement vertex 4\nproperty double x\nproperty short s\n"
        head += "property float64 y\nproperty float z\nelement face 2\nproperty uchar flag\n"
        head += "property list uint8 uint16 vertex_index\nend_header\n"
        row = np.dtype([("x", f"{order}f8"), ("s", f"{order}i2"), ("y", f"{order}f8"), ("z", f"{order}f4")])
        rows = np.array([(0, 1, 0, 0), (1, 2, 0, 0), (0, 3, 1, 0), (0.2, 4, 0.2, 1)], row)
        faces = b"".join(bytes([7, 3]) + np.array(one, f"{order}u2").tobytes() for one in ([0, 2, 1], [0, 1, 3]))
        binary[f"{name}.ply"] = head.encode() + rows.tobytes() + faces
        binary[f"{name}, cut.ply"] = binary[f"{name}.ply"][:-2]
    found: dict[str, Any] = {}
    with TemporaryDirectory() as folder:
        for file, content in ({name: text.encode() for name, text in MESHES.items()} | binary).items():
            path = Path(folder) / file
            path.write_bytes(content)
            said = refusals(lambda path=path: read_mesh(path))["1"].replace(folder, "")
            found[file] = read_mesh(path).vertices if said == "accepted" else said
        found["gone"] = refusals(lambda: read_mesh(Path(folder) / "gone.obj"))["1"].replace(folder, "")
    return found


ANSWERS: Answers = {
    "interface": partial(interface_of, "model"),
    "solids": of_solids,
    "polygons": of_polygons,
    "scenes": of_scenes,
    "refused scenes": of_refused_scenes,
    "refusals": of_refusals,
    "grids": of_grids,
    "falls": of_falls,
    "variables": of_variables,
    "meshes": of_meshes,
    "keys": partial(keys_of, element.Material, element.ContactLaw, element.Element, scene.Scene),
}
