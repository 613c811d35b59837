"""What the statistics find of made-up cubes: in planes, of a stack, and in space, with gaps and with an ensemble."""

from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import xarray as xr

from overturning.statistics import bootstrap, circular, criteria, fragility
from overturning.statistics.boundary import boundary, easiest_azimuth, last_crossing
from overturning.statistics.by_record import few_records, record_groups
from overturning.statistics.earthquakes import (
    axes_by_earthquake,
    axes_by_group,
    compare_alignment,
    followed,
    radial_azimuth,
    summarise_axes,
    sums_by_record,
)
from overturning.statistics.elements import compare_stones, contrast, falls_by_element
from overturning.statistics.falls import (
    fall_alignment,
    fall_means,
    fall_shares,
    fall_vectors,
    falls_towards,
    informative_blocks,
    whole_circle,
)
from overturning.statistics.fragility_files import measure_file, write_fragility_csv, write_openquake
from overturning.statistics.illustrative import illustrative_cases
from overturning.statistics.logistic import describe, logistic_fit, overturning_fit, overturning_rows
from overturning.statistics.roses import study_roses
from overturning.statistics.space import plane_agreement, plane_counts, turns, twist
from overturning.statistics.spread import divided, of_first_batch, to_both_sides
from overturning.study.sections import Ensemble
from tests.kept import Answers, interface_of

EVENTS = ("A", "A", "B", "C", "D", "E", "F", "G", "H", "I", "J", "J")
PLANES = ("record", "azimuth", "height", "b_over_h", "friction")
SPACE = ("record", "orientation", "height", "b_over_h", "aspect", "friction")
DICE = np.random.default_rng


def of_records(count: int) -> dict[str, Any]:
    """Coordinates of records: of the last ones something is not known."""
    dice, last = DICE(7), np.arange(count) == count - 1
    numbers = {
        "fault_normal": np.where(last, np.nan, dice.integers(0, 36, count) * 5.0),
        "pulse": (np.arange(count) % 3 > 0).astype(np.int8),
        "vs30": np.where(last, np.nan, dice.integers(3, 16, count) * 50.0),
        "epicentre_latitude": dice.integers(-400, 400, count) / 8.0,
        "epicentre_longitude": dice.integers(-1400, 1400, count) / 8.0,
    }
    numbers["station_latitude"] = numbers["epicentre_latitude"] + np.where(last, 0.001, dice.normal(0, 1, count))
    numbers["station_longitude"] = numbers["epicentre_longitude"] + np.where(last, 0.001, dice.normal(0, 1, count))
    words = {"event": list(EVENTS[:count]), "wall": [["", "hanging", "foot"][i % 3] for i in range(count)]}
    return {name: ("record", values) for name, values in (numbers | words).items()}


@cache
def planes(*, ensemble: bool = False, azimuths: int = 24, count: int = 12, period: float = 180.0) -> xr.Dataset:
    """Stones that fall the likelier the slenderer and the nearer to an axis of their record, in a few cells unknown."""
    dice = DICE(azimuths + 7 * ensemble)
    azimuth = np.arange(azimuths) * 15.0
    azimuth = np.sort(np.append(azimuth, 37.0)) if azimuths % 2 else azimuth
    rows = {"azimuth": azimuth, "height": [0.6, 1.2], "b_over_h": [0.1, 0.2, 0.3, 0.45], "friction": [0.4, 1.0]}
    of, broad = of_records(count), np.array(rows["b_over_h"])[:, None]
    along = np.cos(np.radians(azimuth - 5.0 * np.arange(count)[:, None]))[..., None, None, None]
    chance = np.clip(1.3 * np.abs(along) + 0.3 - 2.2 * broad, 0.0, 1.0)
    shape = (count, azimuth.size, 2, 4, 2)
    fell = (dice.random(shape) < chance) * np.where(along * (1 + dice.normal(0, 0.3, shape)) > 0, 1, -1)
    flags = np.where(dice.random(shape) < 0.04, np.nan, fell).astype(np.float32)
    numbers = {
        "overturned": flags,
        "overturning_time": np.where(np.abs(flags) == 1, dice.integers(10, 90, shape) / 8, np.nan),
        "peak_rotation": np.where(flags == 0, dice.integers(0, 60, shape) / 64, 1.5),
        "status": dice.integers(0, 2, shape),
    }
    if ensemble:
        run = dice.random(shape) < 0.7
        towards = np.where(run, dice.integers(0, 9, shape) * chance / 12, np.nan)
        numbers |= {"probability_towards": towards, "probability_away": 0.5 * towards}
        spread = np.where(run, dice.integers(-2, 3, shape) / 12, np.nan)
        numbers |= {"scramble_difference_towards": spread, "scramble_difference_away": -0.25 * spread}
        numbers["members"] = np.where(run, dice.integers(1, 4, shape) * 8, 0)
    made = xr.Dataset({name: (PLANES, values) for name, values in numbers.items()}, {**rows, **of})
    made["azimuth"].attrs["period"] = period
    return made


