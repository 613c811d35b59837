"""Films made from trajectories of the elements of 2-D scenes or of 3-D bodies."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.figures.film import (
    FRAME_INTERVAL_S,
    MIN_VISIBLE_MOVEMENT_M_OR_RAD,
    Film,
    FilmPanel,
    frame_times_around_movement,
)
from overturning.figures.film_of_body import (
    body_or_stack_film_panel,
    body_outcome_sentence,
    stack_outcome_sentence,
    stack_tilts_quaternions_positions_by_time,
    tilt_north_east_quaternion_and_position_by_time,
)
from overturning.figures.film_of_plane import free_element_poses_by_time, scene_film_panel, scene_outcome_sentence
from overturning.figures.film_words import (
    NO_OUTCOME_SENTENCE_BY_STATUS,
    REFERENCE_FRAME_NOTE,
    VIEW_ROTATION_HINT,
    panel_heading_with_motion_or_front_azimuth,
)
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion

if TYPE_CHECKING:
    import xarray as xr

SIMULATED_TIME_AFTER_OUTCOME_S: Final = 5.0
"""Time for which the simulation of a filmed scene goes on after its outcome is known, s: until its stones lie."""

LAST_FILMED_TO_LARGEST_MOVEMENT_RATIO: Final = 0.1
"""Share of the largest movement of a stone that stands, below which its film ends."""


def azimuth_heading_of_film_panel(trajectory: "xr.Dataset") -> str:
    """Return the heading of a film panel: azimuth of the motion (2-D), or azimuth that the body faces (3-D)."""
    display = _film_functions_for_trajectory(trajectory)
    return panel_heading_with_motion_or_front_azimuth(
        float(trajectory.attrs[display.trajectory_direction_attribute_name]),
        is_3d=display is not _FILM_FUNCTIONS_2D_SCENE,
    )


def trajectory_has_known_outcome(trajectory: "xr.Dataset") -> bool:
    """True if a simulated trajectory ended with a valid outcome: it is known whether stones fall."""
    return CaseStatus(int(trajectory["status"])).trajectory_has_known_outcome


def outcome_sentence(trajectory: "xr.Dataset") -> str:
    """Return a sentence, without full stop, on what falls in a simulation, or why it has no outcome."""
    if trajectory_has_known_outcome(trajectory):
        return _film_functions_for_trajectory(trajectory).outcome_sentence_of(trajectory)
    return NO_OUTCOME_SENTENCE_BY_STATUS[CaseStatus(int(trajectory["status"]))]


def first_and_last_movement_times_for_film(trajectory: "xr.Dataset") -> tuple[float, float] | None:
    """Return the times, s, of the first and last movement of the free bodies; None if nothing moves.

    A body moves while its pose differs by more than `MIN_VISIBLE_MOVEMENT_M_OR_RAD` from both its first and its last
    pose. If nothing falls, differences below `LAST_FILMED_TO_LARGEST_MOVEMENT_RATIO` times the largest one do not count
    as last movement, since a stone may rock on for long.
    """
    times = _movement_start_return_after_peak_and_end_times(trajectory)
    return None if times is None else (times[0], times[2])


def _movement_start_return_after_peak_and_end_times(trajectory: "xr.Dataset") -> tuple[float, float, float] | None:
    """Return the times (s) of the first movement, of the return from the largest movement, and of the last movement.

    The bodies have returned when their movement is below `LAST_FILMED_TO_LARGEST_MOVEMENT_RATIO` times the largest or
    invisible. None if nothing moves. For the other times see `first_and_last_movement_times_for_film`.
    """
    poses, time = (
        _film_functions_for_trajectory(trajectory).extract_poses_for_motion_check(trajectory),
        trajectory["time"].to_numpy(),
    )
    away = np.minimum(np.abs(poses - poses[:1]), np.abs(poses - poses[-1:])).max(axis=1)
    least = (
        MIN_VISIBLE_MOVEMENT_M_OR_RAD
        if has_fallen_stone(trajectory)
        else max(MIN_VISIBLE_MOVEMENT_M_OR_RAD, LAST_FILMED_TO_LARGEST_MOVEMENT_RATIO * float(away.max()))
    )
    moving = np.flatnonzero(away > MIN_VISIBLE_MOVEMENT_M_OR_RAD)
    if not moving.size:
        return None
    largest = int(away.argmax())
    back = largest + int(
        np.argmax(
            away[largest:]
            < max(MIN_VISIBLE_MOVEMENT_M_OR_RAD, LAST_FILMED_TO_LARGEST_MOVEMENT_RATIO * float(away.max()))
        )
    )
    return float(time[moving[0]]), float(time[back]), float(time[np.flatnonzero(away >= least)[-1]])


def has_fallen_stone(trajectory: "xr.Dataset") -> bool:
    """True if at least one stone falls in a simulation."""
    return bool((np.abs(trajectory["overturned"].to_numpy()) == 1).any())


def film_start_and_end_times(trajectories: Sequence["xr.Dataset"]) -> tuple[float, float]:
    """Return the times, s, between which a film shows several trajectories: first to last movement in any of them.

    If stones fall in some trajectories, those without a fall count only until they return from their largest movement.
    If nothing moves in any trajectory, the film shows 3 s before to 3 s after the peak ground acceleration.
    """
    spans = [
        (has_fallen_stone(trajectory), times)
        for trajectory in trajectories
        if (times := _movement_start_return_after_peak_and_end_times(trajectory)) is not None
    ]
    if spans:
        any_falls = any(fell for fell, _ in spans)
        ends = [times[1 if any_falls and not fell else 2] for fell, times in spans]
        return min(times[0] for _, times in spans), max(ends)
    ground, time = trajectories[0]["ground_acceleration"].to_numpy(), trajectories[0]["time"].to_numpy()
    size = np.hypot(*ground[:, :2].T) if ground.ndim > 1 else np.abs(ground)
    peak = float(time[int(size.argmax())])
    return max(0.0, peak - 3.0), min(float(time[-1]), peak + 3.0)


def film_of_trajectories(
    trajectories: Sequence["xr.Dataset"],
    motions: Motion | Sequence[Motion],
    title: str,
    *,
    headings: Sequence[str] = (),
    note: str = REFERENCE_FRAME_NOTE,
    first_sample_time: float = 0.0,
) -> Film:
    """Return a film with one panel per simulation, from shortly before the first movement to after the last.

    Parameters
    ----------
    trajectories : sequence of Dataset
        Trajectories, one for each panel. Those of a scene should be simulated with an `aftermath` of
        `SIMULATED_TIME_AFTER_OUTCOME_S`, so that fallen stones lie at the end.
    motions : Motion or sequence of Motion
        One motion for all trajectories, or one for each. The ground moved as this motion times the amplitude factor
        stored in the trajectory.
    title : str
        Title; see `overturning.figures.film_words.film_title_text`.
    headings : sequence of str
        Headings of the panels; by default the azimuth of the motion (2-D) or the azimuth that the body faces (3-D).
    note : str
        Line below the film; a hint on how to turn the view of a 3-D body is appended.
    first_sample_time : float
        Time of the first sample of the motions, s, in the times of the trajectories. A negative value means that the
        ground moves before time 0, since a filter needs time before the record; the film begins at time 0 or later.

    Raises
    ------
    ArgumentError
        If `trajectories` is empty, or its length differs from that of `motions` or `headings`.
    """
    if not trajectories:
        raise ArgumentError("trajectories: none given; a film needs at least one trajectory")
    each = [motions] * len(trajectories) if isinstance(motions, Motion) else list(motions)
    names = list(headings) or [azimuth_heading_of_film_panel(trajectory) for trajectory in trajectories]
    if not len(each) == len(names) == len(trajectories):
        raise ArgumentError(
            f"motions, headings: {len(each)} and {len(names)}; give one for each of {len(trajectories)} trajectories"
        )
    time = frame_times_around_movement(*film_start_and_end_times(trajectories))
    panels = tuple(
        _film_functions_for_trajectory(trajectory).create_film_panel(
            trajectory, motion, time, (name, outcome_sentence(trajectory)), first_sample_time
        )
        for trajectory, motion, name in zip(trajectories, each, names, strict=True)
    )
    hint = _film_functions_for_trajectory(trajectories[0]).view_rotation_hint_below_film
    return Film(
        title,
        float(time[0]),
        FRAME_INTERVAL_S,
        panels,
        note_below_film=f"{note} {hint}".strip(),
    )


class _FilmFunctionsOfModelKind(NamedTuple):
    """Functions and texts with which a film shows one kind of simulation: a 2-D scene, a 3-D body or a 3-D stack."""

    trajectory_direction_attribute_name: str  # name of the attribute with the direction, degrees
    outcome_sentence_of: Callable[["xr.Dataset"], str]  # sentence for the outcome of a valid simulation
    extract_poses_for_motion_check: Callable[
        ["xr.Dataset"], FloatArray
    ]  # poses that show whether anything moves, shape (time, n)
    # Panel at the times of the frames; the last argument is the time of the first sample of the motion.
    create_film_panel: Callable[["xr.Dataset", Motion, FloatArray, tuple[str, str], float], FilmPanel]
    view_rotation_hint_below_film: str  # hint below the film


_FILM_FUNCTIONS_2D_SCENE: Final = _FilmFunctionsOfModelKind(
    "azimuth_deg", scene_outcome_sentence, free_element_poses_by_time, scene_film_panel, ""
)
_FILM_FUNCTIONS_3D_BODY: Final = _FilmFunctionsOfModelKind(
    "orientation_deg",
    body_outcome_sentence,
    tilt_north_east_quaternion_and_position_by_time,
    body_or_stack_film_panel,
    VIEW_ROTATION_HINT,
)
_FILM_FUNCTIONS_3D_STACK: Final = _FilmFunctionsOfModelKind(
    "orientation_deg",
    stack_outcome_sentence,
    stack_tilts_quaternions_positions_by_time,
    body_or_stack_film_panel,
    VIEW_ROTATION_HINT,
)


def _film_functions_for_trajectory(trajectory: "xr.Dataset") -> _FilmFunctionsOfModelKind:
    """Return the functions and texts with which a film shows a trajectory, by its kind: scene, body or stack."""
    if "quaternion" not in trajectory:
        return _FILM_FUNCTIONS_2D_SCENE
    return _FILM_FUNCTIONS_3D_STACK if "element" in trajectory.dims else _FILM_FUNCTIONS_3D_BODY
