"""Film of a simulation: bodies with poses over time, the input motion below them, and optional contact forces.

A film shows any number of polygons that are free, driven or held, or convex bodies in 3-D. Poses are relative to the
ground; with the ground's displacement the player also shows them from the earth.
"""

import base64
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.figures.film_words import ACCELERATION_TRACE_LABELS, PLAYBACK_SPEED_LABELS, PLAYER_TEXTS
from overturning.figures.style import indices_and_values_of_minima_and_maxima
from overturning.motion.integration import integrate
from overturning.units import GAL

if TYPE_CHECKING:
    import xarray as xr

FRAME_INTERVAL_S = 0.02
"""Time between frames, s. A block of 0.5 m rocks in seconds; between frames the player interpolates."""

TIME_BEFORE_FIRST_MOVEMENT_S = 0.4
"""Time shown before the first movement, s: two seconds at the speed at which a film starts."""

MIN_VISIBLE_MOVEMENT_M_OR_RAD = 4e-3
"""Smallest distance of a pose from its start and from its end that counts as movement: 1 to 2 pixels of a film.

The unit is m for positions and rad for rotations; direction cosines and quaternions have no unit.
"""

TIME_AFTER_LAST_MOVEMENT_S = 0.6
"""Time shown after the last block has fallen or come to rest, s."""


@dataclass(frozen=True)
class FilmBody:
    """Rigid body in a film: a polygon in a vertical plane or a convex 3-D body, with its pose in each frame."""

    name: str
    vertices_from_reference_point: (
        FloatArray  # about its reference point, m: s (right) and z, or east, north and up, shape (n, 2 | 3)
    )
    reference_point_positions_by_frame: (
        FloatArray  # of the reference point, m, shape (frames, 2 | 3), or (1, 2) if it does not move
    )
    angles_or_quaternions_by_frame: (
        FloatArray  # towards +s (clockwise), rad, shape (frames,) or (1,); or quaternion, (frames, 4)
    )
    is_free: bool = True  # not driven or held
    face_vertex_indices: tuple[tuple[int, ...], ...] = ()  # 3-D: vertices of each face, anticlockwise seen from outside

    def player_data(self) -> dict[str, Any]:
        """Return shape, positions and rotations of the body as a dictionary for the JavaScript film player."""
        return {
            "name": self.name,
            "free": self.is_free,
            "vertices": [[round(float(part), 5) for part in vertex] for vertex in self.vertices_from_reference_point],
            "faces": self.face_vertex_indices,
            "position": _encode_as_scaled_base64_integers(self.reference_point_positions_by_frame),
            "rotation": _encode_as_scaled_base64_integers(self.angles_or_quaternions_by_frame),
        }


