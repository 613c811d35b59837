"""Direction and its uncertainty as plain data for the report."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.report.sentences import answer, doubling_sentence, interval, percent, signed
from overturning.statistics.boundary import boundary, easiest_azimuth
from overturning.statistics.circular import wrap_axis
from overturning.statistics.direction import fall_axis, fall_direction
from overturning.statistics.earthquakes import (
    AxisSummary,
    axes_by_earthquake,
    compare_alignment,
    relative_axes,
    summarise_axes,
)
from overturning.statistics.groups import record_groups
from overturning.statistics.logistic import describe, overturning_fit
from overturning.statistics.planes import plane_index

if TYPE_CHECKING:
    import xarray as xr


MOST_RECORDS_IN_WORDS = 5
"""Records whose directions still stand in sentences; of more the table tells."""


def direction_content(cube: "xr.Dataset", intensity: "xr.Dataset", fallen: float, missing: int = 0) -> dict[str, Any]:
    """Answer, axes by earthquake, by shape, fit and ensemble; read one record at a time.

    Parameters
    ----------
    cube, intensity : Dataset
        The cube and the intensity measures.
    fallen : float
        Share of all cases that overturn.
    missing : int
        Cases without an outcome.

    Returns
    -------
    dict
        Plain data for the templates.
    """
    members = record_groups(cube)
    axes = {name: axes_by_earthquake(cube.isel(record=np.flatnonzero(chosen))) for name, chosen in members.items()}
    summaries = {name: summarise_axes(one) for name, one in axes.items()}
    difference = compare_alignment(*axes.values()) if len(axes) == 2 else None
    planes = int(plane_index(cube["azimuth"].values).size)
    sentences = answer(summaries, difference, fallen, planes=planes, missing=missing)
    unknown_faults = all(summary.n == 0 for summary in summaries.values())
    if unknown_faults and fallen > 0 and planes > 1 and cube.sizes["record"] <= MOST_RECORDS_IN_WORDS:
        sentences += _directions_in_words(cube)
    return {
        "answer": sentences,
        "has_axes": not unknown_faults and 0 < fallen < 1 and planes > 1,
        "summaries": [_summary_row(name, summary) for name, summary in summaries.items()],
        "by_shape": _by_shape(cube, members),
        "fit": _fit(cube, intensity),
        "ensemble": _ensemble(cube),
    }


def _directions_in_words(cube: "xr.Dataset") -> list[str]:
    """Mean fall direction and axis of each record; there is no fault to compare them with."""
    sentences = []
    names = [str(name) for name in cube["station"].to_numpy()]
    for name, row in zip(names, record_directions(cube), strict=True):
        if row["direction"] == "–" and row["axis"] == "–":
            continue
        sentences.append(
            f"{name}: mean fall direction {row['direction']} (resultant {row['direction_resultant']}), mean fall axis "
            f"{row['axis']} (resultant {row['axis_resultant']}), over all blocks, each plane once; a resultant near 0 means "
            "falls to nearly every side."
        )
    return sentences


def _angle(value: float, full: int = 0) -> str:
    """Whole degrees; with ``full`` brought into 0 to below it, so that 359.6° is 0° and not 360°."""
    if math.isnan(value):
        return "–"
    return f"{signed(round(value) % full if full else round(value))}°"


def _summary_row(name: str, s: AxisSummary) -> dict[str, str]:
    known = not math.isnan(s.alignment_interval[0])
    return {
        "name": name,
        "earthquakes": str(s.earthquakes),
        "n": str(s.n),
        "axis": _angle(s.mean_axis_deg),
        "half_width": "–" if math.isnan(s.mean_axis_half_width_deg) else f"±\u00a0{s.mean_axis_half_width_deg:.0f}°",
        "alignment": "–" if s.n == 0 else signed(s.alignment, 2),
        "alignment_interval": interval(*s.alignment_interval) if known else "–",
        "closer": f"{s.closer_to_normal} of {s.n}",
        "rayleigh": "–" if s.n < 2 else f"{s.rayleigh.p_value:.2g}",
        "v": "–" if s.n < 2 else f"{s.v.p_value:.2g}",
    }


def _by_shape(cube: "xr.Dataset", members: dict[str, Any]) -> list[dict[str, Any]]:
    """Alignment for each B/H and friction, heights taken together."""
    vectors = relative_axes(cube, over=("height",)).compute()
    coordinates = {name: cube[name].compute() for name in ("event", "pulse")}
    events = np.array([str(name) for name in coordinates["event"].values])
    rows = []
    for b_over_h in cube["b_over_h"].to_numpy():
        for friction in cube["friction"].to_numpy():
            one = vectors.sel(b_over_h=b_over_h, friction=friction)
            row: dict[str, Any] = {"b_over_h": float(b_over_h), "friction": float(friction), "groups": []}
            for chosen in members.values():
                cosines = []
                for event in dict.fromkeys(events[chosen]):
                    these = chosen & (events == event)
                    pair = [one[name].to_numpy()[these] for name in ("cosine", "sine")]
                    if np.isfinite(pair[0]).any():
                        c, s = (float(np.nanmean(values)) for values in pair)
                        if math.hypot(c, s) > 1e-9:
                            cosines.append(c / math.hypot(c, s))
                row["groups"].append((len(cosines), signed(float(np.mean(cosines)), 2) if cosines else "–"))
            rows.append(row)
    return rows


def _fit(cube: "xr.Dataset", intensity: "xr.Dataset") -> dict[str, Any]:
    fit = overturning_fit(cube, intensity)
    rows = []
    for entry in describe(fit):
        numbers = {name: float(entry[name]) for name in ("coefficient", "low", "high", "minimum", "maximum")}  # type: ignore[arg-type]
        rows.append(
            {
                "name": entry["name"],
                "coefficient": "–" if math.isnan(numbers["coefficient"]) else signed(numbers["coefficient"], 2),
                "interval": "–" if math.isnan(numbers["low"]) else interval(numbers["low"], numbers["high"]),
                "range": "–" if math.isnan(numbers["minimum"]) else interval(numbers["minimum"], numbers["maximum"]),
            }
        )
    return {
        "rows": rows,
        "note": fit.note,
        "cases": fit.rows,
        "earthquakes": fit.clusters,
        "sentence": doubling_sentence(fit),
    }


def _ensemble(cube: "xr.Dataset") -> dict[str, Any] | None:
    if "probability_towards" not in cube:
        return None
    half = cube.isel(azimuth=np.flatnonzero(cube["azimuth"].to_numpy() < 180))
    towards, away = half["probability_towards"], half["probability_away"]
    run = towards.notnull()
    falls = towards + away
    divided = (falls > 0) & (falls < 1)
    other_side = (np.minimum(towards, away) > 0) & (falls > 0.5)
    gap = abs(half["scramble_difference_towards"] + half["scramble_difference_away"])
    count = int(run.sum().compute())
    if count == 0:
        return {"run": "0", "members": "0"}
    return {
        "run": percent(count / int(run.size)),
        "members": f"{float(half['members'].max().compute()):.0f}",
        "divided": percent(float(divided.sum().compute()) / count, 1),
        "other_side": percent(float(other_side.sum().compute()) / count, 1),
        "scrambles": f"{float(gap.where(divided).mean().compute()):.2f}" if bool(divided.any()) else "–",
    }


def record_directions(cube: "xr.Dataset") -> list[dict[str, str]]:
    """Per record: mean fall direction and axis over all its cases, and the azimuth of easiest overturning.

    The last is for the lowest block at the highest friction.
    """
    over = ("height", "b_over_h", "friction")
    direction, axis = fall_direction(cube, over=over).compute(), fall_axis(cube, over=over).compute()
    one = cube.isel(height=[0], friction=[cube.sizes["friction"] - 1])
    easiest = easiest_azimuth(boundary(one), cube["b_over_h"]).isel(height=0, friction=0)
    normals = cube["fault_normal"].to_numpy()
    rows = []
    for index in range(cube.sizes["record"]):
        best, ratio = float(easiest["easiest_axis"][index]), float(easiest["ratio"][index])
        bound = "" if bool(easiest["bounded"][index]) else "≥ "
        apart = abs(float(wrap_axis(best - normals[index]))) if np.isfinite(normals[index]) else math.nan
        rows.append(
            {
                "direction": _angle(float(direction["mean_direction"][index]), 360),
                "direction_resultant": _number(float(direction["direction_resultant"][index])),
                "axis": _angle(float(axis["mean_axis"][index]), 180),
                "axis_resultant": _number(float(axis["axis_resultant"][index])),
                "easiest": _angle(best, 180),
                "easiest_from_normal": _angle(apart),
                "ratio": "–" if math.isnan(ratio) else f"{bound}{ratio:.2f}",
            }
        )
    return rows


def _number(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.2f}"
