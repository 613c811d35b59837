"""Where blocks fall: over all cases, and by the shape of the block."""

import numpy as np

from overturning.report.blocks import Block, Disclosure, Figure, Note, Section, Table
from overturning.report.results import Results
from overturning.report.sections.answer import half_width
from overturning.report.text import degrees, interval, number
from overturning.statistics.by_record import record_groups
from overturning.statistics.earthquakes import AxisSummary, axes_by_earthquake


def falls(results: Results) -> Section | None:
    """Rose of fall azimuths, and the alignment with the fault normal by shape; none where nothing falls."""
    if not results.fallen > 0:
        return None
    caption = results.words.rose
    blocks: list[Block] = [Figure(results.figures / "rose.svg", "rose of fall azimuths", caption, width=0.8)]
    if not results.model.one_component:
        of_each = "The same for each earthquake, its records taken together; dashed: fault normals."
        blocks.append(
            Figure(results.figures / "earthquakes.svg", "roses of fall azimuths by earthquake", of_each, width=0.9)
        )
    if results.tells_axes:
        blocks += [_summary_table(results.axes), Note(_ABOUT_AXES)]
        note = Note("No p-value is given here: with so many shapes some would look small by chance.")
        blocks.append(Disclosure("Alignment with the fault normal by B/H and friction", (_by_shape(results), note)))
    return Section("Where blocks fall", tuple(blocks), anchor="rose")


_ABOUT_AXES = (
    "Fall axis of each earthquake relative to its fault normal, over all blocks. Alignment is the mean of cos 2Δ over "
    "earthquakes, Δ the angle between fall axis and fault normal: 1 normal to the fault, −1 along it, 0 neither. "
    "Intervals: "
    "95 %, bootstrap over earthquakes. Rayleigh: any preferred axis; V: the fault normal, stated beforehand; both on "
    "doubled "
    "angles."
)


def _by_shape(results: Results) -> Table:
    """Mean alignment over earthquakes for each B/H and friction, heights taken together."""
    cube = results.cube
    heads, columns = ["B/H", "µ"], []
    for name, chosen in record_groups(cube).items():
        axes = axes_by_earthquake(cube.isel(record=np.flatnonzero(chosen)), "b_over_h", "friction")["axis"]
        alignment = axes.copy(data=np.cos(np.radians(2 * axes.to_numpy())))
        columns += [alignment.count("event").to_numpy(), alignment.mean("event").to_numpy()]
        heads += [f"earthquakes with falls, {name}", f"alignment, {name}"]
    rows = []
    for i, b_over_h in enumerate(cube["b_over_h"].to_numpy()):
        for j, friction in enumerate(cube["friction"].to_numpy()):
            cells = (number(float(column[i, j]), place % 2 * 2) for place, column in enumerate(columns))
            rows.append((f"{b_over_h:g}", f"{friction:g}", *cells))
    return Table(tuple(heads), tuple(rows), "nn", sortable=True)


def _summary_table(axes: dict[str, AxisSummary]) -> Table:
    rows = tuple(
        (
            *(name, str(s.earthquakes), str(s.n), degrees(abs(s.mean_axis_deg)), half_width(s)),
            *("–" if s.n == 0 else number(s.alignment), interval(*s.alignment_interval)),
            f"{s.closer_to_normal} of {s.n}",
            *("–" if s.n < 2 else f"{test.p_value:.2g}" for test in (s.rayleigh, s.v)),
        )
        for name, s in axes.items()
    )
    heads = ("records", "earthquakes", "with falls", "mean axis from normal", "interval", "alignment", "interval")
    return Table((*heads, "closer to normal", "Rayleigh p", "V test p"), rows)
