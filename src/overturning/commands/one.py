"""`overturning one`: simulation of a 2-D block or scene, or of a 3-D body, under one record, with film and figure."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from overturning.commands.declared import (
    RESOURCES,
    TABLE,
    BodyOptions,
    FileOptions,
    MotionOptions,
    OutputOptions,
    PlaneOptions,
    StoneOptions,
    spread_options,
)

if TYPE_CHECKING:
    import xarray as xr

    from overturning.model.scene import Scene
    from overturning.motion.motion import Motion
    from overturning.records.record import Record


@spread_options
def one(
    shaking: MotionOptions,
    space: BodyOptions,
    plane: PlaneOptions,
    stone: StoneOptions,
    outputs: OutputOptions,
    given: FileOptions,
) -> None:
    """Simulate one block or scene, print the outcome, and write a film or a figure of it."""
    from overturning.errors import ArgumentError
    from overturning.motion.motion import Motion
    from overturning.records.record import start_offset_from_file

    _check_outputs(outputs, space)
    record = _record(shaking, given)
    motion = Motion.of(record if shaking.vertical else replace(record, up=None))
    if space.body and plane != PlaneOptions():
        raise ArgumentError(
            "--body: accepts --orientation and --damping-ratio; leave out azimuth, scene, density, damping, stiffness"
        )
    if not space.body and space != BodyOptions():
        raise ArgumentError("--orientation, --plan, --mesh, --aspect: only for a 3-D body; add --body")
    if not space.body and not plane.azimuth:
        raise ArgumentError("--azimuth: not given; give the azimuth of the motion, or use --body with --orientation")
    shift = start_offset_from_file(record)
    found = (
        _simulate_body(motion, shaking.amplitude, space, stone, shift)
        if space.body
        else _simulate_planar(motion, shaking.amplitude, plane, stone, shift)
    )
    place = ", ".join(part for part in (record.station or record.record_id, record.event) if part)
    # The title must state that the motion differs from the recorded one.
    times = f", motion × {shaking.amplitude:g}" if shaking.amplitude != 1 else ""
    level = ", vertical motion left out" if motion.up is None and record.up is not None else ""
    title = f"{place}{times}{level}: {found.what}"
    print(title, *found.lines, *_time_notes(shift), *record.notes, sep="\n  ")
    if outputs.animate is not None:
        from overturning.figures.film_movie import write_film_movie
        from overturning.figures.film_of_trajectory import film_of
        from overturning.figures.page import write_film_page

        film = film_of(found.paths, _motion_in_file_time(motion, shift), title, note="The frame moves with the base.")
        write = write_film_page if outputs.animate.suffix.lower() == ".html" else write_film_movie
        write(film, outputs.animate)
        print(f"film: {outputs.animate}")
    if outputs.response is not None:
        from overturning.figures.response import axis_figure, response_figure
        from overturning.figures.style import style
        from overturning.figures.write import save

        with style():
            figure = axis_figure(found.paths[0], motion, title) if space.body else response_figure(found.paths, title)
            save(figure, outputs.response)
        print(f"figure: {outputs.response}")


def _time_notes(shift: float) -> list[str]:
    """Return a note on the clock of lines, films and figures, where the processing has moved the first sample."""
    if not shift:
        return []
    first = f"{-shift:g} s earlier, with zeros of the filter" if shift < 0 else f"{shift:g} s later"
    return [f"times count from the first sample of the file; the motion that was simulated begins {first}"]


def _in_file_time(path: "xr.Dataset", shift: float) -> "xr.Dataset":
    """Return a trajectory with times that count from the first sample of the file."""
    return path.assign(overturning_time=path["overturning_time"] + shift).assign_coords(time=path["time"] + shift)


def _motion_in_file_time(motion: "Motion", shift: float) -> "Motion":
    """Return the motion to draw, from the first sample of the file on: without the filter's zeros before it."""
    import numpy as np

    from overturning.motion.motion import Motion

    before = round(-shift / motion.sampling_interval)
    parts = [np.pad(samples, (max(0, -before), 0))[max(0, before) :] for samples in motion.components]
    return Motion(*parts, sampling_interval=motion.sampling_interval, trust_data=True)


