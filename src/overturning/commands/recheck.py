"""`overturning recheck`: compute a random sample of a cube's cells again."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None)


@app.command()
def recheck(
    cube: Annotated[Path, typer.Argument(help="the cube (NetCDF)")],
    motions: Annotated[
        Path | None, typer.Option(help="folder of the motions (default: motion beside the cube)")
    ] = None,
    cells: Annotated[int, typer.Option(min=1, help="cells to compute again")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="seed of the sample")] = 1,
) -> None:
    """Compute a random sample of cells again and say whether they are the same, bit for bit, on this machine."""
    from overturning.study.recheck import recheck as compute_again

    found = compute_again(cube, motions, cells=cells, seed=seed)
    if not found.content_as_stated:
        print(f"{cube}: its numbers do not have the hash that it states; the file was changed after it was made")
    for line in found.differences[:10]:
        print(line)
    if len(found.differences) > 10:
        print(f"… and {len(found.differences) - 10} more")
    with_ensemble = f", {found.ensemble_cells} of them with their ensemble" if found.ensemble_cells else ""
    print(
        f"{found.cells} of {found.of} cells computed again{with_ensemble}: "
        + ("all the same, bit for bit" if not found.differences else f"{len(found.differences)} values differ")
    )
    if not found.same:
        raise typer.Exit(1)
