"""Film of a simulation: bodies with poses over time, the input motion below them, and optional contact forces.

A film shows any number of polygons that are free, driven or held, or one convex body in 3-D. Poses are relative to the
ground; with the ground's displacement the player also shows them from the earth.
"""

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.figures.film_words import COMPONENTS, PLAYER, SPEEDS
from overturning.figures.style import group_extremes
from overturning.motion.integration import integrate
from overturning.units import GAL

FRAME_INTERVAL = 0.02
"""Time between frames, s. A block of 0.5 m rocks in seconds; between frames the player interpolates."""

LEAD_IN = 0.4
"""Time shown before the first movement, s: two seconds at the speed at which a film starts."""

MOVEMENT_TOLERANCE = 4e-3
"""Smallest distance of a pose from its start and from its end that counts as movement: 1 to 2 pixels of a film.

The unit is m for positions and rad for rotations; direction cosines and quaternions have no unit.
"""

LINGER = 0.6
"""Time shown after the last block has fallen or come to rest, s."""


@dataclass(frozen=True)
class FilmBody:
    """A polygon in a vertical plane, or a convex body in 3-D, with its poses over time."""

    name: str
    vertices: FloatArray  # about its reference point, m: s (right) and z, or east, north and up, shape (n, 2 | 3)
    position: FloatArray  # of the reference point, m, shape (frames, 2 | 3), or (1, 2) if it does not move
    rotation: FloatArray  # towards +s (clockwise), rad, shape (frames,) or (1,); or quaternion, (frames, 4)
    free: bool = True  # not driven or held
    faces: tuple[tuple[int, ...], ...] = ()  # 3-D: vertices of each face, anticlockwise seen from outside

    def player_data(self) -> dict[str, Any]:
        """Return the body as plain data for the player."""
        return {
            "name": self.name,
            "free": self.free,
            "vertices": [[round(float(part), 5) for part in vertex] for vertex in self.vertices],
            "faces": self.faces,
            "position": _as_base64_integers(self.position),
            "rotation": _as_base64_integers(self.rotation),
        }


@dataclass(frozen=True)
class FilmPanel:
    """Panel of a film, which shows one simulation."""

    title: str  # heading, for instance the azimuth
    outcome: str  # sentence shown from `outcome_time` on
    outcome_time: float  # s; NaN: shown at the end of the film
    bodies: tuple[FilmBody, ...]  # in drawing order
    acceleration: FloatArray  # of the base, m/s²: towards +s, shape (n,), or towards north and east, shape (2, n)
    sampling_interval: float  # of the acceleration, s; its first sample is at time 0
    sides: tuple[str, str] = ("", "")  # names of the directions −s and +s
    force_point: FloatArray | None = None  # contact points, m, shape (frames, k, 2)
    force: FloatArray | None = None  # on the free bodies at these points, in units of the weight; 0 without contact
    vertical: FloatArray | None = None  # upward acceleration of the base, m/s², shape (n,); None: none is applied
    ground: FloatArray | None = None  # displacement of the base since the first frame, m, shape (frames, 2 | 3)

    @property
    def in_space(self) -> bool:
        """True if the panel shows a 3-D body."""
        return bool(self.bodies[0].faces)

    @property
    def player_keys(self) -> str:
        """Description of the player's keys that only this kind of film has."""
        return "a and d turn the view, as dragging it does" if self.in_space else "f shows contact forces"

    def motion_traces(self, with_vertical: bool) -> list[tuple[str, list[FloatArray]]]:
        """Return the traces below the scene, each as label and components; with one of the `with_vertical` motion."""
        level = list(np.atleast_2d(self.acceleration))
        shown = [(COMPONENTS["along" if len(level) == 1 else "level"], level)]
        if with_vertical:
            up = np.zeros_like(level[0]) if self.vertical is None else self.vertical
            shown.append((COMPONENTS["no_up" if self.vertical is None else "up"], [up]))
        return shown

    def player_data(self, film: "Film") -> dict[str, Any]:
        """Return the panel as plain data for the player of a film."""
        traces = [
            (label, [_thinned_motion(one, self.sampling_interval, film) for one in rows])
            for label, rows in self.motion_traces(film.has_vertical_motion)
        ]
        data: dict[str, Any] = {
            "title": self.title,
            "outcome": self.outcome,
            "outcomeTime": None if np.isnan(self.outcome_time) else round(float(self.outcome_time), 4),
            "sides": self.sides,
            "bodies": [body.player_data() for body in self.bodies],
            "traces": [
                {"label": label, "rows": [_as_base64_integers(row / GAL) for row, _ in rows]} for label, rows in traces
            ],
            "traceInterval": round(traces[0][1][0][1], 9),
        }
        if self.ground is not None:
            data["ground"] = _as_base64_integers(self.ground)
        if self.force is not None and self.force_point is not None:
            data["points"] = self.force.shape[1]
            data["forcePoint"], data["force"] = _as_base64_integers(self.force_point), _as_base64_integers(self.force)
        return data