@dataclass(frozen=True)
class _Simulated:
    """Simulated trajectories with a description of the stone and a line of text for each outcome."""

    what: str
    lines: "list[str]"
    paths: "list[xr.Dataset]"


def _simulate_planar(
    motion: "Motion", amplitude: float, plane: PlaneOptions, stone: StoneOptions, shift: float
) -> _Simulated:
    """Simulate a scene along each azimuth; ``shift``, s, is added to times of the motion to give those of the file."""
    from overturning.dem.trajectory import trajectory
    from overturning.errors import ArgumentError
    from overturning.figures.film_of_trajectory import outcome
    from overturning.figures.style import compass_name
    from overturning.model.geometry import reference_element_size

    stones = _scene(plane, stone.damping_ratio)
    own_height, own_ratio = reference_element_size(stones)
    height = own_height if stone.height is None else stone.height
    b_over_h = own_ratio if stone.b_over_h is None else stone.b_over_h
    if stone.friction is not None and not stones.sweeps_friction:
        raise ArgumentError("--friction: the scene defines its own coefficients; set them in the scene file")
    friction = stone.coefficient
    paths = [
        _in_file_time(
            trajectory(
                motion, stones, azimuth_deg=angle, height=height, b_over_h=b_over_h,
                friction=friction, amplitude=amplitude,
            ),
            shift,
        )
        for angle in plane.azimuth or []
    ]  # fmt: skip
    lines = []
    for path in paths:
        text, shown = outcome(path), path["element"].to_numpy() == stones.default_element
        if path["overturned"].to_numpy()[shown] == 0:
            name = f" ({stones.default_element})" if len(stones.free_names) > 1 else ""
            text += f"; slipped {100 * path['residual_slip'].to_numpy()[shown].item():z.1f} cm by the end{name}"
        lines.append(f"motion along {compass_name(path.attrs['azimuth_deg'])}: {text}")
    what = "" if plane.scene is None else f"{stones.title or stones.name}, "
    coefficient = f"{friction:g}" if stones.sweeps_friction else "that of the scene"
    return _Simulated(f"{what}B/H = {b_over_h:.3g}, H = {height:.3g} m, µ = {coefficient}", lines, paths)


def _simulate_body(
    motion: "Motion", amplitude: float, space: BodyOptions, stone: StoneOptions, shift: float
) -> _Simulated:
    """Simulate a body at each orientation; ``shift``, s, is added to times of the motion to give those of the file."""
    from overturning.dem.trajectory import trajectory
    from overturning.errors import ArgumentError
    from overturning.figures.film_of_trajectory import heading_of, outcome
    from overturning.model.body import Body
    from overturning.model.contact import VertexContact
    from overturning.model.mesh import read_mesh
    from overturning.model.shapes import shape_of

    if space.plan is not None and space.mesh is not None:
        raise ArgumentError("--plan, --mesh: both given; leave one out")
    plan: Any = space.plan or "rectangle"
    shape = shape_of(read_mesh(space.mesh) if space.mesh else int(plan) if plan.isdecimal() else plan)
    height, b_over_h, friction = stone.height, stone.b_over_h, stone.coefficient
    if shape.has_free_slenderness:
        height, b_over_h = 0.6 if height is None else height, 0.4 if b_over_h is None else b_over_h
    contact = VertexContact() if stone.damping_ratio is None else VertexContact(damping_ratio=stone.damping_ratio)
    paths = [
        _in_file_time(
            trajectory(
                motion, Body(shape, contact), orientation_deg=angle, height=height, b_over_h=b_over_h,
                friction=friction, aspect=space.aspect, amplitude=amplitude,
            ),
            shift,
        )
        for angle in space.orientation or [0.0]
    ]  # fmt: skip
    level = ["the motion has two components: the base moves level"] if motion.up is None else []
    sizes, oblong = paths[0].attrs, f", D/B = {space.aspect:g}" if shape.has_free_aspect else ""
    return _Simulated(
        f"{shape.name}, B/H = {sizes['b_over_h']:.3g}{oblong}, H = {sizes['height']:.3g} m, µ = {friction:g}",
        [*level, *(f"{heading_of(path)}: {outcome(path)}" for path in paths)],
        paths,
    )


