"""`overturning one`: one scene, by default a single block, under one record, along one azimuth or several, and the film of it."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from overturning.commands import declared

if TYPE_CHECKING:
    import xarray as xr

    from overturning.dem.scene import Scene
    from overturning.records.record import Record

app = typer.Typer(rich_markup_mode=None)


@app.command()
def one(
    record: Annotated[
        str, typer.Option(help="id in the record table, a record file, or a pulse: 'sine amplitude_gal=800 period_s=1'")
    ],
    azimuth: Annotated[
        list[float] | None, typer.Option(help="degrees clockwise from north; may be given several times")
    ] = None,
    solid: Annotated[bool, typer.Option("--solid", help="a free body in space instead of a scene in a plane")] = False,
    orientation: Annotated[
        list[float] | None,
        typer.Option(help="of a solid: azimuth that it faces; may be given several times (default 0)"),
    ] = None,
    plan: Annotated[
        str, typer.Option(help="of a solid: rectangle, circle, number of sides, or a mesh's file (OBJ, PLY, STL)")
    ] = "rectangle",
    aspect: Annotated[float, typer.Option(help="of a solid rectangle: D/B, width across over that along")] = 1.0,
    b_over_h: Annotated[float | None, typer.Option(help="slenderness B/H (default 0.4, or the scene's)")] = None,
    height: Annotated[float | None, typer.Option(help="height H, m (default 0.6, or the scene's)")] = None,
    friction: Annotated[float, typer.Option(help="friction coefficient µ")] = 1.0,
    density: Annotated[float | None, typer.Option(help="density, kg/m³ (default 2650)")] = None,
    damping_ratio: Annotated[float | None, typer.Option(help="damping ratio of the contact (default 3)")] = None,
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
        Path | None,
        typer.Option(
            help="figure of rotation, slip and uplift against time, of a solid of its axis: .svg, .png or .pdf"
        ),
    ] = None,
    azimuths: declared.Azimuths = "",
    columns: declared.Columns = "",
    form: declared.Form = "",
    interval: declared.Interval = None,
    processed: declared.Processed = None,
    sensor: declared.Sensor = "",
    trust_data: declared.TrustData = False,
    unit: declared.Unit = "",
    vertical_sense: declared.VerticalSense = "",
) -> None:
    """Simulate one block or scene, print what it does, and make a film or a figure of it."""
    from overturning.dem.polygon.geometry import native_size
    from overturning.dem.trajectory import trajectory
    from overturning.errors import ArgumentError
    from overturning.figures.film_movie import write_film_movie
    from overturning.figures.film_of_trajectory import film_of
    from overturning.figures.film_page import write_film_page
    from overturning.figures.response import response_figure
    from overturning.figures.style import save, style
    from overturning.motion.motion import Motion

    _check_outputs(animate, response)
    given = declared.declared(azimuths, columns, form, interval, processed, sensor, trust_data, unit, vertical_sense)
    shaking = _record(record, table, folder, given)
    motion = Motion.of(shaking if vertical else replace(shaking, up=None))
    place = ", ".join(part for part in (shaking.station or shaking.record_id, shaking.event) if part)
    if solid:
        _check_solid(azimuth, scene, density, damping, stiffness)
        from overturning.commands.one_in_space import body_named, one_in_space

        one_in_space(
            motion, place, orientation or [0.0], body_named(plan), height=height, b_over_h=b_over_h, aspect=aspect,
            friction=friction, damping_ratio=damping_ratio, amplitude=amplitude, animate=animate, response=response,
        )  # fmt: skip
        return
    if not azimuth:
        raise ArgumentError("--azimuth: not given; name the plane of motion, or take --solid with --orientation")
    stones = _scene(scene, density, stiffness, damping_ratio, damping)
    own_height, own_ratio = native_size(stones)
    height, b_over_h = own_height if height is None else height, own_ratio if b_over_h is None else b_over_h
    paths = [
        trajectory(
            motion, scene=stones, azimuth_deg=angle, height=height, b_over_h=b_over_h, friction=friction,
            amplitude=amplitude,
        )
        for angle in azimuth
    ]  # fmt: skip
    what = "" if scene is None else f"{stones.title or stones.name}, "
    title = f"{place}: {what}B/H = {b_over_h:.3g}, H = {height:.3g} m, µ = {friction:g}"
    print(title)
    _print_outcomes(paths, stones)
    if animate is not None:
        note = f" The motion is {amplitude:g} times the record." if amplitude != 1 else ""
        accelerations = [amplitude * motion.along(angle) for angle in azimuth]
        film = film_of(
            paths, accelerations, motion.sampling_interval, title, note=f"The frame moves with the base.{note}"
        )
        (write_film_page if animate.suffix.lower() == ".html" else write_film_movie)(film, animate)
        print(f"film: {animate}")
    if response is not None:
        with style():
            save(response_figure(paths, title), response)
        print(f"figure: {response}")


def _check_solid(*in_planes: object) -> None:
    """Refuse what only a block in a plane has, where it is given."""
    from overturning.errors import ArgumentError

    if any(value not in (None, [], (), "") for value in in_planes):
        raise ArgumentError(
            "--solid: takes --orientation and --damping-ratio; leave out azimuth, scene, density, damping, stiffness"
        )


def _check_outputs(animate: Path | None, response: Path | None) -> None:
    """Refuse files that could not be written, before anything is computed for them."""
    from overturning.errors import ArgumentError
    from overturning.figures.film_movie import check_movie
    from overturning.files import check_output

    outputs = (("--animate", animate, {".html", ".gif", ".mp4"}), ("--response", response, {".svg", ".png", ".pdf"}))
    for option, file, kinds in outputs:
        if file is None:
            continue
        if file.suffix.lower() not in kinds:
            raise ArgumentError(f"{file.name}: unknown kind of file; end it in {', '.join(sorted(kinds))}")
        check_output(file, option)
        check_movie(file)


def _scene(
    name: str | None, density: float | None, stiffness: float | None, damping_ratio: float | None, damping: float | None
) -> "Scene":
    """The scene of a name, or the gravestone of this density and contact."""
    from overturning.dem.contact import Contact
    from overturning.dem.scene import gravestone, load_scene
    from overturning.errors import ArgumentError
    from overturning.units import GRANITE_DENSITY

    if name is None:
        contact = Contact("auto" if stiffness is None else stiffness, damping_ratio=damping_ratio, damping=damping)
        return gravestone(contact, GRANITE_DENSITY if density is None else density)
    if any(value is not None for value in (density, stiffness, damping_ratio, damping)):
        raise ArgumentError("--scene has density, stiffness and damping of its own; set them in the scene file")
    return load_scene(name)


def _record(name: str, table: Path, folder: Path, given: dict[str, Any]) -> "Record":
    """A record of the table, of a file with what is given about it, or of a pulse; processed as a study would by default."""
    import difflib

    from overturning.errors import ArgumentError, ConfigError
    from overturning.files import shipped
    from overturning.records.catalogue import read_catalogue
    from overturning.records.processing import process
    from overturning.records.pulses import SHAPES, parse_pulse, pulse_record
    from overturning.records.read import read_path, read_record
    from overturning.records.store import rounded

    if Path(name).is_file():
        return rounded(process(read_path(Path(name), **given), None))
    if given != declared.declared():
        raise ArgumentError(
            f"--record {name!r}: no file of that name; what is said of files cannot be said of anything else"
        )
    if name.split()[:1] and name.split()[0] in SHAPES:
        return rounded(pulse_record(parse_pulse(name)))
    if " " not in name and (Path(name).suffix or len(Path(name).parts) > 1):
        raise ConfigError(f"--record {name}: no such file; give a file, or the id of a record in {table}")
    entries = read_catalogue(shipped(table))
    if name not in entries:
        near = difflib.get_close_matches(name, entries, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"ids: {', '.join(list(entries)[:8])} …"
        raise ConfigError(f"{table}: no record {name!r}, nor a file of that name or a pulse; {hint}")
    return rounded(process(read_record(entries[name], folder), None))


def _print_outcomes(paths: "list[xr.Dataset]", stones: "Scene") -> None:
    from overturning.figures.film_of_trajectory import outcome
    from overturning.figures.style import compass_name

    for path in paths:
        text, shown = outcome(path), path.sel(element=stones.shown_name)
        if shown["overturned"] == 0:
            name = f" ({stones.shown_name})" if len(stones.free) > 1 else ""
            text += f"; slipped {100 * float(shown['base_slip'][-1]):.1f} cm by the end{name}"
        print(f"  motion along {compass_name(path.attrs['azimuth_deg'])}: {text}")