@dataclass(frozen=True)
class Film:
    """A film: panels, each with one simulation, that play synchronously."""

    title: str  # heading
    start: float  # time of the first frame, s after the record's start
    frame_interval: float  # s
    panels: tuple[FilmPanel, ...]  # a panel with fewer frames than another stays at its last frame
    note: str = ""  # line below the film
    frames: int = field(init=False)

    def __post_init__(self) -> None:
        if not self.panels:
            raise ArgumentError("panels: none given; a film needs at least one simulation")
        if not self.frame_interval > 0:
            raise ArgumentError(f"frame_interval: {self.frame_interval}; it must be a positive number of seconds")
        bodies = [(panel.title, body) for panel in self.panels for body in panel.bodies]
        for title, body in bodies:
            if not (np.isfinite(body.position).all() and np.isfinite(body.rotation).all()):
                raise ArgumentError(f"{title}, {body.name}: a pose is not finite")
        object.__setattr__(self, "frames", max(len(body.position) for _, body in bodies))

    @property
    def has_vertical_motion(self) -> bool:
        """True if a panel has vertical motion; all panels then show a trace of it."""
        return any(panel.vertical is not None for panel in self.panels)

    @property
    def peak_acceleration(self) -> float:
        """Largest acceleration of the base in any trace, m/s²: the scale of all traces."""
        rows = [
            row
            for panel in self.panels
            for _, several in panel.motion_traces(self.has_vertical_motion)
            for row in several
        ]
        return max(float(np.abs(row).max(initial=0.0)) for row in rows)

    @property
    def frame_times(self) -> FloatArray:
        """Times of the frames, s after the record's start."""
        return np.asarray(self.start + self.frame_interval * np.arange(self.frames))

    @property
    def end_time(self) -> float:
        """Time of the last frame, s."""
        return self.start + (self.frames - 1) * self.frame_interval

    def player_data(self) -> dict[str, Any]:
        """Return the film as plain data for JSON; poses, motions and forces are base64 of scaled 16-bit integers."""
        return {
            "title": self.title,
            "start": round(self.start, 6),
            "interval": self.frame_interval,
            "frames": self.frames,
            "view": [round(float(edge), 4) for edge in free_body_extent(self)],
            "earthView": [round(float(edge), 4) for edge in free_body_extent(self, moving=True)],
            "peak": round(self.peak_acceleration / GAL, 3),
            "note": self.note,
            "words": PLAYER,
            "speeds": [[speed, name] for speed, name in SPEEDS.items()],
            "panels": [panel.player_data(self) for panel in self.panels],
        }


def frame_times_between(first_movement: float, last_movement: float) -> FloatArray:
    """Return the times of the frames, s: from `LEAD_IN` before the first movement to `LINGER` after the last one."""
    start = max(0.0, float(np.floor((first_movement - LEAD_IN) / FRAME_INTERVAL)) * FRAME_INTERVAL)
    return np.asarray(
        start + FRAME_INTERVAL * np.arange(int(np.ceil((last_movement + LINGER - start) / FRAME_INTERVAL)) + 1)
    )


