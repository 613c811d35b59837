"""`overturning verify`: error against run time, the map of stability, and the page about both."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True, help="Verify the kernel itself.")

Map = Annotated[Path, typer.Option(help="map to make (NetCDF, CSV beside it)")]
Seed = Annotated[int, typer.Option(min=0, help="seed of the sample")]
Log = Annotated[Path | None, typer.Option(help="file for progress lines and errors")]
Threads = Annotated[int, typer.Option(min=1, help="number of threads")]


@app.callback()
def _root() -> None:
    pass


@app.command()
def stability(
    output: Map,
    count: Annotated[int, typer.Option(min=2, help="cases of the space-filling sample")] = 20_480,
    special: Annotated[int, typer.Option(min=1, help="cases of each motion made to do harm")] = 64,
    seed: Seed = 1,
    threads: Threads = 1,
    log: Log = None,
) -> None:
    """Run stiff and extreme cases and check how each ends."""
    from overturning.study.progress import logged_to
    from overturning.verification.stability import BUDGET, MEANINGS, columns_of, run_map
    from overturning.verification.stability_cases import space_filling, special_cases
    from overturning.verification.table import write_table

    with logged_to(log) as say:
        cases = [*space_filling(count, seed), *special_cases(special, seed)]
        found = run_map(cases, threads=threads, progress=lambda done, total: say(f"stability: {done} of {total}"))
        about = {"space_filling": count, "special": special, "seed": seed, "budget": BUDGET}
        write_table(columns_of(cases, found), output, meanings=MEANINGS, attributes=about, dimension="case")


@app.command()
def scenes(
    output: Map,
    settings: Annotated[int, typer.Option(min=2, help="settings of each scene, of eight cases each")] = 160,
    special: Annotated[int, typer.Option(min=1, help="settings of each scene under each motion made to do harm")] = 2,
    seed: Seed = 1,
    threads: Threads = 1,
    log: Log = None,
) -> None:
    """Run the shipped scenes under the map's extremes and check how each case ends."""
    from overturning.study.progress import logged_to
    from overturning.verification.stability_scene_cases import TOGETHER, scene_settings
    from overturning.verification.stability_scenes import BUDGET, MEANINGS, SPECIAL_BUDGET, run_scene_map
    from overturning.verification.table import write_table

    with logged_to(log) as say:
        found = run_scene_map(
            scene_settings(settings, special, seed),
            threads=threads,
            progress=lambda done, total: say(f"scenes: {done * TOGETHER} of {total * TOGETHER}"),
        )
        about = {"settings": settings, "special": special, "together": TOGETHER, "seed": seed}
        about |= {"budget": BUDGET, "special_budget": SPECIAL_BUDGET}
        write_table(found, output, meanings=MEANINGS, attributes=about, dimension="case")


@app.command()
def work_precision(
    part: Annotated[str, typer.Option(help="sliding, rocking, stiffness, rigid or energy")],
    output: Annotated[Path, typer.Option(help="table to make (NetCDF, CSV beside it)")],
    log: Log = None,
) -> None:
    """Set the error of schemes, time steps and stiffnesses against their run time."""
    from overturning.errors import ArgumentError
    from overturning.study.progress import logged_to
    from overturning.verification.table import write_table
    from overturning.verification.work_precision import MEANINGS, columns_of
    from overturning.verification.work_precision_parts import PARTS

    with logged_to(log) as say:
        if part not in PARTS:
            raise ArgumentError(f"part: {part!r}; known: {', '.join(PARTS)}")
        write_table(columns_of(PARTS[part](say)), output, meanings=MEANINGS)


@app.command()
def page(
    results: Annotated[Path, typer.Option(help="folder of the tables")],
    docs: Annotated[Path, typer.Option(help="folder of validation.md")],
    output: Annotated[Path, typer.Option(help="orders of convergence to write (JSON)")],
) -> None:
    """Draw the diagrams and put the measured figures into docs/validation.md."""
    import json

    from overturning.figures.stability_map import draw_map, draw_scenes, draw_shares
    from overturning.figures.work_precision import draw_against_finer_steps, draw_against_rigid_solutions
    from overturning.files import atomic_write
    from overturning.verification import page as pages
    from overturning.verification import page_map, page_tables
    from overturning.verification.table import read_table

    rows = pages.joined(
        {name: results / f"{name}.nc" for name in ("rocking", "sliding", "stiffness", "rigid", "energy", "peers")}
    )
    blocks, about = read_table(results / "stability.nc")
    scenes, about_scenes = read_table(results / "scenes.nc")
    for folder in (results, docs / "images"):
        draw_against_finer_steps(rows, folder / "work-precision-steps.svg")
        draw_against_rigid_solutions(rows, folder / "work-precision-rigid.svg")
        draw_map(blocks, folder / "stability-map.svg")
        draw_shares(blocks, folder / "stability-shares.svg")
        draw_scenes(scenes, folder / "stability-scenes.svg")
    found = pages.orders(rows)
    bodies = {
        "steps": page_tables.steps_table(rows),
        "orders": page_tables.orders_table(found),
        "stiffness": page_tables.stiffness_table(rows),
        "rigid": page_tables.rigid_table(rows),
        "stability": page_map.blocks_table(blocks, about),
        "scenes": page_map.scenes_table(scenes, about_scenes),
        "reach": page_map.reach(blocks, about, scenes),
    }
    pages.write_page(docs / "validation.md", bodies)
    with atomic_write(output) as part:
        known = {name: None if value != value else value for name, value in found.items()}
        part.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