@cache
def stack() -> xr.Dataset:
    parts = [planes(azimuths=azimuths, count=4) for azimuths in (24, 24, 24)]
    moved = [part.roll(azimuth=place, roll_coords=False) for place, part in enumerate(parts)]
    return xr.concat(moved, "element", coords="minimal", compat="override").assign_coords(
        element=["base", "shaft", "cap"]
    )


@cache
def space() -> xr.Dataset:
    dice, count = DICE(23), 10
    rows = {"orientation": np.arange(0, 180, 22.5), "height": [0.6], "b_over_h": [0.2, 0.3, 0.4], "aspect": [1.0, 1.5]}
    rows["friction"] = [0.5, 1.0]
    shape = (count, 8, 1, 3, 2, 2)
    of = of_records(count)
    fell = dice.random(shape) < np.array([0.8, 0.5, 0.2])[:, None, None]
    flags = np.where(dice.random(shape) < 0.04, np.nan, fell)
    beside = np.where(dice.random(shape) < 0.2, 1 - flags, flags)
    way = (np.arange(count).reshape(-1, 1, 1, 1, 1, 1) * 20.0 + dice.normal(0, 25, shape)) % 360.0
    other = (way + dice.choice([0.0, 30.0, 60.0, 180.0], shape)) % 360.0
    numbers = {
        "overturned": flags,
        "fall_azimuth": np.where(flags == 1, way, np.nan),
        "status": dice.integers(0, 2, shape),
        "plane_overturned": np.where(dice.random(shape) < 0.03, np.nan, beside),
        "plane_fall_azimuth": np.where(beside == 1, other, np.nan),
        "peak_tilt": dice.integers(0, 60, shape) / 2.0,
        "overturning_time": dice.integers(1, 80, shape) / 8.0,
        "residual_twist": np.where(flags == 0, dice.integers(-40, 41, shape) / 4.0, np.nan),
    }
    return xr.Dataset({name: (SPACE, values.astype(np.float32)) for name, values in numbers.items()}, {**rows, **of})


@cache
def intensity() -> xr.Dataset:
    dice, azimuth = DICE(3), np.arange(0, 360, 15.0)
    pga = dice.integers(1, 80, (12, azimuth.size)) / 8.0
    pga[3, 5] = 0.0
    whole = {name: dice.integers(0, 72, 12) * 5.0 for name in ("pgv_azimuth", "pga_azimuth", "pulse_axis")}
    whole["pulse_axis"][2] = np.nan
    along = {"pga": pga, "pgv": pga * dice.integers(4, 20, pga.shape) / 100.0}
    found = {name: (("record", "azimuth"), values) for name, values in along.items()}
    return xr.Dataset(found | {name: ("record", values) for name, values in whole.items()}, {"azimuth": azimuth})


