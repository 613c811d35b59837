"""What comes of made-up studies: cubes of every kind, ensembles, what is run again, sizes; and what is refused."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np
import xarray as xr
from pydantic import TypeAdapter

from overturning.errors import ConfigError
from overturning.motion.motion import Motion
from overturning.records.processing import process
from overturning.records.record import Record
from overturning.records.store import read_motion, rounded
from overturning.study import cube as cubes
from overturning.study import ensemble, evaluation, preflight, sections, values
from overturning.study.answers import compare, differ, elsewhere, unanswered
from overturning.study.convergence import NUDGE, WARN_ABOVE, Convergence
from overturning.study.convergence_check import PILOT, check_convergence, computations, on_the_ground
from overturning.study.crate import METADATA, write_crate
from overturning.study.cube import CONFIGURATION
from overturning.study.document import study_template, tables
from overturning.study.gather import RECORD_COORDINATES
from overturning.study.intensity import write_intensity
from overturning.study.load import check_study, portable
from overturning.study.netcdf import chunk_shape
from overturning.study.parts import Chunk, part_path, parts_of, piece_of
from overturning.study.recheck import recheck
from overturning.study.sample import MOST_RIGID, cannot_slide, choose, read_rigid, read_sample
from overturning.study.scenes import (
    NOMINAL,
    Sizes,
    directions,
    grid_of,
    motion_of,
    numerics_of,
    scene_of,
    sizes_said,
    variant_names,
)
from overturning.study.schema import Study
from overturning.study.small import run_study, to_dataframe, write_table
from overturning.study.sweep import ensemble_of, member_runner, simulate_variant, variables_of
from tests.kept import Answers, interface_of, keys_of, refusals
from tests.study.small_study import cube_of
from tests.study.test_config import ICY, IN_PLANES, IN_SCENES, IN_SPACE, SMALL, SOIL, SPACE

ROOT = Path(__file__).parents[2]
BASE: dict[str, Any] = {
    "name": "made",
    "records": {"use": ["a", "b"]},
    "azimuth": {"step": 45, "also": [100]},
    "b_over_h": [0.1, 0.15, 0.2, 0.3, 0.45],
    "friction": [0.5, 1.0],
    "ensemble": {"members": 8, "half_width": 0},
    "verification": {"at_least": 30, "cost": 30},
}
STUDIES: dict[str, dict[str, Any]] = {
    "planes": {"variants": {"soft": {"contact": {"stiffness": "20 MN/m"}, "vertical": False}}, "height": [0.6, 1.2]},
    "everywhere": {
        "ensemble": {"members": 24, "where": "everywhere", "half_width": 0.3, "initial_tilt": 0.02},
        "azimuth": {"start": 20, "stop": 110, "step": 30},
        "b_over_h": [0.15, 0.25],
    },
    "amplitudes": {
        "amplitude": [0.5, 1, 1.5],
        "azimuth": {"step": 90},
        "simulation": {"time_step": "1 ms", "leave_out": False, "vertical": False},
        "friction": [1.0],
    },
    "stack": {
        "scene": "three-tier",
        "azimuth": {"step": 180, "also": [60]},
        "b_over_h": [0.3, 0.38],
        "friction": [0.7],
        "variants": {"boulder": {"scene": "boulder"}},
        "ensemble": {"members": 2},
        "verification": {"at_least": 6, "cost": 1},
    },
    "space": {
        "azimuth": None,
        "body": {"aspect": [1, 2]},
        "orientation": {"step": 45},
        "b_over_h": [0.15, 0.25, 0.4],
        "friction": [0.7],
        "ensemble": {"members": 4, "where": "everywhere"},
        "verification": {"at_least": 12, "cost": 20},
    },
}


def study(name: str = "planes", **more: Any) -> Study:
    return check_study({key: value for key, value in (BASE | STUDIES[name] | more).items() if value is not None}, name)


def records() -> list[Record]:
    time = np.arange(0, 3.2, 0.01)
    cycle, across = (np.where(time < 1.6, np.sin(2 * np.pi * (time - lag) / 0.8), 0.0) for lag in (0.0, 0.2))
    north, east, up = 4.0 * cycle - 1.5 * across, 1.0 * cycle + across, 2.0 * np.sin(2 * np.pi * time / 0.3)
    about: dict[str, Any] = {"station": "S", "source": "made", "licence": "none", "sha256": "0" * 64}
    extra = {"pulse": True, "magnitude": 6.5, "wall": "foot", "event_latitude": 1.0, "event_longitude": 2.0}
    one = Record(
        "a", north, east, up, 0.01, event="E", fault_strike_deg=290.0, latitude=3.0, longitude=4.0, extra=extra, **about
    )
    other = Record("b", 0.7 * east, -0.7 * north, None, 0.01, event="F", extra={"event_latitude": 1.0}, **about)
    return [rounded(one), rounded(other)]


STORED = ("dtype", "shuffle", "complevel", "chunksizes", "_FillValue")


def contents(path: Path) -> dict[str, Any]:
    """Everything in a file but the versions of libraries and what the numbers are called."""
    with xr.open_dataset(path, decode_times=False, mask_and_scale=False) as file:
        about = {
            name: text
            for name, text in file.attrs.items()
            if name not in ("versions", "content_sha256", "source", "history", "study")
        }
        found: dict[str, Any] = {str(name): one.to_numpy() for name, one in file.variables.items()}
        return found | {
            "attributes": about,
            "of variables": {name: sorted(one.attrs) for name, one in file.variables.items()},
            "stored": {name: [str(one.encoding.get(key)) for key in STORED] for name, one in file.data_vars.items()},
        }


def of_cubes(name: str) -> dict[str, Any]:
    """The cubes of a study, what is found of them, and what is run again."""
    given, found = study(name), dict[str, Any]()
    with TemporaryDirectory() as folder:
        place = Path(folder)
        for variant in variant_names(given):
            path = cube_of(given, records(), place, variant)
            found[variant] = contents(path)
            with cubes.open_cube(path, amplitude=None, element=None) as opened:
                found[f"{variant} opened"] = {
                    "said": cubes.variant_said(opened),
                    "block": cubes.shown_block(opened),
                    "sizes": dict(opened.sizes),
                }
        path = place / "cube.nc"
        again = recheck(path, cells=9)
        again.differences.clear()
        sample, rigid = read_sample(path, given.verification), read_rigid(path, given)  # type: ignore[arg-type]
        kept = [read_motion(place / "motion" / f"{one}.nc") for one in "ab"]
        checked = check_convergence(
            given, kept, replace(sample, block_steps=max(sample.block_steps, 40_000)), rigid=rigid
        )
        checked.write(place / "c.json")
        found |= {
            "recheck": again,
            "sample": sample,
            "checked": checked.model_dump(),
            "read": Convergence.read(place / "c.json") == checked,
        }
        found["cheap"] = check_convergence(
            given, kept, replace(sample, block_steps=sample.block_steps // 40)
        ).model_dump()
        with cubes.open_cube(path) as opened:
            rows = write_table(opened, place / "t.csv")
            found["table"] = [rows, to_dataframe(opened).shape, (place / "t.csv").read_text().splitlines()[:3]]
            found["said"] = (
                [
                    cubes.shown_element(opened),
                    cubes.sizes_of_another(opened),
                    cubes.earthquakes_said(opened),
                    cubes.friction_said(opened, 0.5),
                ]
                if given.body is None
                else []
            )
        for title in ("", "Ärger"):
            write_crate(given.model_copy(update={"title": title}), place, [path])
            graph = json.loads((place / METADATA).read_text(encoding="utf-8"))["@graph"]
            root = next(one for one in graph if one["@id"] == "./")
            told = [
                line for line in (place / CONFIGURATION).read_text(encoding="utf-8").splitlines() if "title:" in line
            ]
            found[f"crate {title}"] = [root["name"], root["description"], str(root["license"]), *told]
        with cubes.open_records(path) as opened:
            found["records"] = [
                cubes.record_number(opened, "b"),
                sorted(cubes.processing_of(opened)),
                [one["id"] for one in cubes.sources_of_records(opened)],
            ]
    return found


def of_members() -> dict[str, Any]:
    dice, kinds = (
        np.random.default_rng(3),
        [{}, {"members": 10, "seed": 5}, {"members": 2, "azimuth": 0, "initial_tilt": 0.1, "damping": 0.5}],
    )
    flags = dice.choice([-1, 0, 1, 2, -128], (9, 2, 12, 2)).astype(np.int8)
    few = np.zeros((2, 1, 12, 1), np.int8)
    few[0, 0, 5:, 0] = few[1, 0, 11, 0] = 1
    members = [ensemble.draw_members(sections.Ensemble(**kind)) for kind in kinds]
    runs = dice.choice([-1, 0, 1, -128], (80, 24), p=[0.05, 0.8, 0.1, 0.05]).astype(np.int8)
    told: list[tuple[int, int]] = []
    part = ensemble.part_of(lambda done, of: told.append((done, of)), 0.25, 0.75)
    if part:
        part(0, 4), part(3, 4), part(0, 0)
    with TemporaryDirectory() as folder:
        members[1].write(Path(folder) / "m.csv")
        back = ensemble.Members.read(Path(folder) / "m.csv")
    return {
        "drawn": members,
        "batches": [[batch.tolist() for batch in one.batches(8)] for one in members],
        "read": back,
        "parts": told,
        "nothing": ensemble.part_of(None, 0, 1),
        "few": ensemble.cells_to_run(few, False),
        "cells": ensemble.cells_to_run(flags, False),
        "everywhere": ensemble.cells_to_run(flags, True).sum(),
        "of elements": ensemble.cells_to_run(np.stack([few, 0 * few], axis=-1), False),
        "one B/H": ensemble.cells_to_run(few[:, :, :1], False),
        "wilson": [
            list(ensemble.wilson(k, n)) for k, n in ((0, 0), (0, 8), (8, 8), (3, 8), (24, 24), (12, 24), (1, 1))
        ],
        "settled": {str(width): ensemble.settled(runs, width) for width in (0.0, 0.15, 0.19, 0.3)},
        "elements settled": ensemble.settled(np.stack([runs, runs[::-1]], axis=-1), 0.19),
        "narrow": [ensemble.narrow(np.arange(9), 8 - np.arange(9), 8, width) for width in (0.2, 0.3)],
    }


def of_groups() -> dict[str, Any]:
    """How many cases of an ensemble are run at a time, where memory is short."""
    given, calls = study("everywhere", ensemble={"members": 16, "where": "everywhere"}), list[list[int]]()
    motion, grid = motion_of(given, records()[0]), grid_of(given)
    numerics, found = numerics_of(given), dict[str, Any]()
    nominal = simulate_variant(given, NOMINAL, motion, grid, numerics)
    for most in ((10**7, 10**6), (10**7, 60), (1, 1), (17 * 320, 10**6)):
        calls.append([])

        def run(cases: Any, progress: Any, sizes: list[int] = calls[-1]) -> Any:
            sizes.append(cases.size)
            return member_runner(given, NOMINAL, motion, numerics)(cases, progress)

        with patch.multiple(ensemble, MOST_GROUND_VALUES=most[0], MOST_MEMBERS=most[1]):
            arrays, steps = ensemble_of(given, everywhere=True).run(motion, grid, nominal, run)
        found[str(most)] = [steps, arrays["probability_towards"], [str(size) for size in calls[-1]]]
    return found


def of_sizes() -> dict[str, Any]:
    """What a run is said to take, counted: of records, cases, members, elements, variants, amplitudes and chunks."""
    found: dict[str, Any] = {}
    for name in STUDIES:
        for chunks in (1, 7):
            size = preflight.size_of(study(name), chunks)
            found[f"{name}, {chunks} chunks"] = [
                size.records,
                size.cases,
                size.processor_s,
                size.memory_bytes,
                size.disk_bytes,
                size.reading_bytes,
                str(size),
            ]
    one = check_study(SMALL, "x")
    large = study(azimuth={"step": 0.01}, ensemble={"members": 4096, "where": "everywhere"})
    edges = [
        preflight.on_one_page(
            study(
                azimuth={"step": step},
                height=[0.6],
                b_over_h={"start": 0.1, "stop": 0.1 + (n - 1) * 0.001, "step": 0.001},
            )
        )
        for step, n in ((0.36, 750), (0.36, 751))
    ]
    return found | {
        "one": str(preflight.size_of(one)),
        "large": str(preflight.size_of(large)),
        "pages": edges,
        "times": [preflight._time(s) for s in (0.2, 1.6, 119.9, 120, 7199, 7200, 172_799, 172_800, 1e7)],
        "bytes": [
            preflight._bytes(count)
            for count in (1, 900, 1e3, 9.9e3, 999e3, 1e6, 9.94e6, 1e7, 5e8, 1e9, 9.96e9, 2e10, 1e12, 5e13)
        ],
    }


def of_weak() -> dict[str, Any]:
    """Records just too weak to move a stone, and just strong enough."""
    g, found = 9.80665, {}
    for name, more in {
        "plain": {},
        "friction": {"friction": [0.05, 1.0]},
        "twice": {"amplitude": [1, 2]},
        "soil": SOIL,
        "scene": {"scene": "boulder", "friction": [1.0], "b_over_h": [0.5]},
    }.items():
        for peak in (0.0499, 0.0501, 0.0999, 0.1001):
            for up in (None, -0.1 * g):
                north = np.array([0.0, peak * g, 0.0])
                record = Record("r", 0.6 * north, 0.8 * north, None if up is None else np.full(3, up), 0.01)
                found[f"{name} {peak} {up}"] = preflight._too_weak(
                    study(**more, **({"variants": {}} if name in ("soil", "scene") else {})), record
                )
    for aspects in ([0.5, 1], [1.5, 2]):
        given = {"name": "s", "records": {"use": ["a"]}, "b_over_h": [0.2], "friction": [1.0]}
        oblong = check_study(given | {"body": {"aspect": aspects}}, "s")
        for peak in (0.0999, 0.1001, 0.1999, 0.2001):
            record = Record("r", np.full(2, peak * g), np.zeros(2), None, 0.01)
            found[f"oblong {aspects} {peak}"] = preflight._too_weak(oblong, record)
    return found


def of_values() -> dict[str, Any]:
    quantities = [
        ("60 cm", "m"),
        ("600mm", "m"),
        ("2 min", "s"),
        ("5 ms", "s"),
        ("2.65 g/cm³", "kg/m³"),
        ("2.6 t/m3", "kg/m³"),
        ("3 kN/m", "N/m"),
        ("3 MN/m", "N/m"),
        ("2 GN/m", "N/m"),
        ("4 kN*s/m", "N·s/m"),
        ("4 N s/m", "N·s/m"),
        ("30 mrad", "rad"),
        ("-.5e1 deg", "°"),
        ("1 degrees", "°"),
        (3, "m"),
        (True, "m"),
        ("x", "m"),
        ("1 ft", "m"),
        (None, "s"),
    ]
    ranges: list[tuple[float, float, float]] = [
        (0.1, 0.6, 0.05),
        (0, 1, 0.3),
        (0, 0, 1),
        (1, 0, 1),
        (0, 1e5, 1),
        (0, 1.00001e5, 1),
        (0, 1, 0),
    ]
    turns: tuple[dict[str, Any], ...] = (
        {},
        {"step": 90},
        {"step": 7},
        {"step": 11.25},
        {"step": 0.01},
        {"step": 0.0099},
        {"start": 10, "stop": 50, "step": 7},
        {"start": 50, "stop": 50},
        {"start": 360},
        {"stop": 361},
        {"step": 0},
        {"step": 360},
        {"step": 361},
        {"start": 359.9, "stop": 360, "step": 90},
        {"also": ["30 deg", 390, -20]},
        {"start": -1},
        {"step": 100},
    )
    listed = TypeAdapter(values.Values[float])
    return {
        "quantities": refusals(*(lambda v=v, u=u: values.parse_quantity(v, u) for v, u in quantities)),
        "read": [values.parse_quantity(v, u) for v, u in quantities[:15]],
        "ranges": refusals(*(lambda a=a, b=b, c=c: values.Range(start=a, stop=b, step=c) for a, b, c in ranges)),
        "of ranges": [values.Range(start=a, stop=b, step=c).values() for a, b, c in ranges[:3]],
        "azimuths": refusals(*(lambda turn=turn: values.AzimuthRange(**turn) for turn in turns)),
        "of azimuths": [values.AzimuthRange(**turns[n]).values() for n in (0, 1, 3, 6, 11, 13, 14)],
        "lists": refusals(
            *(
                lambda one=one: listed.validate_python(one)
                for one in ([], [1, 1], [2, 1], 3, {"start": 0, "stop": 1, "step": 0.5}, "1 m")
            )
        ),
        "sorted": listed.validate_python([2, 1, 1.5]),
        "chunks": refusals(
            *(
                lambda text=text: Chunk.parse(text)
                for text in ("3-of-8", "0-of-8", "8-of-8", "9-of-8", "1-of-1234567890", "x", "1-of-123456789")
            )
        ),
        "directions": [str(directions(one).dtype) for one in ([1, 2], [1.5])],
        "shapes": [
            list(chunk_shape(shape))
            for shape in ((72, 1, 6, 2), (3600, 1, 600, 2), (10, 2000, 2000), (1 << 20, 1), ((1 << 20) + 1, 1), (5, 0))
        ],
        "paths": [str(part_path(Path("f"), "r", Chunk(3, 8))), *map(str, parts_of(Path("f"), "ab", 2))],
        "coordinates": RECORD_COORDINATES,
        "limits": [PILOT, NUDGE, WARN_ABOVE, MOST_RIGID],
    }


def messages() -> dict[str, Any]:
    """What is said of wrong studies, whole; and of bounds, at and beyond them."""
    changes = [
        *(change for change, _ in IN_PLANES),
        *({"scene": "three-tier"} | change for change, _ in IN_SCENES),
        *(SPACE | change for change, _ in IN_SPACE),
    ]
    changes += [
        {section: {key: value}} for section, keys in BOUNDS.items() for key, given in keys.items() for value in given
    ]
    changes += [
        {key: [value]}
        for key, given in {
            "b_over_h": (0, 1e-3, 10, 10.1),
            "friction": (0, 100, 101),
            "amplitude": (0, 1, 100, 101),
            "height": (0.01, 50),
        }.items()
        for value in given
    ]
    changes += [
        {"density": 0},
        {"density": "1 g/cm³"},
        {"verification": "none"},
        {"verification": "no"},
        {"records": {"use": []}},
        {"records": {"use": ["x"], "pulses": {"P": "x"}}},
        {"name": "-"},
    ]
    changes += [
        {"published": [{"record": "rinaldi", "azimuth": 60, "b_over_h": 0.3, "overturns": True} | more]}
        for more in ({}, {"azimuth": 61}, {"b_over_h": 0.31}, {"record": "x"}, {"pga_gal": 0}, {"pgd_cm": 0})
    ]
    changes += (
        [{"body": {"plan": plan}} for plan in (2, 3, 96, 97)]
        + [{"body": {"aspect": [a]}} for a in (0, 10, 10.1)]
        + [SPACE | {"orientation": {"step": 45, "start": s}} for s in (44.9, 45)]
    )
    return refusals(
        *(
            lambda change=change: check_study({k: v for k, v in (SMALL | change).items() if v is not None}, "mine.yaml")
            for change in changes
        )
    )


BOUNDS: dict[str, dict[str, tuple[Any, ...]]] = {
    "contact": {
        "stiffness": (-1, "1 N/m", "hard"),
        "stiffness_ratio": (-0.1, 0),
        "damping_ratio": (-0.1, 0),
        "damping": (-1, 0),
    },
    "simulation": {"time_step": (0, -1, "1 ms"), "scheme": ("euler",)},
    "ensemble": {
        "members": (-2, 0, 4096, 4098, 3),
        "half_width": (-0.1, 0, 0.49, 0.5),
        "amplitude": (-0.1, 0.99, 1),
        "b_over_h": (-0.1, 1),
        "friction": (-0.1, 0, 1),
        "damping": (-0.1, 1),
        "azimuth": (-1, 0, 90, 91),
        "initial_tilt": (-0.1, 0.09, 1.5),
        "seed": (-1, 0),
    },
    "verification": {"share": (0, 1, 1.1), "at_least": (0, 1), "cost": (0, 0.1), "seed": (-1, 0)},
    "figures": {
        "size": (0.4, 0.5, 4, 4.1),
        "dpi": (49, 50, 1200, 1201),
        "height": (0,),
        "friction": (-1,),
        "formats": (["png", "pdf"], ["gif"]),
    },
    "population": {
        "fixed": (-0.1, 0, 0.99, 1),
        "face": (3,),
        "face_spread": (-1, 10, 181),
        "shifted": (0,),
        "rotated": (0, 180, 181),
        "period": ([0.01], [0.009], [10], [11]),
        "stones": (15, 16, 65536, 65537),
        "seed": (-1,),
        "width": ({"low": 0, "high": 1},),
    },
    "azimuth": {"step": (0, 360, 361), "start": (-1, 359, 360), "stop": (0, 360, 361)},
}


def of_variants() -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in STUDIES:
        given = study(name)
        for variant in variant_names(given):
            sizes, grid = Sizes.of(given, variant), grid_of(given, variant)
            ratio = sizes.ratios(np.array([0.2999, 0.381, 0.1 + 0.2]), np.array([0.3, 0.38]))
            pieces = [
                [piece_of(given, grid, Chunk(number, of), variant).directions.tolist() for number in range(1, of + 1)]
                for of in (1, 3, 20)
            ]
            about: list[Any] = [
                sizes.factor,
                sizes.own_ratio,
                sizes.digits,
                sizes.heights(np.array([0.6, 1.2])),
                ratio,
                sizes_said(given, variant),
                pieces,
            ]
            about += [
                scene_of(given, variant).name,
                [item.name for item in variables_of(given)],
                list(grid.shape),
                motion_of(given, records()[0], variant).up is None,
            ]
            found[f"{name}, {variant}"] = about
        found[name] = [
            given.cases,
            given.several_blocks,
            str(numerics_of(given)),
            list(given.aspects),
            cannot_slide(given),
            json.dumps(portable(given))[:200],
        ]
    return found | {
        "template": study_template("n", ["a", "b"], "T", 7.5),
        "tables": {name: text.splitlines() for name, text in tables().items()},
    }


def of_answers() -> dict[str, Any]:
    dice, one, other = np.random.default_rng(5), unanswered(60, 2), unanswered(60, 2)
    for answers in (one, other):
        answers["overturned"] = dice.choice([-128, -1, 0, 1], (60, 2), p=[0.1, 0.2, 0.3, 0.4])
        answers["azimuth"] = dice.choice([0.0, 14.9, 15.0, 15.1, 345.0, 350.0, 180.0, np.nan], 60)
    away = elsewhere(one, other)
    grid, motion = grid_of(study("planes")), Motion.of(records()[0])
    some = grid.cases(
        [np.array(p) for p in ([0, 1, 2], [0, 1, 0], [0, 2, 4], [0, 1, 1])], amplitude=np.array([1.0, 4.0, 5.0])
    )
    again = {name: compute(motion, some).overturned for name, compute in computations(study("planes")).items()}
    choices = [
        choose(sections.Verification(share=s, at_least=n, seed=k), 3, dice.random((6, 2, 4)) < 0.6)
        for s, n, k in ((0.1, 1, 1), (0.1, 30, 2), (1.0, 1, 3))
    ]
    step = computations(study("amplitudes"))["stiffer"]
    return {
        "away": away,
        "compared": compare(one["overturned"][:, 0], other["overturned"][:, 0], away).model_dump(),
        "in planes": compare(one["overturned"], other["overturned"]).model_dump(),
        "differ": differ(one, other),
        "on the ground": on_the_ground(motion, some),
        "again": again,
        "choices": [list(choice) for choice in choices],
        "step": str(getattr(step, "keywords", "")),
    }


def of_intensity() -> dict[str, Any]:
    one, other = records()
    processed = process(replace(one, extra={}), None)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "i.nc"
        write_intensity(
            study(azimuth={"step": 90}, population={"period": [0.33]}, variants={}), [processed, other], path
        )
        return contents(path)


def of_runs() -> dict[str, Any]:
    """Studies of Python."""
    keys: dict[str, Any] = {"azimuth": {"step": 90}, "b_over_h": [0.15, 0.3], "ensemble": {"members": 4}}
    motions = [Motion.of(one) for one in records()]
    run: Callable[..., Any] = partial(run_study, **keys)
    rest: dict[str, Any] = {key: value for key, value in keys.items() if key != "ensemble"}
    return {
        "records": run_study(records(), **keys),
        "motions": run_study(motions, **rest, ensemble={"members": 0})["record_id"].to_numpy().tolist(),
        "refused": refusals(
            lambda: run([]),
            lambda: run(motions[0]),
            lambda: run([3]),
            lambda: run(motions, variants={"a": {"vertical": False}}),
            lambda: run(motions, processing=[]),
            lambda: run(["none"]),
        ),
    }


def of_steps() -> dict[str, Any]:
    """What is planned before a run starts, and refused."""
    given = [
        study(**more)
        for more in (
            {"contact": {"stiffness": "1e14 N/m"}},
            {"simulation": {"time_step": "1 s", "scheme": "cundall"}},
            {},
        )
    ]
    given.append(check_study(SMALL | {"scene": ICY}, "x") if (ROOT / "config").is_dir() else given[0])
    found = refusals(*(lambda one=one: preflight._check_cases(one, 0.01) for one in given))
    return found | {
        "joined": [preflight._joined([f"fault {k}" for k in range(n)]) for n in (1, 6, 7, 9)],
        "error": str(ConfigError("x")),
    }


SECTIONS = (
    sections.Records,
    sections.ContactSettings,
    sections.Simulation,
    sections.Variant,
    sections.Ensemble,
    sections.Verification,
    sections.BodySettings,
    sections.Orientations,
    evaluation.Figures,
    evaluation.Crate,
    evaluation.Published,
    evaluation.Primary,
    evaluation.Survey,
    evaluation.Spread,
    evaluation.Population,
    values.Range,
    values.AzimuthRange,
)

ANSWERS: Answers = {
    "interface": partial(interface_of, "study"),
    "keys": partial(keys_of, *SECTIONS),
    "members": of_members,
    "groups": of_groups,
    "sizes": of_sizes,
    "weak records": of_weak,
    "values": of_values,
    "messages": messages,
    "variants": of_variants,
    "answers": of_answers,
    "steps": of_steps,
    "runs": of_runs,
    "intensity": of_intensity,
    **{f"cubes: {name}": partial(of_cubes, name) for name in STUDIES},
}
