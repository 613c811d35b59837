"""`overturning one`: one block, or one scene, under one record, along one azimuth or several, and the film of it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

if TYPE_CHECKING:
    from overturning.dem.contact import Contact
    from overturning.records.record import Record

app = typer.Typer(rich_markup_mode=None)


@app.command()
def one(
    record: Annotated[str, typer.Option(help="id in the record table, or a record file")],
    azimuth: Annotated[list[float], typer.Option(help="degrees clockwise from north; may be given several times")],
    b_over_h: Annotated[float | None, typer.Option(help="slenderness B/H (default 0.4, or the scene's)")] = None,
    height: Annotated[float | None, typer.Option(help="height H, m (default 0.6, or the scene's)")] = None,
    friction: Annotated[float, typer.Option(help="friction coefficient µ")] = 1.0,
    density: Annotated[float | None, typer.Option(help="density, kg/m³ (default 2650)")] = None,
    damping_ratio: Annotated[float | None, typer.Option(help="damping ratio of the contact (default 1)")] = None,
    damping: Annotated[float | None, typer.Option(help="dashpot per corner instead of the ratio, N·s/m")] = None,
    stiffness: Annotated[
        float | None, typer.Option(help="normal stiffness per corner, N/m (default: automatic)")
    ] = None,
    scene: Annotated[
        str | None,
        typer.Option(help="scene of config/scenes, or a scene file; height and B/H are its reference element's"),
    ] = None,
    amplitude: Annotated[float, typer.Option(help="factor on the motion")] = 1.0,
    vertical: Annotated[bool, typer.Option(help="apply the vertical motion where the record has one")] = True,
    table: Annotated[Path, typer.Option(help="record table")] = Path("config/records.tsv"),
    folder: Annotated[Path, typer.Option(help="folder of the record files")] = Path("resources/records"),
    animate: Annotated[
        Path | None,
        typer.Option(
            help="film to write: .html (one self-contained page, with the contact forces on demand), .gif or .mp4"
        ),
    ] = None,
    response: Annotated[
        Path | None, typer.Option(help="figure of rotation, slip and uplift against time: .svg or .png")
    ] = None,
) -> None:
    """Simulate one block or scene, print what it does, and make a film or a figure of it."""
    from overturning.dem.polygon.scene import load_scene
    from overturning.dem.polygon.trajectory import scene_trajectory
    from overturning.dem.simulate import trajectory
    from overturning.errors import ArgumentError
    from overturning.figures.film_of_scene import element_path, film_of_scene, scene_outcome
    from overturning.figures.film_of_trajectory import compass_name, film_of, outcome
    from overturning.motion.motion import Motion

    for file, kinds in ((animate, {".html", ".gif", ".mp4"}), (response, {".svg", ".png"})):
        if file is not None and file.suffix.lower() not in kinds:
            raise ArgumentError(f"{file.name}: unknown kind of file; end it in {', '.join(sorted(kinds))}")
    if damping is not None and damping_ratio is not None:
        raise ArgumentError("--damping and --damping-ratio are both given; keep one")
    found = _record(record, table, folder)
    motion = Motion(found.north, found.east, found.up if vertical else None, sampling_interval=found.sampling_interval)
    place = ", ".join(part for part in (found.station or found.record_id, found.event) if part)
    if scene is None:
        b_over_h, height = 0.4 if b_over_h is None else b_over_h, 0.6 if height is None else height
        contact = _contact(stiffness, damping_ratio, damping)
        block: dict[str, Any] = {"density": 2650.0 if density is None else density, "contact": contact}
        block |= {"height": height, "b_over_h": b_over_h, "friction": friction, "amplitude": amplitude}
        moved = paths = [trajectory(motion, azimuth_deg=angle, **block) for angle in azimuth]
        title = f"{place}: B/H = {b_over_h:g}, H = {height:g} m, µ = {friction:g}"
    else:
        if any(value is not None for value in (density, stiffness, damping_ratio, damping)):
            raise ArgumentError("--scene has density, stiffness and damping of its own; set them in the scene file")
        stones = load_scene(scene)
        sizes: dict[str, Any] = {"height": height, "b_over_h": b_over_h, "friction": friction, "amplitude": amplitude}
        moved = [scene_trajectory(stones, motion, azimuth_deg=angle, **sizes) for angle in azimuth]
        paths = [element_path(path, stones.reference_name) for path in moved]
        title = f"{place}: {stones.title or stones.name}, µ = {friction:g}"
    print(title)
    for whole, path in zip(moved, paths, strict=True):
        said = outcome(path) if scene is None else scene_outcome(whole)
        if path.attrs["overturned"] == 0:
            name = "" if scene is None else f" ({stones.reference_name})"
            said += f"; slipped {100 * float(path['base_slip'][-1]):.1f} cm by the end{name}"
        print(f"  motion along {compass_name(path.attrs['azimuth_deg'])}: {said}")
    if animate is not None:
        accelerations = [amplitude * motion.along(angle) for angle in azimuth]
        note = "The frame moves with the base." + (
            f" The motion is {amplitude:g} times the record." if amplitude != 1 else ""
        )
        make = film_of if scene is None else film_of_scene
        up: dict[str, Any] = {}
        if scene is None and motion.up is not None:
            up = {"upward": amplitude * motion.up}
        film = make(moved, accelerations, motion.sampling_interval, title, note=note, **up)
        if animate.suffix.lower() == ".html":
            from overturning.figures.film_page import write_film_page

            write_film_page(film, animate)
        else:
            from overturning.figures.film_movie import write_film_movie

            write_film_movie(film, animate)
        print(f"film: {animate}")
    if response is not None:
        from overturning.figures.response import response_figure
        from overturning.figures.style import save, style

        with style():
            save(response_figure(paths, title), response)
        print(f"figure: {response}")


def _contact(stiffness: float | None, damping_ratio: float | None, damping: float | None) -> "Contact":
    from overturning.dem.contact import Contact

    springs: float | Literal["auto"] = "auto" if stiffness is None else stiffness
    if damping is not None:
        return Contact(stiffness=springs, damping=damping)
    return Contact(stiffness=springs, damping_ratio=1.0 if damping_ratio is None else damping_ratio)


def _record(name: str, table: Path, folder: Path) -> "Record":
    """A record of the table, or of a file; processed as a study would by default."""
    import difflib

    from overturning.errors import ConfigError
    from overturning.records.catalogue import read_catalogue
    from overturning.records.processing import process
    from overturning.records.read import read_path, read_record
    from overturning.records.store import rounded

    if Path(name).is_file():
        return rounded(process(read_path(Path(name)), None))
    entries = read_catalogue(table)
    if name not in entries:
        near = difflib.get_close_matches(name, entries, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"ids: {', '.join(list(entries)[:8])} …"
        raise ConfigError(f"{table}: no record {name!r}, nor a file of that name; {hint}")
    return rounded(process(read_record(entries[name], folder), None))
