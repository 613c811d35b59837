"""Films and figures of a study's telling cases."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.dem.trajectory import trajectory
from overturning.figures.boundary import boundary_figure
from overturning.figures.film import film_data
from overturning.figures.film_of_trajectory import film_of, outcome
from overturning.figures.hodograph import hodograph_figure
from overturning.figures.response import response_figure
from overturning.figures.spectra import spectra_figure
from overturning.figures.style import compass_name, save
from overturning.files import atomic_write
from overturning.motion.fourier import amplitude_spectrum, konno_ohmachi
from overturning.motion.integration import integrate
from overturning.motion.motion import Motion
from overturning.motion.spectra import spectra_by_azimuth
from overturning.records.store import read_motion
from overturning.statistics.boundary import boundary
from overturning.statistics.direction import in_space
from overturning.statistics.telling import TellingCase, telling_cases
from overturning.statistics.telling_in_space import SpaceCase, telling_in_space
from overturning.study.cube import study_of
from overturning.study.scenes import motion_of, numerics_of, scene_of

if TYPE_CHECKING:
    import xarray as xr


def draw_telling_cases(cube: "xr.Dataset", motions: Path, folder: Path) -> None:
    """Simulate the telling cases of a cube again, under the processed motions of a folder, and draw them.

    The other folder receives ``telling.json`` (titles, rules, outcomes, films) and, for case K from 1, ``K-response.svg``,
    ``K-boundary.svg``, ``K-hodograph.svg`` and ``K-spectra.svg``; in space ``K-axis.svg`` alone.
    """
    if in_space(cube):
        rows = [_draw_in_space(cube, case, motions, folder, n) for n, case in enumerate(telling_in_space(cube), 1)]
    else:
        rows = [_draw(cube, case, motions, folder, n) for n, case in enumerate(telling_cases(cube), 1)]
    with atomic_write(folder / "telling.json") as part:
        part.write_text(json.dumps(rows, ensure_ascii=False, separators=(",", ":")), encoding="utf-8")


def _draw(cube: "xr.Dataset", case: TellingCase, motions: Path, folder: Path, number: int) -> dict[str, Any]:
    study = study_of(cube)
    one = cube.isel(record=case.record).load()
    record = read_motion(motions / f"{one['record_id'].item()}.nc")
    motion = motion_of(study, record)
    panels = list(zip(case.azimuth_deg, case.amplitude, strict=True))
    paths = [
        trajectory(
            motion, scene=scene_of(study), azimuth_deg=angle, height=case.height, b_over_h=case.b_over_h,
            friction=case.friction, amplitude=factor, **vars(numerics_of(study)),
        )
        for angle, factor in panels
    ]  # fmt: skip
    place = ", ".join(text for text in (str(one["station"].item()), str(one["event"].item())) if text)
    title = f"{place}: B/H = {case.b_over_h:.3g}, H = {case.height:.3g} m, µ = {case.friction:g}"
    headings = [
        compass_name(angle) + (f", motion × {factor:g}" if len(set(case.amplitude)) > 1 else "")
        for angle, factor in panels
    ]
    film = film_of(
        paths, [factor * motion.along(angle) for angle, factor in panels], motion.sampling_interval, title,
        headings=headings, note="The frame moves with the base.",
    )  # fmt: skip
    normal = float(one["fault_normal"])
    save(response_figure(paths, title, headings), folder / f"{number}-response.svg")
    bounds = boundary(one)
    save(boundary_figure(bounds, float(cube["b_over_h"].max()), normal, place), folder / f"{number}-boundary.svg")
    save(hodograph_figure(_hodograph(motion), normal, place), folder / f"{number}-hodograph.svg")
    azimuths = list(dict.fromkeys(case.azimuth_deg))
    if len(azimuths) == 1:
        azimuths.append((azimuths[0] + 90.0) % 360.0)
    fourier, response = spectra(motion, azimuths)
    save(spectra_figure(fourier, response, place), folder / f"{number}-spectra.svg")
    return {
        "title": case.title,
        "rule": case.rule,
        "block": title,
        "record": str(one["record_id"].item()),
        "outcomes": [f"{heading}: {outcome(path)}" for heading, path in zip(headings, paths, strict=True)],
        "film": film_data(film),
    }


def _draw_in_space(cube: "xr.Dataset", case: SpaceCase, motions: Path, folder: Path, number: int) -> dict[str, Any]:
    # Imported here: with the trajectory comes the kernel of bodies in space.
    from overturning.dem.solid.trajectory import trajectory_in_space
    from overturning.figures.film_in_space import axis_figure, film_in_space, space_outcome
    from overturning.study.space import body_of, space_numerics, vertex_contact

    study, one = study_of(cube), cube.isel(record=case.record)
    record = str(one["record_id"].item())
    motion = motion_of(study, read_motion(motions / f"{record}.nc"))
    shape = body_of(study).shape()
    path = trajectory_in_space(
        motion, orientation_deg=case.orientation, height=case.height, b_over_h=case.b_over_h if shape.sized else None,
        friction=case.friction, aspect=case.aspect, body=shape, contact=vertex_contact(study.contact),
        **space_numerics(numerics_of(study), study.simulation.scheme),
    )  # fmt: skip
    place = ", ".join(text for text in (str(one["station"].item()), str(one["event"].item())) if text)
    oblong = f", D/B = {case.aspect:g}" if shape.oblong else ""
    title = f"{place}: B/H = {case.b_over_h:.3g}{oblong}, H = {case.height:.3g} m, µ = {case.friction:g}"
    save(axis_figure(path, motion, title), folder / f"{number}-axis.svg")
    facing = f"facing {compass_name(case.orientation)}"
    film = film_in_space([path], motion, title, "The frame moves with the base. Drag to turn the view.")
    return {
        "title": case.title,
        "rule": case.rule,
        "block": title,
        "record": record,
        "outcomes": [f"{facing}: {space_outcome(path)}"],
        "film": film_data(film),
    }


def _hodograph(motion: Motion) -> "xr.Dataset":
    import xarray as xr

    acceleration = motion.horizontal
    velocity = integrate(acceleration, motion.sampling_interval)
    displacement = integrate(velocity, motion.sampling_interval)
    return xr.Dataset(
        {
            f"{name}_{towards}": ("time", values[row])
            for name, values in (("acceleration", acceleration), ("velocity", velocity), ("displacement", displacement))
            for row, towards in enumerate(("north", "east"))
        }
    )


def spectra(motion: Motion, azimuth_deg: list[float]) -> tuple["xr.DataArray", "xr.DataArray"]:
    """Smoothed Fourier amplitude (azimuth, frequency; m/s) and pseudo-acceleration (azimuth, period; 5 %, m/s²)."""
    import xarray as xr

    nyquist = 0.5 / motion.sampling_interval
    at = np.geomspace(max(0.1, 2.0 / motion.duration), min(25.0, 0.8 * nyquist), 120)
    pairs = (amplitude_spectrum(motion.along(angle), motion.sampling_interval) for angle in azimuth_deg)
    smooth = [konno_ohmachi(frequency, amplitude, at) for frequency, amplitude in pairs]
    periods = np.geomspace(0.05, 10.0, 60)
    acceleration = spectra_by_azimuth(motion, periods, azimuth_deg)["acceleration"].T
    return (
        xr.DataArray(np.array(smooth), dims=("azimuth", "frequency"), coords={"azimuth": azimuth_deg, "frequency": at}),
        xr.DataArray(acceleration, dims=("azimuth", "period"), coords={"azimuth": azimuth_deg, "period": periods}),
    )