def of_angles() -> dict[str, Any]:
    dice = DICE(1)
    angles, weight = dice.integers(0, 1440, 40) / 4.0, dice.integers(0, 5, 40)
    counts, chance = dice.integers(0, 9, 8), np.array([1, 2, 3, 4, 4, 3, 2, 1]) / 20.0
    return {
        "sector": circular.sector([-7.6, -7.5, -1e-17, 7.4, 7.5, 352.5, 359.0, 720.0], 24),
        "shares": circular.sector_shares(angles),
        "weighed": circular.sector_shares(angles, weight.astype(float)),
        "none": circular.sector_shares([]),
        "direction": circular.resultant(angles),
        "axis": circular.resultant(angles, weight, axial=True),
        "cancels": circular.resultant([0.0, 180.0]),
        "without weight": circular.resultant([1.0], [0.0]),
        "wraps": circular.wrap_axis([-270, -90, -89, 0, 90, 91, 270]),
        "Watson": [circular.watson_u2_test(angles[:n] / 360.0) for n in (0, 1, 2, 5, 40)],
        "grouped": [of(counts, chance) for of in (circular.grouped_watson_test, circular.chi_square_test)],
        "none grouped": circular.grouped_watson_test(0 * counts, chance),
        "rounded": [one.tolist() for one in (circular.wrap_axis(angles - 180.0), circular.sector(angles, 7))],
    }


def of_means() -> dict[str, Any]:
    dice = DICE(2)
    values = np.where(dice.random(12) < 0.1, np.nan, dice.integers(-40, 40, 12) / 8.0)
    values[-1] = np.nan
    few = {str(n): bootstrap.mean_over_earthquakes(np.arange(float(n)), list("abcdefghi"[:n])) for n in (0, 1, 7, 8, 9)}
    half = np.array([np.nan] * 5 + [1.0, 2.0, 4.0])

    def of_half(drawn: np.ndarray) -> np.ndarray:
        known = (drawn > 0).sum(axis=1)
        return np.where(known > 2, np.nansum(drawn, axis=1) / np.maximum(known, 1), np.nan)

    return few | {
        "means": bootstrap.event_means(np.stack([values, values[::-1]], axis=1), EVENTS),
        "names": bootstrap.event_names(EVENTS),
        "over earthquakes": bootstrap.mean_over_earthquakes(values, EVENTS, draws=500),
        "bootstrap": bootstrap.bootstrap(bootstrap.mean_of_sample, np.arange(20.0) ** 2, level=0.8, draws=300, seed=5),
        "by default": bootstrap.bootstrap(bootstrap.mean_of_sample, np.arange(8.0)),
        "half tells": bootstrap.resampled(of_half, half, 400),
    }


def of_boundaries(cube: xr.Dataset) -> dict[str, Any]:
    found = boundary(cube)
    lines = {str(line): last_crossing(line, [0.1, 0.2, 0.3, 0.4]) for line in LINES}
    return {"boundary": found, "easiest": easiest_azimuth(found, cube["b_over_h"]), **lines}


LINES = (
    [1, 1, 0, 0],
    [1, 0.5, 0.25, 0],
    [0, 1, 0, 1],
    [1, 0, 1, np.nan],
    [0.5, 0, 0, 0],
    [1] * 4,
    [0] * 4,
    [np.nan] * 4,
)


def of_falls(cube: xr.Dataset) -> dict[str, Any]:
    over = tuple(name for name in ("height", "friction") if name in cube.dims)
    found: dict[str, Any] = {
        "informative": informative_blocks(cube),
        "shares": fall_shares(cube),
        "over": fall_shares(cube, over=over),
        "means": fall_means(cube),
        "informative means": fall_means(cube, over=over, informative=True),
        "sums": sums_by_record(cube),
        "kept": sums_by_record(cube, "b_over_h"),
        "vectors": fall_vectors(cube, informative=True),
        "groups": record_groups(cube),
        "by wall": record_groups(cube, "wall"),
        "by ground": record_groups(cube, "vs30", [300, 500]),
        "radial": radial_azimuth(cube),
        "roses": study_roses(cube),
        "chunks": [places for places, _ in few_records(cube, ())],
    }
    for axial in (True, False):
        found[f"alignment {axial}"] = fall_alignment(found["sums"], cube["fault_normal"], axial=axial)
    if "azimuth" in cube.dims:
        found |= {
            "towards": falls_towards(cube),
            "likely": falls_towards(cube, ensemble=True),
            "whole": whole_circle(cube),
        }
    return found


