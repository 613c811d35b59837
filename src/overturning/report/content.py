"""What the report says, as plain data: numbers from the cube, sentences from the numbers."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.report.published import compare_findings, compare_peaks, summary
from overturning.statistics.falls import overturns
from overturning.statistics.fault import GroupComparison, compare_group, shares_by_direction
from overturning.study.cube import sources_of_records, study_of
from overturning.units import CM, GAL

if TYPE_CHECKING:
    import xarray as xr


def groups_of(shares: "xr.Dataset") -> list[GroupComparison]:
    """Pulse records against the control where a study has both, otherwise all records."""
    pulse = shares["pulse"].to_numpy().astype(np.float64)
    groups = {"with a velocity pulse": pulse == 1, "without (control)": pulse == 0}
    if not all(members.any() for members in groups.values()):
        groups = {"all records": np.ones(pulse.size, dtype=bool)}
    return [compare_group(shares.isel(record=np.flatnonzero(members)), name) for name, members in groups.items()]


def answer(groups: list[GroupComparison], fallen: float) -> str:
    """The answer in one or two sentences.

    Parameters
    ----------
    groups : list of GroupComparison
        Pulse records and control, or all records.
    fallen : float
        Share of all cases that overturn.

    Returns
    -------
    str
    """
    if not fallen > 0:
        return "No block overturned in any direction, so these records say nothing about the direction of falls."
    parts = []
    for group in groups:
        if not np.isfinite(group.normal):
            continue
        parts.append(
            f"records {group.name}: {group.normal:.0%} of the cases overturn in planes near the fault normal and "
            f"{group.parallel:.0%} in planes near the fault (means over {group.earthquakes} earthquakes); of the "
            f"{group.falling} earthquakes in which any of these fell, {group.more_normal} overturned more along the normal and "
            f"{group.more_parallel} more along the fault"
        )
    if not parts:
        return (
            f"{fallen:.0%} of the cases overturn; the fault's strike is not known, so nothing is said about its normal."
        )
    sentence = ". ".join(part[0].upper() + part[1:] for part in parts)
    return f"{sentence}."


def records_table(cube: "xr.Dataset", intensity: "xr.Dataset") -> list[dict[str, Any]]:
    """One row per record: names, largest intensities with their azimuths, share of cases that overturn."""
    shares = overturns(cube).mean(["azimuth", "height", "b_over_h", "friction"]).compute().to_numpy()
    azimuth = intensity["azimuth"].to_numpy()
    names = cube[["station", "event", "pulse", "fault_normal"]].load()
    rows = []
    for index, source in enumerate(sources_of_records(cube)):
        measures = intensity.isel(record=index)
        row = {
            "id": source["id"],
            "station": str(names["station"][index].item()),
            "event": str(names["event"][index].item()),
            "pulse": {1.0: "yes", 0.0: "no"}.get(float(names["pulse"][index]), "–"),
            "fault_normal": float(names["fault_normal"][index]),
            "overturned": float(shares[index]),
            **{key: source[key] for key in ("source", "sha256", "licence")},
        }
        for name, unit in (("pga", GAL), ("pgv", CM), ("pgd", CM)):
            values = measures[name].to_numpy()
            row[name] = float(values.max() / unit)
            row[f"{name}_azimuth"] = float(azimuth[int(values.argmax())] % 180)
        rows.append(row)
    return rows


def missing_outcomes(cube: "xr.Dataset") -> dict[str, int]:
    """Number of cells by status, for those whose flag was not found."""
    status = cube["status"]
    counts = {}
    for code, name in zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True):
        number = int(((status == code) & cube["overturned"].isnull()).sum().compute())
        if number:
            counts[name] = number
    return counts


def content(results: Path) -> dict[str, Any]:
    """Everything the template shows.

    Parameters
    ----------
    results : Path
        Folder of a study's results.

    Returns
    -------
    dict
        Plain data; no clock, no path, no host.
    """
    import xarray as xr

    from overturning.study.cube import open_cube

    with (
        open_cube(results / "cube.nc", chunks={"record": 1}) as cube,
        xr.open_dataset(results / "intensity.nc") as intensity,
    ):
        study = study_of(cube)
        shares = shares_by_direction(cube)
        groups = groups_of(shares)
        fallen = float(overturns(cube).mean().compute())
        records = records_table(cube, intensity)
        findings = compare_findings(study, results)
        return {
            "peaks": compare_peaks(study, intensity),
            "findings": findings,
            "findings_summary": summary(findings),
            "title": study.title or study.name,
            "question": study.question,
            "answer": answer(groups, fallen),
            "groups": groups,
            "fallen": fallen,
            "cases": int(cube["overturned"].size),
            "computed": int((cube["mirrored"] == 0).sum().compute()),
            "missing": missing_outcomes(cube),
            "records": records,
            "earthquakes": len({row["event"] for row in records}),
            "with_vertical": int((cube["vertical"] == 1).sum().compute()),
            "study": study.model_dump(mode="json"),
            "study_text": json.dumps(study.model_dump(mode="json"), indent=1, ensure_ascii=False),
            "versions": json.loads(cube.attrs["versions"]),
            "content_sha256": cube.attrs["content_sha256"],
        }
