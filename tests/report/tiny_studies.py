"""Whole results folders of tiny studies, made without the workflow."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from matplotlib.layout_engine import ConstrainedLayoutEngine

from overturning.figures.drawn_case import write_illustrative_case_list
from overturning.figures.illustrative import choose_simulate_and_draw_illustrative_cases
from overturning.figures.record import draw_record_figures
from overturning.figures.study import draw_study_figures
from overturning.figures.write import write_figure_and_delete_files_in_other_formats
from overturning.records.record import Record
from overturning.records.store import read_record_from_motion_file
from overturning.study.cube import COMPLETE_STUDY_FILE_NAME
from overturning.study.intensity import write_intensity_measures
from overturning.study.load import study_from_content, study_settings_with_file_names_for_absolute_paths
from tests.study.small_study import simulate_study_cube


def pulse_record(name: str, towards_deg: float, peak: float, **more: Any) -> Record:
    """Return a record of one sine cycle of 0.8 s along an azimuth, with weak noise across it."""
    time = np.arange(0, 5, 0.01)
    cycle = np.where((time > 1) & (time < 1.8), np.sin(2 * np.pi * (time - 1) / 0.8), 0.0)
    noise = 0.02 * np.random.default_rng(7).normal(size=time.size)
    angle = np.radians(towards_deg)
    north, east = cycle * np.cos(angle) - noise * np.sin(angle), cycle * np.sin(angle) + noise * np.cos(angle)
    given = {"station": name, "event": f"event of {name}", "source": "synthetic", "sha256": "0" * 64, "licence": "none"}
    return Record(name, peak * north, peak * east, None, 0.01, **(given | more))


def simulate_study_into_result_folder(folder: Path, records: list[Record], *, drawn: bool = True, **study: Any) -> Path:
    """Simulate a study of these records into a folder; draw films and figures unless ``drawn`` is false."""
    data = {
        "name": "tiny",
        "title": "Tiny",
        "question": "Which way?",
        "records": {"use": [record.record_id for record in records]},
        "azimuth": {"step": 30},
        "b_over_h": [0.2, 0.3, 0.4],
        "height": [0.6],
        "friction": [1.0],
        "ensemble": {"members": 4},
        "verification": "none",
    }
    if "body" in study:
        del data["azimuth"]
    settings = study_from_content(data | study, "test")
    simulate_study_cube(settings, records, folder)
    kept = [read_record_from_motion_file(folder / "motion" / f"{record.record_id}.nc") for record in records]
    write_intensity_measures(settings, kept, folder / "intensity.nc")
    (folder / COMPLETE_STUDY_FILE_NAME).write_text(
        yaml.safe_dump(study_settings_with_file_names_for_absolute_paths(settings)), encoding="utf-8"
    )
    cube, intensity, motions, figures = (folder / name for name in ("cube.nc", "intensity.nc", "motion", "figures"))
    if not drawn:
        write_illustrative_case_list([], figures / "illustrative")
        return folder
    with pytest.MonkeyPatch.context() as patch:  # the places of panels, a third of the work, are not looked at
        patch.setattr(ConstrainedLayoutEngine, "execute", lambda *_: None)
        choose_simulate_and_draw_illustrative_cases(cube, motions, figures / "illustrative")
        write = partial(write_figure_and_delete_files_in_other_formats, settings.figures)
        draw_record_figures(cube, intensity, figures, write)
        draw_study_figures(cube, intensity, figures, write)
    return folder
