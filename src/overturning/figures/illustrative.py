"""Films and figures of a study's illustrative cases."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from overturning.dem.trajectory import trajectory
from overturning.figures.boundary import boundary_figure
from overturning.figures.drawn_case import DrawnCase, write_cases
from overturning.figures.film_of_trajectory import film_of, heading_of, outcome
from overturning.figures.ground import hodograph_figure, spectra_figure
from overturning.figures.response import axis_figure, response_figure
from overturning.figures.style import style
from overturning.figures.write import refill_folder, save
from overturning.labels import friction_label
from overturning.model.falls import model_of
from overturning.model.planes import Planes
from overturning.motion.motion import Motion
from overturning.records.store import read_motion
from overturning.statistics.boundary import overturning_boundary
from overturning.statistics.illustrative import IllustrativeCase, illustrative_cases
from overturning.study.cube import open_records, study_of_cube
from overturning.study.scenes import motion_for_variant, numerics_of_study, variant_model
from overturning.study.schema import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def draw_illustrative_cases(cube_path: Path, motions: Path, folder: Path) -> None:
    """Simulate the illustrative cases of a cube again, with the motions in the folder `motions`, and draw them.

    Writes into `folder`: ``cases.json`` (title, rule, outcomes, film and figures of each case) and the figures of case
    K, counted from 1: ``K-response.svg``, ``K-boundary.svg``, ``K-spectra.svg`` and ``K-hodograph.svg``; for a 3-D body
    ``K-axis.svg`` and ``K-axis-2.svg``.
    """
    with refill_folder(folder), open_records(cube_path) as cube, style():
        rows = [
            _draw_case(cube, case, motions, folder, number) for number, case in enumerate(illustrative_cases(cube), 1)
        ]
        write_cases(rows, folder)


CaseFigure = tuple[str, "Figure", str, dict[str, float]]
"""A figure that accompanies a film: suffix of the file name, figure, alternative text, options for the report."""


def _draw_case(cube: "xr.Dataset", case: IllustrativeCase, motions: Path, folder: Path, number: int) -> DrawnCase:
    """Simulate one illustrative case again and draw its film and figures."""
    study, one = study_of_cube(cube), cube.isel(record=case.record).load()
    record = str(one["record_id"].item())
    motion = motion_for_variant(study, read_motion(motions / f"{record}.nc"))
    paths = block_trajectories(study, motion, case.block, case.direction_deg)
    place = ", ".join(text for text in (str(one["station"].item()), str(one["event"].item())) if text)
    title = f"{place}: {block_label(study, case.block)}"
    film = film_of(paths, motion, title, note="The frame moves with the base.")
    if model_of(one).one_component:
        drawn = _figures_for_planar_film(one, paths, motion, (title, place))
    else:
        about = "tilt of the axis towards north and east, and hodographs of the ground"
        several = enumerate(paths, 1)
        drawn = [
            ("axis" if n == 1 else f"axis-{n}", axis_figure(path, motion, title), about, {}) for n, path in several
        ]
    figures = {}
    for name, figure, alt, options in drawn:
        save(figure, folder / f"{number}-{name}.svg")
        figures[f"{number}-{name}.svg"] = {"alt": alt, **options}
    return DrawnCase(
        title=case.title,
        rule=case.rule,
        block=title,
        record=record,
        outcomes=tuple(f"{heading_of(path)}: {outcome(path)}" for path in paths),
        film=film.data(),
        keys=film.panels[0].keys,
        figures=figures,
    )


def block_label(study: Study, block: dict[str, float]) -> str:
    """Return slenderness, height and friction of a block as text for a title."""
    oblong = f", D/B = {block['aspect']:g}" if variant_model(study).has_free_aspect else ""
    coefficient = friction_label(study, block["friction"])
    return f"B/H = {block['b_over_h']:.3g}{oblong}, H = {block['height']:.3g} m, {coefficient}"


def _figures_for_planar_film(
    one: "xr.Dataset", paths: list["xr.Dataset"], motion: Motion, texts: tuple[str, str]
) -> list[CaseFigure]:
    """Return the figures that accompany a 2-D film: response, boundary, spectra and hodograph.

    `texts` are the title and the place.
    """
    (title, place), normal = texts, float(one["fault_normal"])
    azimuths = list(dict.fromkeys(float(path.attrs["azimuth_deg"]) for path in paths))
    if len(azimuths) == 1:
        azimuths.append((azimuths[0] + 90.0) % 360.0)
    edge = boundary_figure(
        overturning_boundary(one).assign_attrs(one.attrs), float(one["b_over_h"].max()), normal, place
    )
    seen = "acceleration, velocity and displacement seen from above"
    return [
        (
            "response",
            response_figure(paths, title),
            "rotation, slip and uplift against time",
            {"most_height": 14},
        ),
        ("boundary", edge, "largest B/H that falls, by azimuth", {"most_height": 11}),
        ("spectra", spectra_figure(motion, azimuths, place), "Fourier and response spectra", {}),
        ("hodograph", hodograph_figure(motion, normal, place), seen, {}),
    ]


def block_trajectories(
    study: Study, motion: Motion, block: dict[str, float], directions_deg: Sequence[float]
) -> list["xr.Dataset"]:
    """Return the trajectories of a block of a study, one for each direction, degrees."""
    model = variant_model(study)
    own = {
        "b_over_h": not model.has_free_slenderness,
        "friction": isinstance(model, Planes) and not model.scene.sweeps_friction,
    }
    given = {name: value for name, value in block.items() if not own.get(name)}
    options: dict[str, Any] = {**given, **vars(numerics_of_study(study))}
    return [trajectory(motion, model, **options, **{f"{model.direction}_deg": angle}) for angle in directions_deg]
