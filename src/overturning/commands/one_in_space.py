"""What `overturning one --solid` does: a free body in space under one record, its film and the figure of its axis."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from overturning.commands.declared import InSpace, Outputs, Stone

if TYPE_CHECKING:
    from overturning.motion.motion import Motion


def _body_named(plan: str) -> Any:
    """The body of a name, of a number of sides, or of a mesh's file."""
    from overturning.model.mesh import read_mesh

    if plan.isdigit():
        return int(plan)
    return read_mesh(Path(plan)) if Path(plan).suffix else plan


def one_in_space(
    motion: "Motion", place: str, amplitude: float, space: InSpace, stone: Stone, outputs: Outputs
) -> None:
    """Simulate a body at one orientation or several, print what it does, and make a film or a figure of it."""
    from overturning.dem.body.trajectory import trajectory_in_space
    from overturning.errors import ArgumentError
    from overturning.figures.axis import axis_figure
    from overturning.figures.film_of_trajectory import film_of, heading_of, outcome
    from overturning.figures.film_page import write_film_page
    from overturning.figures.style import save, style
    from overturning.model.contact import VertexContact
    from overturning.model.shapes import shape_of

    orientations, animate, response = space.orientation or [0.0], outputs.animate, outputs.response
    height, b_over_h, friction, aspect = stone.height, stone.b_over_h, stone.friction, space.aspect
    if animate is not None and animate.suffix.lower() != ".html":
        raise ArgumentError(f"{animate.name}: a film in space is a page that can be turned; end it in .html")
    if response is not None and len(orientations) > 1:
        raise ArgumentError(f"{response.name}: one orientation at a time; give --orientation once")
    shape = shape_of(_body_named(space.plan))
    if shape.sized:
        height, b_over_h = 0.6 if height is None else height, 0.4 if b_over_h is None else b_over_h
    contact = VertexContact() if stone.damping_ratio is None else VertexContact(damping_ratio=stone.damping_ratio)
    paths = [
        trajectory_in_space(
            motion, orientation_deg=angle, height=height, b_over_h=b_over_h, friction=friction, aspect=aspect,
            body=shape, contact=contact, amplitude=amplitude,
        )
        for angle in orientations
    ]  # fmt: skip
    sizes = paths[0].attrs
    oblong = f", D/B = {aspect:g}" if shape.oblong else ""
    title = (
        f"{place}: {shape.name}, B/H = {sizes['b_over_h']:.3g}{oblong}, H = {sizes['height']:.3g} m, µ = {friction:g}"
    )
    print(title)
    if motion.up is None:
        print("  the motion has two components: the base moves level")
    for path in paths:
        print(f"  {heading_of(path)}: {outcome(path)}")
    if animate is not None:
        note = "The frame moves with the base."
        note += f" The motion is {amplitude:g} times the record." if amplitude != 1 else ""
        write_film_page(film_of(paths, motion, title, note=note), animate)
        print(f"film: {animate}")
    if response is not None:
        with style():
            save(axis_figure(paths[0], motion, title), response)
        print(f"figure: {response}")