def of_axes(cube: xr.Dataset) -> dict[str, Any]:
    axes, groups = axes_by_earthquake(cube), axes_by_group(cube)
    found = {"axes": axes, "kept": axes_by_earthquake(cube, "b_over_h"), "by pulse": groups}
    found |= {"summary": summarise_axes(axes, draws=500), "compared": compare_alignment(*groups.values())}
    found["few"] = summarise_axes(axes.isel(event=slice(4)))
    known = intensity().isel(record=slice(cube.sizes["record"]))
    return found | {"followed": followed(cube, known), "parts": followed(cube, known, [slice(0, 2), slice(2, 4)])}


def of_fits() -> dict[str, Any]:
    cube, dice = planes(), DICE(9)
    x = np.column_stack([dice.integers(-16, 17, 90) / 8.0, dice.integers(0, 9, 90) / 2.0, np.ones(90)])
    y, weight = (dice.random(90) < 1 / (1 + np.exp(-x[:, 0] + 0.5 * x[:, 1]))).astype(float), dice.integers(1, 5, 90)
    group = dice.integers(0, 11, 90)
    fits = {
        "plain": logistic_fit(x, y, group, weight=weight, names=("a", "b", "c")),
        "shares": logistic_fit(x[:, :2], 0.25 + 0.5 * y, group),
        "few groups": logistic_fit(x[:, :2], y, group % 7),
        "just enough": logistic_fit(x[:, :2], y, group % 8),
        "separated": logistic_fit(x[:, :1], x[:, 0] > 0.1, group),
        "dependent": logistic_fit(x[:, [0, 0]], y, group),
        "all": logistic_fit(x, 0 * y + 1, group),
        "none": logistic_fit(x, 0 * y, group),
        "empty": logistic_fit(x[:0], y[:0], group[:0]),
        "of a cube": overturning_fit(cube, intensity()),
        "of an ensemble": overturning_fit(planes(ensemble=True), intensity()),
    }
    rows = overturning_rows(cube, intensity(), ensemble=False)
    return {**fits, "rows": list(rows), "table": describe(fits["plain"]), "chance": fits["plain"].probability(x)}


def of_criteria() -> dict[str, Any]:
    height, ratio, seconds = (one.ravel() for one in np.meshgrid([0.3, 0.6, 2.0], [0.05, 0.2, 0.5], [0.02, 0.08, 0.3]))
    limits = {one.name: one.acceleration(height, ratio, seconds) for one in criteria.CRITERIA}
    more = {
        "velocity": criteria.ishiyama_velocity(height, ratio),
        "p": criteria.frequency_parameter(height, ratio),
        "F_b": criteria.kaneko_hayashi_frequency(height, ratio),
        "West": criteria.CRITERIA[0].acceleration(1.0, 0.2, [0.1, 1]),
        "scores": criteria.criteria_scores(planes(), intensity()),
    }
    return limits | more


