"""`python -m verification.page`: draw the diagrams and put the measured figures into the docs."""

import json
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
import typer

from overturning.files import atomic_write
from verification import summary
from verification.stability import figures as map_figures
from verification.stability import page as map_page
from verification.stale import measuring
from verification.tables import RESULTS, ROOT, publish, read_table, write_csv, write_figures
from verification.work_precision import figures as error_figures
from verification.work_precision import page as error_page
from verification.work_precision.parts import PARTS


def main(
    results: Annotated[Path, typer.Option(help="folder of the tables")],
    output: Annotated[Path, typer.Option(help="orders of convergence to write (JSON)")],
    root: Annotated[Path, typer.Option(help="folder of README.md and docs/")] = ROOT,
) -> None:
    """Publish the tables of work-precision and of the map of stability."""
    rows = pd.concat([read_table(results / f"{part}.nc") for part in PARTS], ignore_index=True)
    blocks, scenes = read_table(results / "stability.nc"), read_table(results / "scenes.nc")
    images = root / "docs" / "images"
    error_figures.draw_against_finer_steps(rows, images / "work-precision-steps.svg")
    error_figures.draw_against_rigid_solutions(rows, images / "work-precision-rigid.svg")
    map_figures.draw_map(blocks, images / "stability-map.svg")
    map_figures.draw_shares(blocks, images / "stability-shares.svg")
    map_figures.draw_scenes(scenes, images / "stability-scenes.svg")
    orders = error_page.orders(rows)
    kept = root / RESULTS.relative_to(ROOT)
    write_csv(rows, kept / "work-precision.csv")
    write_figures([*error_page.figures(rows, orders), *map_page.figures(blocks, scenes)], kept / "exactness.csv")
    with atomic_write(output) as part:
        known = {name: value if np.isfinite(value) else None for name, value in orders.items()}
        part.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    with measuring("page", kept):
        publish(error_page.bodies(rows, orders) | map_page.bodies(blocks, scenes) | summary.bodies(kept), root)


if __name__ == "__main__":
    typer.run(main)
