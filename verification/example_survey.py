"""`python -m verification.example_survey`: make the example survey of three invented cemeteries, and its page.

The stones are invented; their outcomes are simulated with the motion of Te Mara Farm, so the true axis of the motion is
known. The survey is in surveys/example-cemeteries.csv, the worked example in docs/how-to/survey.md.
"""

import contextlib
import io
import math
import tempfile
import textwrap
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

import overturning
from overturning.arrays import FloatArray
from overturning.cli import main as run_command
from overturning.files import write_text
from overturning.motion.motion import Motion
from overturning.records.catalogue import RecordTableRow
from overturning.records.processing import process_record
from overturning.records.read import read_record
from overturning.surveys.library import CandidateMotion
from overturning.surveys.notation import COMPASS_POINTS_16
from verification.tables import ROOT

EXAMPLE_SURVEY_FILE: Final = ROOT / "surveys" / "example-cemeteries.csv"
SURVEY_DOCS_PAGE_FILE: Final = ROOT / "docs" / "how-to" / "survey.md"
ROSE_DIAGRAM_FILE: Final = ROOT / "docs" / "images" / "example-cemeteries.svg"

RECORD_SOURCE: Final = "example:20161113_110259_WTMC_20.V2A"
DIRECTION_NOTATION_BY_SITE: Final = {"Hill": "degrees", "River": "winds", "Church": "bearings"}
"""Names of the cemeteries, each with the notation of its directions."""
STONE_COUNT_PER_SITE: Final = 20
MAGNETIC_DECLINATION_EAST_DEG: Final = 22.5
"""Magnetic declination, east positive, of the directions that were taken with a compass."""
FRICTION: Final = 0.7
FALL_DIRECTION_STANDARD_DEVIATION_DEG: Final = 10.0
"""Standard deviation of the fall directions about the normals of the faces."""

SURVEY_CSV_COLUMN_NAMES: Final = (
    "site", "stone", "kind", "outcome", "azimuth_deg", "declination", "face_azimuth_deg", "height_m", "b_over_h",
    "b_over_h_side", "note",
)  # fmt: skip
OUTCOME_BY_SITE_AND_NUMBER_IF_EXCLUDED: Final = {
    ("Hill", 4): "fixed", ("Hill", 15): "fixed", ("River", 7): "broken", ("River", 12): "unknown",
    ("Church", 9): "repaired",
}  # fmt: skip
"""Outcomes of the stones that do not count, by site and number."""
ONE_BASED_INDEX_OF_FALL_WITHOUT_DIRECTION: Final = 3
"""Number, among the stones of each site that fell, of the one whose direction is not noted."""


@dataclass(frozen=True)
class InventedStone:
    """Invented stone, with its outcome under the motion that the survey is simulated with.

    ``fall_azimuth_deg`` is the true azimuth of its fall; NaN if it stands.
    """

    face_azimuth_deg: float
    height: float
    b_over_h_along_face_normal: float
    b_over_h_across_face_normal: float
    fall_azimuth_deg: float


def true_motion_of_example_survey() -> CandidateMotion:
    """Return the motion of Te Mara Farm, processed as in a study, with its velocity axis."""
    record = process_record(read_record(RecordTableRow(id="wtmc", format="geonet", source=RECORD_SOURCE), Path()), None)
    return CandidateMotion.from_motion("Te Mara Farm", record.event, Motion.of(record))


def azimuths_of_first_falls_in_two_face_planes(
    motion: Motion,
    face_normal_azimuth_deg_by_stone: FloatArray,
    height_by_stone: FloatArray,
    b_over_h_along_and_across_face_normal: FloatArray,
) -> FloatArray:
    """Return the azimuth, degrees, towards which each stone falls first; NaN if it stands.

    A stone can fall along its face normal or across it; both planes are simulated, and the earlier fall counts. The
    columns of ``b_over_h_along_and_across_face_normal``, shape (stones, 2), are B/H along and across.
    """
    azimuth = np.column_stack([face_normal_azimuth_deg_by_stone, face_normal_azimuth_deg_by_stone + 90.0])
    cases = overturning.Cases(
        azimuth.ravel(), np.repeat(height_by_stone, 2), b_over_h_along_and_across_face_normal.ravel(), FRICTION
    )
    found = overturning.run_cases(motion, cases)
    side = found.overturned.reshape(b_over_h_along_and_across_face_normal.shape)
    time = np.where(side != 0, found.overturning_time.reshape(b_over_h_along_and_across_face_normal.shape), np.inf)
    first, row = time.argmin(axis=1), np.arange(len(side))
    fall = (azimuth + np.where(side > 0, 0.0, 180.0)) % 360.0
    return np.where(np.isfinite(time[row, first]), fall[row, first], np.nan)