def interpolate_columns(frame_time: FloatArray, sample_time: FloatArray, columns: FloatArray) -> FloatArray:
    """Return columns sampled at the times `sample_time` interpolated to the times of a film's frames."""
    return np.stack([np.interp(frame_time, sample_time, column) for column in columns.T], axis=1)


def vertex_paths(body: FilmBody) -> FloatArray:
    """Return the vertices of a polygon in all frames, m, shape (frames, n, 2).

    A vertex (s, z) is at s₀ + s cos θ + z sin θ, z₀ − s sin θ + z cos θ.
    """
    (s, z), cos, sin = body.vertices.T, np.cos(body.rotation)[:, None], np.sin(body.rotation)[:, None]
    return np.asarray(body.position[:, None] + np.stack([s * cos + z * sin, z * cos - s * sin], axis=-1))


def free_body_extent(film: Film, *, moving: bool = False) -> tuple[float, float, float, float]:
    """Return the extent (left, right, bottom, top), m, that contains the free polygons of all panels and frames.

    With a `moving` ground it is the extent as seen from the earth.
    """
    places = [
        vertex_paths(body) + (ground_shift_at_frames(panel, len(body.position))[:, None] if moving else 0.0)
        for panel in film.panels
        for body in panel.bodies
        if body.free and not panel.in_space
    ]
    if not places:
        return -1.0, 1.0, -0.5, 1.5
    points = np.concatenate([one.reshape(-1, 2) for one in places])
    (left, bottom), (right, top) = (bound(points, axis=0).tolist() for bound in (np.min, np.max))
    margin = 0.12 * max(right - left, top - bottom)
    return left - margin, right + margin, bottom - 1.5 * margin, top + margin


def ground_shift_at_frames(panel: FilmPanel, frames: int) -> FloatArray:
    """Return the displacement of the ground of a panel in a number of frames, m; zero if the panel has none."""
    width = 3 if panel.in_space else 2
    return np.zeros((frames, width)) if panel.ground is None else panel.ground[:frames]


def ground_displacement(components: Sequence[FloatArray | None], interval: float, times: FloatArray) -> FloatArray:
    """Return the displacement of the ground since the first of some times, m, shape (times, components).

    Parameters
    ----------
    components : sequence of ndarray or None
        Accelerations, m/s², whose first samples are at time 0; None for a component that does not move.
    interval : float
        Sampling interval, s.
    times : ndarray
        Times, s. After the record the ground keeps its last velocity, which is small if the record does not drift.
    """
    columns = []
    for samples in components:
        if samples is None:
            columns.append(np.zeros(times.size))
            continue
        missing = max(0, int(np.ceil(times[-1] / interval)) + 2 - samples.size)
        moved = integrate(integrate(np.pad(samples, (0, missing)), interval), interval)
        at = np.interp(times, interval * np.arange(moved.size), moved)
        columns.append(at - at[0])
    return np.stack(columns, axis=1)


def _as_base64_integers(values: ArrayLike) -> dict[str, Any]:
    """Return numbers as base64 of 16-bit integers with a common scale: 1/32000 of the largest, below a pixel."""
    array = np.asarray(values, dtype=np.float64).ravel()
    largest = float(np.abs(array).max(initial=0.0))
    scale = float(f"{largest / 32000 or 1.0:.6g}")
    whole = np.clip(np.rint(array / scale), -32767, 32767).astype("<i2")
    return {"scale": scale, "data": base64.b64encode(whole.tobytes()).decode("ascii")}


def _thinned_motion(acceleration: FloatArray, interval: float, film: Film) -> tuple[FloatArray, float]:
    """Return the part of a motion that the film shows, thinned to the extremes of each 0.02 s, and its interval, s."""
    first, last = int(film.start / interval), int(np.ceil(film.end_time / interval)) + 1
    piece = np.concatenate([acceleration[first:last], np.zeros(max(0, last - max(first, acceleration.size)))])
    group = max(1, int(np.floor(0.0201 / interval)))
    if group <= 2 or piece.size < 2 * group:
        return piece, interval
    return group_extremes(piece, group)[1], interval * group / 2
