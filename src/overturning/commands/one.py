"""`overturning one`: simulation of a block, scene, 3-D body or stack under one record, with film and figure."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from overturning.commands.declared import (
    BodyOptionsOfCommandOne,
    FilmAndFigureOptionsOfCommandOne,
    MotionOptionsOfCommandOne,
    PlanarOptionsOfCommandOne,
    RecordFileOptions,
    StoneOptionsOfCommandOne,
    expand_dataclass_parameters_to_options,
)
from overturning.commands.one_inputs import load_scene_or_create_gravestone, read_and_process_record_or_create_pulse

if TYPE_CHECKING:
    import xarray as xr

    from overturning.model.model import Model
    from overturning.model.scene import Scene
    from overturning.motion.motion import Motion


@expand_dataclass_parameters_to_options
def simulate_stone_or_scene_under_one_record(
    motion_options: MotionOptionsOfCommandOne,
    body_options: BodyOptionsOfCommandOne,
    planar_model_options: PlanarOptionsOfCommandOne,
    stone_options: StoneOptionsOfCommandOne,
    output_options: FilmAndFigureOptionsOfCommandOne,
    file_options: RecordFileOptions,
) -> None:
    """Simulate one block, scene or stack under one record; print the outcome, and write a film or figure."""
    from overturning.errors import ArgumentError
    from overturning.motion.motion import Motion
    from overturning.records.record import start_offset_from_file_start_s
    from overturning.translation.texts import use_translation_language

    _check_film_and_figure_can_be_written(output_options, body_options)
    record = read_and_process_record_or_create_pulse(motion_options, file_options)
    motion = Motion.of(record if motion_options.applies_vertical_motion else replace(record, up=None))
    if body_options.mesh is not None and not body_options.body:
        body_options = replace(body_options, body=True)
    allowed = PlanarOptionsOfCommandOne(density=planar_model_options.density if body_options.mesh else None)
    if body_options.body and planar_model_options != allowed:
        raise ArgumentError(
            "--body, --mesh: accept --orientation and --damping-ratio; leave out azimuth, scene, damping, stiffness, "
            "and density without --mesh"
        )
    is_stack = planar_model_options.scene is not None and body_options.orientation is not None
    if is_stack:
        _refuse_azimuth_or_body_options_for_stack(planar_model_options, body_options)
    elif not body_options.body:
        _check_options_of_2d_simulation(planar_model_options, body_options)
    shift, factor = start_offset_from_file_start_s(record), motion_options.amplitude_factor
    if body_options.body:
        found = _simulate_body_at_each_orientation(
            motion, factor, body_options, stone_options, shift, planar_model_options.density
        )
    elif is_stack:
        found = _simulate_stack(
            motion, factor, planar_model_options, body_options.orientation or [], stone_options, shift
        )
    else:
        found = _simulate_planar_scene(motion, factor, planar_model_options, stone_options, shift)
    place = ", ".join(part for part in (record.station or record.record_id, record.event) if part)
    # The title must state that the motion differs from the recorded one.
    times = f", motion × {factor:g}" if factor != 1 else ""
    level = ", vertical motion left out" if motion.up is None and record.up is not None else ""
    title = f"{place}{times}{level}: {found.stone_description}"
    print(title, *found.outcome_and_note_lines, *_notes_on_time_origin_in_record_file(shift), *record.notes, sep="\n  ")
    if output_options.film_path is not None:
        from overturning.figures.film_case import film_title_facts
        from overturning.figures.film_movie import write_film_as_gif_or_mp4
        from overturning.figures.film_of_trajectory import film_of_trajectories
        from overturning.figures.film_words import film_title_text, station_and_event_text
        from overturning.figures.page import write_film_html_page

        facts = film_title_facts(
            found.model, found.case_parameters_by_name,
            station_and_event_text(record.station or record.record_id, record.event),
            motion_azimuth_or_orientation_deg=found.azimuth_or_orientation_deg_if_one_case,
            amplitude_factor=factor,
            is_simulated_without_vertical_motion=motion.up is None and record.up is not None,
        )  # fmt: skip
        film = film_of_trajectories(found.trajectories, motion, film_title_text(facts), first_sample_time=shift)
        write = write_film_html_page if output_options.film_path.suffix.lower() == ".html" else write_film_as_gif_or_mp4
        with use_translation_language(output_options.language):
            write(film, output_options.film_path)
        print(f"film: {output_options.film_path}")
    if output_options.response_figure_path is not None:
        from overturning.figures.response import rotation_slip_and_uplift_figure, tilt_path_and_hodographs_figure
        from overturning.figures.style import use_package_matplotlib_settings
        from overturning.figures.write import save_figure_files

        with use_package_matplotlib_settings(), use_translation_language(output_options.language):
            figure = (
                tilt_path_and_hodographs_figure(found.trajectories[0], motion, title)
                if body_options.body or is_stack
                else rotation_slip_and_uplift_figure(found.trajectories, title)
            )
            save_figure_files(figure, output_options.response_figure_path)
        print(f"figure: {output_options.response_figure_path}")


def _notes_on_time_origin_in_record_file(motion_start_after_file_start_s: float) -> list[str]:
    """Return a list with the note that times count from the file's first sample; [] if the motion starts there."""
    if not motion_start_after_file_start_s:
        return []
    first = (
        f"{-motion_start_after_file_start_s:g} s earlier, with zeros of the filter"
        if motion_start_after_file_start_s < 0
        else f"{motion_start_after_file_start_s:g} s later"
    )
    return [f"times count from the first sample of the file; the motion that was simulated begins {first}"]