def invent_and_simulate_stones_by_cemetery() -> dict[str, list[InventedStone]]:
    """Invent the stones of each cemetery, in rows of one orientation; return them with simulated falls."""
    generator = np.random.Generator(np.random.PCG64(47))
    drawn: list[tuple[float, ...]] = []
    for _ in DIRECTION_NOTATION_BY_SITE:
        row = generator.uniform(0.0, 360.0)
        for _ in range(STONE_COUNT_PER_SITE):
            face = round(row + generator.normal(0.0, 15.0)) % 360.0
            height, shape = (round(float(one), 2) for one in generator.uniform((0.5, 0.3), (1.1, 0.55)))
            side = round(shape * float(generator.uniform(1.0, 1.4)), 2)
            drawn.append((face, height, shape, side, generator.normal(0.0, FALL_DIRECTION_STANDARD_DEVIATION_DEG)))
    face, height, shape, side, spread = np.array(drawn).T
    seen = (
        azimuths_of_first_falls_in_two_face_planes(
            true_motion_of_example_survey().motion, face, height, np.column_stack([shape, side])
        )
        + spread
    ) % 360.0
    rows = zip(drawn, seen.tolist(), strict=True)
    stones = [InventedStone(one[0], one[1], one[2], one[3], fall) for one, fall in rows]
    return {
        site: stones[n * STONE_COUNT_PER_SITE :][:STONE_COUNT_PER_SITE]
        for n, site in enumerate(DIRECTION_NOTATION_BY_SITE)
    }


def true_azimuth_in_field_notation(azimuth_deg: float, direction_notation: str) -> str:
    """Return a true azimuth, degrees, as people note it: magnetic degrees, true compass point, or magnetic bearing."""
    if direction_notation == "winds":
        return COMPASS_POINTS_16[round(azimuth_deg / 22.5) % 16]
    magnetic = round(azimuth_deg - MAGNETIC_DECLINATION_EAST_DEG) % 360
    if direction_notation == "degrees":
        return str(magnetic)
    north = magnetic <= 90 or magnetic >= 270
    angle = min(magnetic, 360 - magnetic) if north else abs(180 - magnetic)
    return f"{'N' if north else 'S'} {angle}° {'E' if magnetic <= 180 else 'W'}"


def survey_csv_text() -> str:
    """Return the survey as text: semicolons, decimal commas, and another notation of directions at each site."""
    generator = np.random.Generator(np.random.PCG64(48))
    lines = [
        "# Invented: three cemeteries with 60 stones, made by verification/example_survey.py from the motion of Te",
        "# Mara Farm. It shows a file's form, and how the sites of one survey may differ in their notation.",
        ";".join(SURVEY_CSV_COLUMN_NAMES),
    ]
    for site, stones in invent_and_simulate_stones_by_cemetery().items():
        notation, falls = DIRECTION_NOTATION_BY_SITE[site], 0
        for number, stone in enumerate(stones, 1):
            outcome, azimuth = "stands", ""
            if math.isfinite(stone.fall_azimuth_deg):
                outcome, azimuth = "fell", true_azimuth_in_field_notation(stone.fall_azimuth_deg, notation)
            moved = generator.uniform()
            if outcome == "stands" and moved < 0.5:
                twist, shift = int(generator.choice([-1, 1])) * int(generator.integers(2, 15)), generator.integers(1, 5)
                outcome = f"twisted {twist}" if moved < 0.25 else f"shifted {shift} cm"
            falls += outcome == "fell"
            if outcome == "fell" and falls == ONE_BASED_INDEX_OF_FALL_WITHOUT_DIRECTION:
                outcome, azimuth = "fell, direction not known", ""
            if (site, number) in OUTCOME_BY_SITE_AND_NUMBER_IF_EXCLUDED:
                outcome, azimuth = OUTCOME_BY_SITE_AND_NUMBER_IF_EXCLUDED[site, number], ""
            face = "" if notation == "winds" else true_azimuth_in_field_notation(stone.face_azimuth_deg, notation)
            declination = "" if notation == "winds" else f"{MAGNETIC_DECLINATION_EAST_DEG}"
            sizes = (
                f"{one:.2f}".replace(".", ",")
                for one in (stone.height, stone.b_over_h_along_face_normal, stone.b_over_h_across_face_normal)
            )
            cells = (site, f"{site[0]}{number}", "headstone", outcome, azimuth, declination.replace(".", ","), face)
            lines.append(";".join((*cells, *sizes, "")))
    return "\n".join(lines) + "\n"


