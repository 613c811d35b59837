"""The report as PDF, by typst; the same bytes each time it is made."""

import json
import shutil
import tempfile
from importlib import resources
from pathlib import Path
from typing import Any

from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.report import survey_content, words
from overturning.report.sentences import percent


def paper_data(data: dict[str, Any]) -> dict[str, Any]:
    """The content of the report as rows of text for the tables on paper.

    Parameters
    ----------
    data : dict
        From `report.content.content`.

    Returns
    -------
    dict
        Texts and lists of texts only.
    """
    summaries, names = data["summaries"], [row["name"] for row in data["summaries"]]
    keys = (
        "name",
        "earthquakes",
        "n",
        "axis",
        "half_width",
        "alignment",
        "alignment_interval",
        "closer",
        "rayleigh",
        "v",
    )
    fit = data["fit"]
    return {
        "title": data["title"],
        "question": data["question"],
        "answer": data["answer"],
        "counted": data["counted"],
        "has_axes": data["has_axes"],
        "falls": data["fallen"] > 0,
        "axes_caption": words.AXES_CAPTION,
        "summary_heads": ["records", "earth-quakes", "with falls", "mean axis from normal", "interval", "align-ment",
                          "interval", "closer to normal", "Rayleigh p", "V test p"],
        "summary_rows": [[row[key] for key in keys] for row in summaries],
        "summary_note": words.SUMMARY_NOTE,
        "case_note": data["case_note"],
        "findings_summary": data["findings_summary"] if data["findings"] else "",
        "peak_heads": ["component", "quantity", "published", "found", "difference", "expected within", ""],
        "peak_rows": [
            [p.component, p.quantity, f"{p.published:.1f}", f"{p.found:.1f}", f"{100 * p.difference:+.1f} %",
             f"{100 * p.tolerance:.0f} %", "agrees" if p.within else "differs"]
            for p in data["peaks"]
        ],
        "finding_heads": ["contact", "H, m", "µ", *(o[0] for o in (data["findings"][0].outcomes if data["findings"] else ())),
                          "finding"],
        "finding_rows": [
            [f.variant, f"{f.height:g}", f"{f.friction:g}",
             *("not found" if o[2] is None else ("overturns" if o[2] else "stands") for o in f.outcomes),
             "holds" if f.holds else "does not hold"]
            for f in data["findings"]
        ],
        "scene": _scene(data["scene"]),
        "surveys": data["surveys"],
        "survey_octant_heads": list(survey_content.OCTANT_HEADS),
        "survey_test_heads": list(survey_content.TEST_HEADS),
        "survey_caption": survey_content.CAPTION,
        "survey_test_note": survey_content.TEST_NOTE,
        "survey_confusion_note": survey_content.CONFUSION_NOTE,
        "telling": [{key: case[key] for key in ("title", "block", "outcomes", "rule")} for case in data["telling"]],
        "rose_caption": words.ROSE_CAPTION,
        "shape_heads": ["B/H", "µ", *(text for name in names for text in (f"earthquakes, {name}", f"alignment, {name}"))],
        "shape_rows": [
            [f"{row['b_over_h']:g}", f"{row['friction']:g}", *(str(cell) for pair in row["groups"] for cell in pair)]
            for row in data["by_shape"]
        ],
        "fit": {"sentence": fit["sentence"], "note": fit["note"][:1].upper() + fit["note"][1:]},
        "fit_rows": []
        if fit["note"].startswith("no fit")
        else [[row["name"], row["coefficient"], row["interval"], row["range"]] for row in fit["rows"]],
        "fit_note": data["fit_note"],
        "ensemble_text": data["ensemble_text"],
        "record_heads": ["record", "station, earthquake", "pulse", "fault normal", "PGA, Gal", "along", "PGV, cm/s", "along",
                         "PGD, cm", "over-turned"],
        "record_rows": [
            [row["id"], _heading(row), row["pulse"], _degrees(row["fault_normal"]), f"{row['pga']:.0f}",
             _degrees(row["pga_azimuth"]), f"{row['pgv']:.1f}", _degrees(row["pgv_azimuth"]), f"{row['pgd']:.1f}",
             percent(row["overturned"])]
            for row in data["records"]
        ],
        "direction_heads": ["record", "mean fall direction", "resultant", "mean fall axis", "resultant", "easiest axis",
                            "from the fault normal", "easier by"],
        "direction_rows": [
            [row[key] for key in ("id", "direction", "direction_resultant", "axis", "axis_resultant", "easiest",
                                  "easiest_from_normal", "ratio")]
            for row in data["records"]
        ],
        "direction_note": words.DIRECTION_NOTE,
        "record_note": words.RECORD_NOTE,
        "maps": data["maps"],
        "map_caption": words.MAP_CAPTION,
        "records": [{"id": row["id"], "heading": _heading(row)} for row in data["records"]],
        "method": words.METHOD,
        "limits": data["limits"],
        **_own_error(data["own_error"]),
        "verification": [list(pair) for pair in data["verification"]],
        "citations": data["citations"],
        "sources": [
            [row["id"], ", ".join(text for text in (row["source"], row["licence"]) if text), _broken(row["sha256"])]
            for row in data["records"]
        ],
        "study_text": data["study_text"],
        "versions": ", ".join(f"{name} {version}" for name, version in data["versions"].items()),
        "content_sha256": data["content_sha256"],
    }  # fmt: skip