def _shift_trajectory_times_to_file_start(
    trajectory: "xr.Dataset", motion_start_after_file_start_s: float
) -> "xr.Dataset":
    """Shift the times of a simulated trajectory, so that they count from the first sample of the record file."""
    from overturning.arrays import keep_xarray_from_importing_dask

    keep_xarray_from_importing_dask()
    return trajectory.assign(
        overturning_time=trajectory["overturning_time"] + motion_start_after_file_start_s
    ).assign_coords(time=trajectory["time"] + motion_start_after_file_start_s)


@dataclass(frozen=True)
class _SimulatedTrajectories:
    """Simulated trajectories of one stone, with a description of the stone and text lines of outcomes and notes.

    There is one trajectory for each azimuth or orientation.
    """

    stone_description: str
    outcome_and_note_lines: "list[str]"
    trajectories: "list[xr.Dataset]"
    model: "Model"
    case_parameters_by_name: dict[str, float]  # height (m), b_over_h, friction; of a body also aspect

    @property
    def azimuth_or_orientation_deg_if_one_case(self) -> float | None:
        """Azimuth or orientation, degrees, of the simulated case; None if there are several."""
        name = f"{self.model.direction_dimension_name}_deg"
        return float(self.trajectories[0].attrs[name]) if len(self.trajectories) == 1 else None


def _refuse_azimuth_or_body_options_for_stack(
    planar_model_options: PlanarOptionsOfCommandOne, body_options: BodyOptionsOfCommandOne
) -> None:
    """Raise an error if options for a 3-D body or a 2-D scene are combined with those for a 3-D stack."""
    from overturning.errors import ArgumentError

    if planar_model_options.azimuth or body_options != BodyOptionsOfCommandOne(orientation=body_options.orientation):
        raise ArgumentError(
            "--scene with --orientation simulates a stack in 3-D; leave out azimuth, body, plan, aspect, mesh options"
        )


def _check_options_of_2d_simulation(
    planar_model_options: PlanarOptionsOfCommandOne, body_options: BodyOptionsOfCommandOne
) -> None:
    """Raise an error if a 2-D simulation has options for a 3-D body, or has no azimuth."""
    from overturning.errors import ArgumentError

    default = vars(BodyOptionsOfCommandOne())
    if wrong := [f"--{name.replace('_', '-')}" for name, value in vars(body_options).items() if value != default[name]]:
        raise ArgumentError(
            f"{', '.join(wrong)}: only for a 3-D body; add --body or --mesh, or --scene with --orientation"
        )
    if not planar_model_options.azimuth:
        raise ArgumentError("--azimuth: not given; give it, or in 3-D --orientation with --body or --scene")


