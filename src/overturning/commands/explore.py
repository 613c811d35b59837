"""`overturning explore`: an interactive page of a cube."""

from pathlib import Path
from typing import Annotated

import typer


def write_interactive_cube_page(
    cube: Annotated[Path, typer.Argument(help="cube of a study (NetCDF)")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="page to write (default: next to the cube, explore.html for cube.nc)"),
    ] = None,
    record: Annotated[list[str] | None, typer.Option(help="id of a record to show; may be given several times")] = None,
    study: Annotated[
        str | None,
        typer.Option(
            help="study file or JSON with title, question and block shown first (default: study.yaml next to it)"
        ),
    ] = None,
    report: Annotated[
        str | None,
        typer.Option(help="address of the report to link to (default: report.html if it is next to the page)"),
    ] = None,
    language: Annotated[str | None, typer.Option(help="language: en or ja; not given: that of the study")] = None,
) -> None:
    """Write an interactive page of a results cube: fall maps, the outcome of each cell, and the command for its film.

    The address of the page holds the cell that is pinned: `explore.html#record=rinaldi&azimuth=30&b_over_h=0.3`.
    """
    from overturning.figures.explore import write_explorer
    from overturning.files import check_output_path
    from overturning.study.cube import find_study_with_title_and_figure_settings, index_of_record, open_cube
    from overturning.study.load import load_study_from_file_or_json
    from overturning.translation.texts import use_translation_language

    # The page of a variant is explore.NAME.html, so that it does not replace that of the study.
    path = output or cube.with_name(cube.name.replace("cube", "explore", 1)).with_suffix(".html")
    check_output_path(path, "--output", ".html")
    with open_cube(cube, element=None) as data:
        names = dict.fromkeys(record or data["record_id"].to_numpy().astype(str).tolist())
        chosen = data.isel(record=[index_of_record(data, name) for name in names])
        beside = path.with_name("report.html")
        link = report if report is not None else beside.name if beside.is_file() else ""
        settings = find_study_with_title_and_figure_settings(
            data, load_study_from_file_or_json(study) if study else None
        )
        with use_translation_language(language or (settings.language if settings else None)):
            write_explorer(chosen, path, settings, link)
    print(path)