def _check_outputs(wanted: OutputOptions, space: BodyOptions) -> None:
    """Raise an error if an output file cannot be written, before the simulation."""
    from overturning.errors import ArgumentError
    from overturning.files import check_output

    check_output(wanted.animate, "--animate", ".html", ".gif", ".mp4")
    check_output(wanted.response, "--response", ".svg", ".png", ".pdf")
    if wanted.animate is not None:
        from overturning.figures.film_movie import check_movie

        check_movie(wanted.animate, in_space=space.body)
    if wanted.response is not None and space.body and len(space.orientation or ()) > 1:
        raise ArgumentError(f"{wanted.response.name}: one orientation at a time; give --orientation once")


def _scene(plane: PlaneOptions, damping_ratio: float | None) -> "Scene":
    """Return the named scene, or the default gravestone with the given density and contact."""
    from overturning.errors import ArgumentError
    from overturning.model.contact import Contact
    from overturning.model.scene import gravestone, load_scene
    from overturning.units import GRANITE_DENSITY

    if plane.scene is None:
        stiffness: Literal["auto"] | float = "auto" if plane.stiffness is None else plane.stiffness
        contact = Contact(stiffness=stiffness, damping_ratio=damping_ratio, damping=plane.damping)
        return gravestone(contact, GRANITE_DENSITY if plane.density is None else plane.density)
    if any(value is not None for value in (plane.density, plane.stiffness, damping_ratio, plane.damping)):
        raise ArgumentError("--scene: the scene defines density, stiffness and damping; set them in the scene file")
    return load_scene(plane.scene)


def _record(shaking: MotionOptions, given: FileOptions) -> "Record":
    """Return a record of the table, a file or a pulse, with the default processing of a study."""
    from overturning.errors import ArgumentError, ConfigError, did_you_mean
    from overturning.files import project_file
    from overturning.records.catalogue import read_catalogue
    from overturning.records.processing import process_record
    from overturning.records.pulses import SHAPES, parse_pulse, pulse_record
    from overturning.records.read import read_record, read_without_processing
    from overturning.records.store import round_as_stored

    name, table = shaking.record, shaking.table or TABLE
    is_pulse = bool(name.split()) and name.split()[0] in SHAPES
    if (is_pulse or Path(name).is_file()) and (shaking.table, shaking.folder) != (None, None):
        what = "a pulse" if is_pulse else "a file"
        raise ArgumentError(f"--table, --folder: --record {name!r} is {what}, not in a record table; leave them out")
    if Path(name).is_file():
        return round_as_stored(process_record(read_without_processing(Path(name), given.declarations()), None))
    if given != FileOptions():
        raise ArgumentError(f"--record {name!r}: no such file; options that describe a file, such as --unit, need one")
    if is_pulse:
        return round_as_stored(pulse_record(parse_pulse(name)))
    if " " not in name and (Path(name).suffix or len(Path(name).parts) > 1):
        raise ConfigError(f"--record {name}: no such file; give a file, or the id of a record in {table}")
    entries = read_catalogue(project_file(table))
    if name not in entries:
        raise ConfigError(
            f"{table}: no record {name!r}, nor a file of that name or a pulse; {did_you_mean(name, entries)}"
        )
    return round_as_stored(process_record(read_record(entries[name], shaking.folder or RESOURCES), None))