@dataclass(frozen=True)
class FilmPanel:
    """One panel of a film: the bodies, base motion, heading and outcome of one simulation."""

    title: str  # heading, for instance the azimuth
    outcome_sentence: str  # sentence shown from `last_fall_time` on
    last_fall_time: float  # time of the last fall, s; NaN: the outcome is shown at the end of the film
    bodies: tuple[FilmBody, ...]  # in drawing order
    horizontal_base_acceleration: (
        FloatArray  # of the base, m/s²: towards +s, shape (n,), or towards north and east, shape (2, n)
    )
    acceleration_sampling_interval: float  # of the acceleration, s; its first sample is at time 0
    left_and_right_bearings: tuple[str, str] = ("", "")  # names of the directions −s and +s
    contact_positions_by_frame: FloatArray | None = None  # contact points, m, shape (frames, k, 2)
    contact_forces_over_weight: FloatArray | None = (
        None  # on the free bodies at these points, in units of the weight; 0 without contact
    )
    vertical_base_acceleration: FloatArray | None = (
        None  # upward acceleration of the base, m/s², shape (n,); None: none is applied
    )
    ground_displacement_by_frame: FloatArray | None = (
        None  # displacement of the base since the first frame, m, shape (frames, 2 | 3)
    )
    first_fall_time: float = math.nan  # s; NaN: `last_fall_time`

    @property
    def first_fall_time_for_printed_strip(self) -> float:
        """Time of the first fall, s, at which the printed strip shows a frame; NaN if nothing falls."""
        return self.last_fall_time if math.isnan(self.first_fall_time) else self.first_fall_time

    @property
    def shows_3d_body(self) -> bool:
        """True if the panel shows 3-D bodies."""
        return bool(self.bodies[0].face_vertex_indices)

    @property
    def keyboard_help_specific_to_2d_or_3d(self) -> str:
        """Text on the keys that the film player accepts only for films of this kind (2-D or 3-D)."""
        return "a and d turn the view, as dragging it does" if self.shows_3d_body else "f shows contact forces"

    def labelled_acceleration_traces(self, includes_vertical_trace: bool) -> list[tuple[str, list[FloatArray]]]:
        """Return the acceleration traces drawn below the bodies: label, and samples of each component, m/s²."""
        level = list(np.atleast_2d(self.horizontal_base_acceleration))
        shown = [(ACCELERATION_TRACE_LABELS["along" if len(level) == 1 else "level"], level)]
        if includes_vertical_trace:
            up = np.zeros_like(level[0]) if self.vertical_base_acceleration is None else self.vertical_base_acceleration
            shown.append(
                (ACCELERATION_TRACE_LABELS["no_up" if self.vertical_base_acceleration is None else "up"], [up])
            )
        return shown

    def player_data(self, film: "Film") -> dict[str, Any]:
        """Return the panel as a dictionary for the JavaScript film player, with the accelerations during `film`."""
        traces = [
            (
                label,
                [
                    _film_acceleration_extremes_and_interval(one, self.acceleration_sampling_interval, film)
                    for one in rows
                ],
            )
            for label, rows in self.labelled_acceleration_traces(film.has_vertical_motion)
        ]
        data: dict[str, Any] = {
            "title": self.title,
            "outcome": self.outcome_sentence,
            "outcomeTime": None if np.isnan(self.last_fall_time) else round(float(self.last_fall_time), 4),
            "sides": self.left_and_right_bearings,
            "bodies": [body.player_data() for body in self.bodies],
            "traces": [
                {"label": label, "rows": [_encode_as_scaled_base64_integers(row / GAL) for row, _ in rows]}
                for label, rows in traces
            ],
            "traceInterval": round(traces[0][1][0][1], 9),
        }
        if self.ground_displacement_by_frame is not None:
            data["ground"] = _encode_as_scaled_base64_integers(self.ground_displacement_by_frame)
        if self.contact_forces_over_weight is not None and self.contact_positions_by_frame is not None:
            data["points"] = self.contact_forces_over_weight.shape[1]
            data["forcePoint"], data["force"] = (
                _encode_as_scaled_base64_integers(self.contact_positions_by_frame),
                _encode_as_scaled_base64_integers(self.contact_forces_over_weight),
            )
        return data