def _simulate_stack(
    motion: "Motion",
    amplitude_factor: float,
    planar_model_options: PlanarOptionsOfCommandOne,
    front_face_azimuths_deg: list[float],
    stone_options: StoneOptionsOfCommandOne,
    motion_start_after_file_start_s: float,
) -> _SimulatedTrajectories:
    """Simulate a 3-D stack at each orientation; times count from the first sample of the record file."""
    from overturning.dem.trajectory import trajectory
    from overturning.figures.film_of_trajectory import (
        SIMULATED_TIME_AFTER_OUTCOME_S,
        azimuth_heading_of_film_panel,
        outcome_sentence,
    )
    from overturning.model.stack import Stack

    stones = load_scene_or_create_gravestone(planar_model_options, stone_options.damping_ratio)
    model, friction = Stack(stones), _checked_friction_option_or_1(stones, stone_options)
    paths = [
        _shift_trajectory_times_to_file_start(
            trajectory(
                motion, model, orientation_deg=angle, height=stone_options.height, b_over_h=stone_options.b_over_h,
                friction=friction, amplitude=amplitude_factor, aftermath=SIMULATED_TIME_AFTER_OUTCOME_S,
            ),
            motion_start_after_file_start_s,
        )
        for angle in front_face_azimuths_deg
    ]  # fmt: skip
    level = ["the motion has two components: the base moves level"] if motion.up is None else []
    sizes = {name: float(paths[0].attrs[name]) for name in ("height", "b_over_h")}
    what = f"{stones.title or stones.name} in 3-D, B/H = {sizes['b_over_h']:.3g}, H = {sizes['height']:.3g} m, "
    return _SimulatedTrajectories(
        what + f"µ = {f'{friction:g}' if stones.has_contact_with_unset_friction else 'that of the scene'}",
        [*level, *(f"{azimuth_heading_of_film_panel(path)}: {outcome_sentence(path)}" for path in paths)], paths, model,
        sizes | {"friction": friction},
    )  # fmt: skip


def _checked_friction_option_or_1(scene: "Scene", stone_options: StoneOptionsOfCommandOne) -> float:
    """Return the value of --friction, else 1; raise an error if it is given for a scene with its own coefficients."""
    from overturning.errors import ArgumentError

    if stone_options.friction is not None and not scene.has_contact_with_unset_friction:
        raise ArgumentError("--friction: the scene defines its own coefficients; set them in the scene file")
    return stone_options.friction_coefficient_or_1


def _simulate_planar_scene(
    motion: "Motion",
    amplitude_factor: float,
    planar_model_options: PlanarOptionsOfCommandOne,
    stone_options: StoneOptionsOfCommandOne,
    motion_start_after_file_start_s: float,
) -> _SimulatedTrajectories:
    """Simulate a 2-D scene along each azimuth; times count from the first sample of the record file."""
    from overturning.dem.polygon.prepare import reason_scene_moves_by_itself
    from overturning.dem.trajectory import trajectory
    from overturning.figures.film_of_trajectory import SIMULATED_TIME_AFTER_OUTCOME_S, outcome_sentence
    from overturning.figures.style import compass_bearing_text
    from overturning.model.geometry import rounded_reference_height_and_b_over_h
    from overturning.model.planes import PlanarModel

    stones = load_scene_or_create_gravestone(planar_model_options, stone_options.damping_ratio)
    own_height, own_ratio = rounded_reference_height_and_b_over_h(stones)
    height = own_height if stone_options.height is None else stone_options.height
    b_over_h = own_ratio if stone_options.b_over_h is None else stone_options.b_over_h
    friction = _checked_friction_option_or_1(stones, stone_options)
    paths = [
        _shift_trajectory_times_to_file_start(
            trajectory(
                motion, stones, azimuth_deg=angle, height=height, b_over_h=b_over_h,
                friction=friction, amplitude=amplitude_factor, aftermath=SIMULATED_TIME_AFTER_OUTCOME_S,
            ),
            motion_start_after_file_start_s,
        )
        for angle in planar_model_options.azimuth or []
    ]  # fmt: skip
    moves = reason_scene_moves_by_itself(stones, height, b_over_h, friction)
    lines = [f"note: {moves}"] if moves else []
    for path in paths:
        text, shown = outcome_sentence(path), path["element"].to_numpy() == stones.name_of_element_shown_by_default
        if path["overturned"].to_numpy()[shown] == 0:
            name = f" ({stones.name_of_element_shown_by_default})" if len(stones.free_element_names) > 1 else ""
            text += f"; slipped {100 * path['residual_slip'].to_numpy()[shown].item():z.1f} cm by the end{name}"
        lines.append(f"motion along {compass_bearing_text(path.attrs['azimuth_deg'])}: {text}")
    what = "" if planar_model_options.scene is None else f"{stones.title or stones.name}, "
    coefficient = f"{friction:g}" if stones.has_contact_with_unset_friction else "that of the scene"
    what += f"B/H = {b_over_h:.3g}, H = {height:.3g} m, µ = {coefficient}"
    block = {"height": height, "b_over_h": b_over_h, "friction": friction}
    return _SimulatedTrajectories(what, lines, paths, PlanarModel(stones), block)


