"""`python -m verification.page`: draw the diagrams and write the tables of docs/validation.md."""

import json
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
import typer

from overturning.files import atomic_write
from verification.stability import figures as map_figures
from verification.stability import page as map_page
from verification.tables import (
    RESULT_TABLE_FOLDER,
    ROOT,
    MeasuredNumber,
    measured_numbers_table,
    read_table,
    update_marked_tables_and_sentences_in_docs,
    write_csv,
    write_measured_numbers,
)
from verification.work_precision import figures as error_figures
from verification.work_precision import page as error_page
from verification.work_precision.parts import MEASUREMENT_FUNCTIONS_BY_PART


def main(
    results: Annotated[Path, typer.Option(help="folder of the tables")],
    output: Annotated[Path, typer.Option(help="file for the orders of convergence (JSON)")],
    root: Annotated[Path, typer.Option(help="folder of README.md and docs/")] = ROOT,
) -> None:
    """Publish errors against run time and stability maps in the docs; write the orders of convergence to a file."""
    kept = root / RESULT_TABLE_FOLDER.relative_to(ROOT)
    rows = pd.concat([read_table(results / f"{part}.nc") for part in MEASUREMENT_FUNCTIONS_BY_PART], ignore_index=True)
    write_csv(rows, kept / "work-precision.csv")
    orders = publish_errors_and_return_convergence_orders(rows, root)
    blocks, scenes, stacks = (read_table(results / f"{name}.nc") for name in ("stability", "scenes", "stacks"))
    publish_stability_maps(blocks, scenes, stacks, root)
    with atomic_write(output) as part:
        known = {name: value if np.isfinite(value) else None for name, value in orders.items()}
        part.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")


def publish_errors_and_return_convergence_orders(
    error_table: pd.DataFrame, readme_and_docs_folder: Path
) -> dict[str, float]:
    """Publish figures and tables of error against run time in the docs; return the orders of convergence."""
    images, orders = (
        readme_and_docs_folder / "docs" / "images",
        error_page.fit_convergence_orders_by_measure_and_scheme(error_table),
    )
    error_figures.draw_errors_against_finer_steps_or_stiffer_springs(error_table, images / "work-precision-steps.svg")
    error_figures.draw_errors_against_rigid_solutions(error_table, images / "work-precision-rigid.svg")
    _publish_numbers_and_tables(
        error_page.work_precision_numbers_for_summary(error_table, orders),
        error_page.markdown_by_marker(error_table, orders),
        readme_and_docs_folder,
    )
    return orders


def publish_stability_maps(
    block_map_rows: pd.DataFrame,
    scene_map_rows: pd.DataFrame,
    stack_map_rows: pd.DataFrame,
    readme_and_docs_folder: Path,
) -> None:
    """Draw and publish the maps of stability of single blocks, of scenes and of 3-D stacks."""
    images = readme_and_docs_folder / "docs" / "images"
    map_figures.draw_block_outcomes_over_dimensionless_groups(block_map_rows, images / "stability-map.svg")
    map_figures.draw_outcome_shares_by_dimensionless_group(block_map_rows, images / "stability-shares.svg")
    map_figures.draw_scene_outcomes_over_dimensionless_groups(scene_map_rows, images / "stability-scenes.svg")
    _publish_numbers_and_tables(
        map_page.stability_numbers_for_summary_table(block_map_rows, scene_map_rows, stack_map_rows),
        map_page.markdown_by_marker(block_map_rows, scene_map_rows, stack_map_rows), readme_and_docs_folder,
    )  # fmt: skip


def _publish_numbers_and_tables(
    measured_numbers: list[MeasuredNumber], markdown_by_marker: dict[str, str], readme_and_docs_folder: Path
) -> None:
    """Add measured numbers to `exactness.csv`; write the table of this file and the given tables into the docs."""
    kept = readme_and_docs_folder / RESULT_TABLE_FOLDER.relative_to(ROOT)
    known = write_measured_numbers(measured_numbers, kept / "exactness.csv", keep_other_stored_numbers=True)
    update_marked_tables_and_sentences_in_docs(
        markdown_by_marker | {"exactness": measured_numbers_table(known)}, readme_and_docs_folder
    )


if __name__ == "__main__":
    typer.run(main)
