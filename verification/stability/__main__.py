"""`python -m verification.stability blocks|scenes --output MAP.nc`: run extreme cases and check how each ends."""

import sys
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from verification.stability import blocks as block_map
from verification.stability import scenes as scene_map
from verification.stability.cases import adversarial_cases, space_filling
from verification.stability.scene_cases import TOGETHER, scene_settings
from verification.tables import write_table

say = partial(print, file=sys.stderr, flush=True)

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True, help="The map of stability.")

Map = Annotated[Path, typer.Option(help="map to make (NetCDF, CSV beside it)")]
Seed = Annotated[int, typer.Option(min=0, help="seed of the sample")]
Threads = Annotated[int, typer.Option(min=1, help="number of threads")]


@app.command()
def blocks(
    output: Map,
    count: Annotated[int, typer.Option(min=2, help="cases of the space-filling sample")] = 20_480,
    adversarial: Annotated[int, typer.Option(min=1, help="cases of each adversarial motion")] = 64,
    seed: Seed = 1,
    threads: Threads = 1,
) -> None:
    """Run stiff and extreme blocks."""
    cases = [*space_filling(count, seed), *adversarial_cases(adversarial, seed)]
    found = block_map.run_map(cases, threads=threads, progress=lambda done, total: say(f"stability: {done} of {total}"))
    about = {"space_filling": count, "adversarial": adversarial, "seed": seed, "budget": block_map.BUDGET}
    rows = block_map.table_of(cases, found)
    write_table(rows, output, meanings=block_map.MEANINGS, attributes=about, dimension="case")


@app.command()
def scenes(
    output: Map,
    settings: Annotated[int, typer.Option(min=2, help="settings of each scene, of eight cases each")] = 160,
    adversarial: Annotated[int, typer.Option(min=1, help="settings of each scene under each adversarial motion")] = 2,
    seed: Seed = 1,
    threads: Threads = 1,
) -> None:
    """Run the shipped scenes under the map's extremes."""
    rows = scene_map.run_scene_map(
        scene_settings(settings, adversarial, seed),
        threads=threads,
        progress=lambda done, total: say(f"scenes: {done * TOGETHER} of {total * TOGETHER}"),
    )
    about = {"settings": settings, "adversarial": adversarial, "together": TOGETHER, "seed": seed}
    about |= {"budget": scene_map.BUDGET, "adversarial_budget": scene_map.ADVERSARIAL_BUDGET}
    write_table(rows, output, meanings=scene_map.MEANINGS, attributes=about, dimension="case")


if __name__ == "__main__":
    app()