def _simulate_body_at_each_orientation(
    motion: "Motion",
    amplitude_factor: float,
    body_options: BodyOptionsOfCommandOne,
    stone_options: StoneOptionsOfCommandOne,
    motion_start_after_file_start_s: float,
    density_kg_m3: float | None,
) -> _SimulatedTrajectories:
    """Simulate a 3-D body at each orientation; times count from the first sample of the record file."""
    from overturning.commands.body_shape import create_body_shape_and_scan_description_lines
    from overturning.dem.trajectory import trajectory
    from overturning.figures.film_of_trajectory import azimuth_heading_of_film_panel, outcome_sentence
    from overturning.model.body import Body
    from overturning.model.contact import VertexContact

    shape, about_scan = create_body_shape_and_scan_description_lines(body_options, density_kg_m3)
    height, b_over_h, friction = stone_options.height, stone_options.b_over_h, stone_options.friction_coefficient_or_1
    if shape.slenderness_is_parameter:
        height, b_over_h = 0.6 if height is None else height, 0.4 if b_over_h is None else b_over_h
    damping_ratio = stone_options.damping_ratio
    contact = VertexContact() if damping_ratio is None else VertexContact(damping_ratio=damping_ratio)
    paths = [
        _shift_trajectory_times_to_file_start(
            trajectory(
                motion, Body(shape, contact), orientation_deg=angle, height=height, b_over_h=b_over_h,
                friction=friction, aspect=body_options.aspect, amplitude=amplitude_factor,
            ),
            motion_start_after_file_start_s,
        )
        for angle in body_options.orientation or [0.0]
    ]  # fmt: skip
    level = ["the motion has two components: the base moves level"] if motion.up is None else []
    sizes, oblong = paths[0].attrs, f", D/B = {body_options.aspect:g}" if shape.depth_over_width_is_parameter else ""
    return _SimulatedTrajectories(
        f"{shape.name}, B/H = {sizes['b_over_h']:.3g}{oblong}, H = {sizes['height']:.3g} m, µ = {friction:g}",
        [*about_scan, *level, *(f"{azimuth_heading_of_film_panel(path)}: {outcome_sentence(path)}" for path in paths)],
        paths,
        Body(shape, contact),
        {name: float(sizes[name]) for name in ("height", "b_over_h")}
        | {"friction": friction, "aspect": body_options.aspect},
    )


def _check_film_and_figure_can_be_written(
    output_options: FilmAndFigureOptionsOfCommandOne, body_options: BodyOptionsOfCommandOne
) -> None:
    """Raise an error before the simulation if the film or figure could not be written after it."""
    from overturning.errors import ArgumentError
    from overturning.files import check_output_path
    from overturning.translation.texts import ENGLISH, check_font_is_installed, check_language_is_known

    language = output_options.language or ENGLISH
    check_language_is_known(language)
    film_path, figure_path = output_options.film_path, output_options.response_figure_path
    if output_options.language is not None and film_path is None and figure_path is None:
        raise ArgumentError("--language: only films and figures have one; add --animate or --response, or leave it out")
    for path in (film_path, figure_path):
        if path is not None and path.suffix.lower() not in (".html", ".svg"):
            check_font_is_installed(language, path.name)
    check_output_path(film_path, "--animate", ".html", ".gif", ".mp4")
    check_output_path(figure_path, "--response", ".svg", ".png", ".pdf")
    if film_path is not None:
        from overturning.figures.film_movie import check_film_can_be_written

        in_space = body_options.body or body_options.orientation is not None
        check_film_can_be_written(film_path, is_3d=in_space)
    if figure_path is not None and len(body_options.orientation or ()) > 1:
        raise ArgumentError(f"{figure_path.name}: one orientation at a time; give --orientation once")