@dataclass(frozen=True)
class Film:
    """Film of simulations in one or more panels that play synchronously."""

    title: str  # heading
    first_frame_time: float  # time of the first frame, s after the record's start
    frame_interval: float  # s
    panels: tuple[FilmPanel, ...]  # a panel with fewer frames than another stays at its last frame
    note_below_film: str = ""  # line below the film
    frame_count: int = field(init=False)

    def __post_init__(self) -> None:
        if not self.panels:
            raise ArgumentError("panels: none given; a film needs at least one simulation")
        if not self.frame_interval > 0:
            raise ArgumentError(f"frame_interval: {self.frame_interval}; it must be a positive number of seconds")
        bodies = [(panel.title, body) for panel in self.panels for body in panel.bodies]
        for title, body in bodies:
            if not (
                np.isfinite(body.reference_point_positions_by_frame).all()
                and np.isfinite(body.angles_or_quaternions_by_frame).all()
            ):
                raise ArgumentError(f"{title}, {body.name}: a pose is not finite")
        object.__setattr__(self, "frame_count", max(len(body.reference_point_positions_by_frame) for _, body in bodies))

    @property
    def has_vertical_motion(self) -> bool:
        """True if any panel has vertical motion; every panel of the film then shows a trace of it."""
        return any(panel.vertical_base_acceleration is not None for panel in self.panels)

    @property
    def peak_base_acceleration_of_all_panels(self) -> float:
        """Peak absolute base acceleration of all panels, m/s², to which all drawn traces are scaled."""
        rows = [
            row
            for panel in self.panels
            for _, several in panel.labelled_acceleration_traces(self.has_vertical_motion)
            for row in several
        ]
        return max(float(np.abs(row).max(initial=0.0)) for row in rows)

    @property
    def frame_times(self) -> FloatArray:
        """Times of the frames, s after the record's start."""
        return np.asarray(self.first_frame_time + self.frame_interval * np.arange(self.frame_count))

    @property
    def last_frame_time(self) -> float:
        """Time of the last frame of the film, s after the start of the record."""
        return self.first_frame_time + (self.frame_count - 1) * self.frame_interval

    def player_data(self) -> dict[str, Any]:
        """Return the film as a dictionary for JSON; positions, motions and forces are base64 texts of integers."""
        return {
            "title": self.title,
            "start": round(self.first_frame_time, 6),
            "interval": self.frame_interval,
            "frames": self.frame_count,
            "view": [round(float(edge), 4) for edge in extent_of_free_2d_bodies_with_margin(self)],
            "earthView": [
                round(float(edge), 4)
                for edge in extent_of_free_2d_bodies_with_margin(self, adds_ground_displacement=True)
            ],
            "peak": round(self.peak_base_acceleration_of_all_panels / GAL, 3),
            "note": self.note_below_film,
            "words": PLAYER_TEXTS,
            "speeds": [[speed, name] for speed, name in PLAYBACK_SPEED_LABELS.items()],
            "panels": [panel.player_data(self) for panel in self.panels],
        }


def frame_times_around_movement(first_movement_time: float, last_movement_time: float) -> FloatArray:
    """Return the times of the film frames, s, from shortly before the first movement to shortly after the last."""
    start = max(
        0.0, float(np.floor((first_movement_time - TIME_BEFORE_FIRST_MOVEMENT_S) / FRAME_INTERVAL_S)) * FRAME_INTERVAL_S
    )
    return np.asarray(
        start
        + FRAME_INTERVAL_S
        * np.arange(int(np.ceil((last_movement_time + TIME_AFTER_LAST_MOVEMENT_S - start) / FRAME_INTERVAL_S)) + 1)
    )


def interpolate_to_frame_times(
    frame_times: FloatArray, sample_times: FloatArray, values_by_sample_and_column: FloatArray
) -> FloatArray:
    """Interpolate columns of sampled values linearly to the times of film frames, shape (frames, columns)."""
    return np.stack([np.interp(frame_times, sample_times, column) for column in values_by_sample_and_column.T], axis=1)


def fall_times_of_fallen_stones(trajectory: "xr.Dataset") -> list[float]:
    """Return the times, s, at which stones fall in a simulation; stones that stand are left out."""
    times = np.ravel(trajectory["overturning_time"].to_numpy())
    return [float(time) for time in times[np.isfinite(times)]]


def polygon_vertices_by_frame(body: FilmBody) -> FloatArray:
    """Return the positions of the n vertices of a polygon in all frames, m, shape (frames, n, 2).

    Vertex (s, z) of a body at (s₀, z₀), turned by θ: s₀ + s cos θ + z sin θ, z₀ − s sin θ + z cos θ.
    """
    (s, z), cos, sin = (
        body.vertices_from_reference_point.T,
        np.cos(body.angles_or_quaternions_by_frame)[:, None],
        np.sin(body.angles_or_quaternions_by_frame)[:, None],
    )
    return np.asarray(
        body.reference_point_positions_by_frame[:, None] + np.stack([s * cos + z * sin, z * cos - s * sin], axis=-1)
    )


def extent_of_free_2d_bodies_with_margin(
    film: Film, *, adds_ground_displacement: bool = False
) -> tuple[float, float, float, float]:
    """Return a rectangle (left, right, bottom, top), m, around all free polygons of a film at all times, with a margin.

    If `adds_ground_displacement`, positions include the ground displacement, for the player's view with moving ground.
    """
    places = [
        polygon_vertices_by_frame(body)
        + (
            ground_displacement_at_frames(panel, len(body.reference_point_positions_by_frame))[:, None]
            if adds_ground_displacement
            else 0.0
        )
        for panel in film.panels
        for body in panel.bodies
        if body.is_free and not panel.shows_3d_body
    ]
    if not places:
        return -1.0, 1.0, -0.5, 1.5
    points = np.concatenate([one.reshape(-1, 2) for one in places])
    (left, bottom), (right, top) = (bound(points, axis=0).tolist() for bound in (np.min, np.max))
    margin = 0.12 * max(right - left, top - bottom)
    return left - margin, right + margin, bottom - 1.5 * margin, top + margin