def of_fragility() -> dict[str, Any]:
    dice = DICE(4)
    x = np.tile(np.geomspace(0.125, 4.0, 12), 9)
    record, event = np.repeat(np.arange(9), 12), np.repeat(list("aabcdefgh"), 12)
    strength = np.array([0.5, 0.8, 1.0, 1.0, 1.2, 1.4, 0.9, 1.1, 0.7])[record]
    share = dice.binomial(20, 1 / (1 + (0.9 / (x * strength)) ** 3)) / 20.0
    one = fragility.fragility("a/b 0.5", ("PGA", "g"), x, share, event, record=record, stones=20)
    few = fragility.fragility("few", ("SA(0.5)", "g"), x[:36], share[:36], event[:36])
    weak = fragility.fragility("weak", ("PGA", "g"), x / 8.0, np.where(x < 1.0, share / 2, share), event)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "curves"
        write_fragility_csv([one, few], path)
        table = path.read_text(encoding="utf-8").splitlines()
        write_openquake([one, weak], path, "stones")
        nrml = path.read_text(encoding="utf-8").splitlines()
    return {
        "one": one,
        "few": few,
        "weak": weak,
        "spreads": one.spreads,
        "within_data": [c.within_data for c in (one, few, weak)],
        "identifier": one.identifier,
        "chance": one.probability([0.1, 0.9, 3.0]),
        "table": table,
        "NRML": nrml,
        "weighed": fragility.lognormal_fit(x, share, dice.integers(1, 4, x.size)),
        "stepped": fragility.lognormal_fit([1, 2, 3, 4], [0, 0.5, 0.5, 1]),
        "parted": fragility.lognormal_fit([1, 2, 3, 4], [0, 0, 1, 1]),
        "level": fragility.lognormal_fit([1, 2], [0.5, 0.5]),
        "hardly": fragility.lognormal_fit([1, 2, 3, 4], [0.4, 0.45, 0.4, 0.5]),
        "file": measure_file("SA(0.5)"),
    }


def of_stones() -> dict[str, Any]:
    one, other = planes(count=9), planes(azimuths=24, count=9).roll(azimuth=3, roll_coords=False)
    counts, both = compare_stones(one, other), compare_stones(space(), space().roll(orientation=1, roll_coords=False))
    return {
        "of a stack": falls_by_element(stack()),
        "of a block": falls_by_element(planes()),
        "counts": counts,
        "contrast": contrast(counts, one["event"].to_numpy()),
        "in space": both,
    }


def of_space() -> dict[str, Any]:
    counts, turned = plane_counts(space()), turns(space())
    return {
        "counts": counts,
        "agreement": plane_agreement(counts),
        "kept": plane_agreement(counts, "b_over_h"),
        "turns": {key: np.sort(values) for key, values in turned.items()},
        "twist": [twist(values.copy()) for values in turned.values()],
        "none": twist(np.zeros(0, np.float32)),
        "most": twist(np.arange(10, dtype=np.float32), 0.75),
    }


def of_spread() -> dict[str, Any]:
    dice = DICE(6)
    members = dice.choice([0, 8, 16, 24, 23, 7], 300)
    towards = np.where(members > 0, np.floor(dice.random(300) * (members + 1)) / np.maximum(members, 1), np.nan)
    away = np.where(members > 0, np.floor((1 - towards) * members * dice.random(300)) / np.maximum(members, 1), np.nan)
    kinds = {
        "by default": Ensemble(),
        "all runs": Ensemble(half_width=0.0),
        "many": Ensemble(members=64, half_width=0.1),
    }
    return {
        f"{name}, {of.__name__}": of_first_batch(of, towards, away, members, settings)
        for name, settings in kinds.items()
        for of in (divided, to_both_sides)
    }


CUBES = {
    "an ensemble": partial(planes, ensemble=True),
    "a part of the circle": partial(planes, azimuths=7, count=9),
    "no mirror image": partial(planes, period=360.0),
    "space": space,
}

ANSWERS: Answers = {
    "interface": partial(interface_of, "statistics"),
    "angles": of_angles,
    "means": of_means,
    "fits": of_fits,
    "criteria": of_criteria,
    "fragility": of_fragility,
    "stones": of_stones,
    "space": of_space,
    "spread": of_spread,
    **{f"falls: {name}": lambda make=make: of_falls(make()) for name, make in CUBES.items()},
    **{f"axes: {name}": lambda make=make: of_axes(make()) for name, make in CUBES.items()},
    **{f"boundary: {name}": lambda make=make: of_boundaries(make()) for name, make in CUBES.items() if name != "space"},
    **{f"cases: {name}": lambda make=make: {"cases": illustrative_cases(make())} for name, make in CUBES.items()},
}