def _own_error(found: dict[str, Any] | None) -> dict[str, Any]:
    """How many flags and sides change when cells are run again finer and stiffer; empty where the study leaves it out."""
    if found is None:
        return {"own_error_text": "", "own_error_rows": []}
    rows = []
    for repetition in found["repetitions"]:
        if repetition.refused:
            rows.append([repetition.name, f"not possible: {repetition.refused}", "", "", "", ""])
        for what, changed, compared, share, low, high in repetition.rows:
            known = [f"{100 * share:.2f} %", f"{100 * low:.2f} to {100 * high:.2f} %"] if compared else ["–", "–"]
            rows.append([repetition.name, what, str(changed), str(compared), *known])
    warning = (
        f"Warning: with {' and with '.join(found['warns'])} more than {100 * found['warn_above']:.0f} % of the flags change. "
        if found["warns"]
        else ""
    )
    return {"own_error_text": warning + found["text"], "own_error_rows": rows}


def _scene(found: dict[str, Any] | None) -> dict[str, Any] | None:
    """Drawing, comparisons and falls by element of a scene; none for a single block."""
    if found is None:
        return None
    rows = [
        [label, row.name, str(row.cases), str(row.falls), percent(row.share), str(row.first),
         "–" if row.median_time != row.median_time else f"{row.median_time:.2f}"]
        for label, row in found["elements"]
    ]  # fmt: skip
    return {
        "drawing": found["drawing"],
        "roses": found["roses"],
        "drawing_caption": words.SCENE_CAPTION,
        "comparisons": found["comparisons"],
        "heads": list(words.SCENE_HEADS),
        "rows": rows,
        "note": words.SCENE_NOTE,
        "roses_caption": words.SCENE_ROSES_CAPTION,
    }


def _heading(row: dict[str, Any]) -> str:
    return ", ".join(text for text in (row["station"], row["event"]) if text) or str(row["id"])


def _degrees(angle: float) -> str:
    return "–" if angle != angle else f"{angle:.0f}°"


def _broken(digest: str) -> str:
    """A hash in four pieces, so that a narrow column can break it."""
    quarter = max(1, len(digest) // 4)
    return " ".join(digest[i : i + quarter] for i in range(0, len(digest), quarter))


def write_paper(data: dict[str, Any], figures: Path, path: Path) -> None:
    """Write the PDF.

    Parameters
    ----------
    data : dict
        From `report.content.content`.
    figures : Path
        Folder of the study's figures.
    path : Path
        The file to make.

    Raises
    ------
    ResultError
        If a figure is missing.
    """
    import typst

    template = resources.files("overturning").joinpath("report/templates/report.typ").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "report.typ").write_text(template, encoding="utf-8")
        text = json.dumps(paper_data(data), ensure_ascii=False)
        (folder / "data.json").write_text(text, encoding="utf-8")
        shutil.copytree(figures, folder / "figures")
        try:
            # Only the fonts that come with typst, and no clock: the same pages on every machine.
            made = typst.compile(
                folder / "report.typ", root=folder, format="pdf", ignore_system_fonts=True, font_paths=[], timestamp=0
            )
        except typst.TypstError as error:
            raise ResultError(
                f"{path}: the PDF cannot be made ({str(error).splitlines()[0]}); draw the figures again"
            ) from None
    with atomic_write(path) as part:
        part.write_bytes(made)