def run_overturning_command_and_wrap_output(*arguments: str) -> str:
    """Return what a command of `overturning` prints, with long lines wrapped."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.suppress(SystemExit):
        run_command(list(arguments))
    lines = text.getvalue().replace("\u00a0", " ").rstrip("\n").split("\n")
    wrapped = [part for line in lines for part in (textwrap.wrap(line, 110) if line[:1] != " " else [line]) or [""]]
    return "\n".join(line.rstrip() for line in wrapped)


def fenced_code_block(text_to_fence: str) -> str:
    """Return a text as a fenced code block of Markdown."""
    return f"```text\n{text_to_fence}\n```"


def simulate_and_write_example_cube(path: Path) -> None:
    """Run the small study with which the docs page compares the survey, and write its cube of outcomes."""
    cube = overturning.run_study(
        ["wtmc"],
        azimuth={"step": 10},
        height=[0.5, 0.8, 1.1],
        b_over_h=[0.3, 0.4, 0.5, 0.6, 0.7],
        friction=[FRICTION],
        ensemble={"members": 0},
        verification="none",
    )
    cube.to_netcdf(path)


def survey_command_output_by_marker() -> dict[str, str]:
    """Return what `overturning survey` prints, without and with a cube, by the marker of its place in the docs page."""
    with tempfile.TemporaryDirectory() as folder:
        cube = Path(folder) / "cube.nc"
        simulate_and_write_example_cube(cube)
        compared = run_overturning_command_and_wrap_output("survey", str(EXAMPLE_SURVEY_FILE), "--cube", str(cube))
    summary = run_overturning_command_and_wrap_output("survey", str(EXAMPLE_SURVEY_FILE))
    return {
        "example-survey": summary,
        "example-survey-compared": compared[compared.index("example-cemeteries.csv against") :],
    }


def inferred_motion_output_by_marker() -> dict[str, str]:
    """Return the motion that `overturning backwards` infers from the survey, by its marker in the docs page.

    The printed list of the likeliest motions is left out.
    """
    text = run_overturning_command_and_wrap_output("backwards", str(EXAMPLE_SURVEY_FILE))
    return {"example-survey-backwards": text[text.index("\n\nFrom ") : text.index("  motion ")].strip()}


def main() -> None:
    """Write the survey, the rose diagram of its falls, and the output of the commands in the docs page."""
    write_text(EXAMPLE_SURVEY_FILE, survey_csv_text())
    run_overturning_command_and_wrap_output("survey", str(EXAMPLE_SURVEY_FILE), "--rose", str(ROSE_DIAGRAM_FILE))
    page = SURVEY_DOCS_PAGE_FILE.read_text(encoding="utf-8")
    for mark, block in (survey_command_output_by_marker() | inferred_motion_output_by_marker()).items():
        begin, end = f"<!-- {mark}:begin -->", f"<!-- {mark}:end -->"
        page = f"{page.partition(begin)[0]}{begin}\n\n{fenced_code_block(block)}\n\n{end}{page.partition(end)[2]}"
    write_text(SURVEY_DOCS_PAGE_FILE, page)


if __name__ == "__main__":
    main()