def ground_displacement_at_frames(panel: FilmPanel, frame_count: int) -> FloatArray:
    """Return the ground displacement, m, in the first `frame_count` frames of a panel, shape (frames, 2 or 3).

    It is 0 if the panel stores no ground displacement.
    """
    width = 3 if panel.shows_3d_body else 2
    return (
        np.zeros((frame_count, width))
        if panel.ground_displacement_by_frame is None
        else panel.ground_displacement_by_frame[:frame_count]
    )


def ground_displacement_since_first_time(
    acceleration_m_s2_by_component: Sequence[FloatArray | None],
    sampling_interval: float,
    times_after_first_sample: FloatArray,
) -> FloatArray:
    """Return the ground displacement since the first of the given times, m, shape (times, components).

    The accelerations are integrated twice, from rest at the first sample.

    Parameters
    ----------
    acceleration_m_s2_by_component : sequence of ndarray or None
        Accelerations, m/s², whose first samples are at time 0; None for a component that does not move.
    sampling_interval : float
        Sampling interval, s.
    times_after_first_sample : ndarray
        Times, s. After the record the ground keeps its last velocity, which is small if the record does not drift.
    """
    columns = []
    for samples in acceleration_m_s2_by_component:
        if samples is None:
            columns.append(np.zeros(times_after_first_sample.size))
            continue
        missing = max(0, int(np.ceil(times_after_first_sample[-1] / sampling_interval)) + 2 - samples.size)
        moved = integrate(integrate(np.pad(samples, (0, missing)), sampling_interval), sampling_interval)
        at = np.interp(times_after_first_sample, sampling_interval * np.arange(moved.size), moved)
        columns.append(at - at[0])
    return np.stack(columns, axis=1)


def samples_from_time_zero(
    acceleration_samples: FloatArray, sampling_interval: float, first_sample_time: float
) -> FloatArray:
    """Return the samples of an acceleration from time 0 on, shape (…, n), given the time of its first sample, s.

    Samples before time 0 are left out; if the first sample is later than 0, zeros fill the time before it.
    """
    before = round(-first_sample_time / sampling_interval)
    zeros = [*(acceleration_samples.ndim - 1) * [(0, 0)], (max(0, -before), 0)]
    return np.pad(acceleration_samples, zeros)[..., max(0, before) :]


def _encode_as_scaled_base64_integers(values: ArrayLike) -> dict[str, Any]:
    """Encode an array as 16-bit integers in base64 text; ``scale`` is the value of one integer step."""
    array = np.asarray(values, dtype=np.float64).ravel()
    largest = float(np.abs(array).max(initial=0.0))
    scale = float(f"{largest / 32000 or 1.0:.6g}")
    whole = np.clip(np.rint(array / scale), -32767, 32767).astype("<i2")
    return {"scale": scale, "data": base64.b64encode(whole.tobytes()).decode("ascii")}


def _film_acceleration_extremes_and_interval(
    component_acceleration_from_time_zero: FloatArray, sampling_interval: float, film: Film
) -> tuple[FloatArray, float]:
    """Return the acceleration during a film, thinned to minima and maxima per 0.02 s, and its new time step, s."""
    first, last = (
        int(film.first_frame_time / sampling_interval),
        int(np.ceil(film.last_frame_time / sampling_interval)) + 1,
    )
    piece = np.concatenate(
        [
            component_acceleration_from_time_zero[first:last],
            np.zeros(max(0, last - max(first, component_acceleration_from_time_zero.size))),
        ]
    )
    group = max(1, int(np.floor(0.0201 / sampling_interval)))
    if group <= 2 or piece.size < 2 * group:
        return piece, sampling_interval
    return indices_and_values_of_minima_and_maxima(piece, group)[1], sampling_interval * group / 2
