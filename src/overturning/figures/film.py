"""A film of a simulation: polygons with poses over time, the motion below them, contact forces on demand.

The form is general: any number of polygons that are free, driven or held, or a convex body in space. The frame of
reference moves with the base.
"""

import base64
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError

FRAME_INTERVAL = 0.02
"""Time between frames, s. A block of 0.5 m rocks in seconds; between frames the player interpolates."""

LEAD_IN = 1.0
"""Quiet time shown before the first movement, s."""

LINGER = 0.6
"""Time shown after the last block has fallen or come to rest, s."""


@dataclass(frozen=True)
class Body:
    """A polygon and its way."""

    name: str
    vertices: FloatArray  # about its reference point in its own axes (s to the right, z up), m, shape (n, 2)
    position: FloatArray  # of the reference point, m, shape (frames, 2), or (1, 2) where it does not move
    rotation: FloatArray  # towards +s (clockwise on the screen), rad, shape (frames,), or (1,) where it does not turn
    free: bool = True  # not driven or held


@dataclass(frozen=True)
class Panel:
    """One simulation of a film."""

    title: str  # heading, for instance the azimuth
    outcome: str  # sentence shown once it has come about
    outcome_time: float  # when, s; NaN where it is known only at the end
    left: str  # name of the direction −s
    right: str  # and of +s
    bodies: tuple[Body, ...]  # in the order in which they are drawn
    acceleration: FloatArray  # of the base towards +s, m/s², shape (n,)
    sampling_interval: float  # of the acceleration, s; its first sample is at time 0
    force_point: FloatArray | None = None  # contact points, m, shape (frames, k, 2)
    force: FloatArray | None = None  # on the free bodies there, in units of the weight; zero where there is no contact

    keys: ClassVar = "f shows contact forces"
    """What keys of the player do beside those that all films have."""

    @property
    def poses(self) -> dict[str, tuple[FloatArray, ...]]:
        """Poses over the frames of what moves, by name."""
        return {body.name: (body.position, body.rotation) for body in self.bodies}

    def data(self, film: "Film") -> dict[str, Any]:
        """What the player needs of it."""
        motion, interval = _thinned(self.acceleration, self.sampling_interval, film)
        data: dict[str, Any] = {
            "left": self.left,
            "right": self.right,
            "bodies": [
                {
                    "name": body.name,
                    "free": body.free,
                    "vertices": [[round(float(s), 5), round(float(z), 5)] for s, z in body.vertices],
                    "position": _packed(body.position),
                    "rotation": _packed(body.rotation),
                }
                for body in self.bodies
            ],
            "motion": {**_packed(motion / 0.01), "interval": round(interval, 9)},
        }
        if self.force is not None and self.force_point is not None:
            data["points"] = self.force.shape[1]
            data["forcePoint"], data["force"] = _packed(self.force_point), _packed(self.force)
        return data


@dataclass(frozen=True)
class SpacePanel:
    """One simulation of a body in space; axes are east, north, up."""

    title: str  # heading
    outcome: str  # sentence shown once it has come about
    outcome_time: float  # when, s; NaN where it is known only at the end
    corners: FloatArray  # of the body at rest about its centre, m, shape (n, 3)
    faces: tuple[tuple[int, ...], ...]  # corners of each, anticlockwise from outside
    position: FloatArray  # of the centre, m, shape (frames, 3)
    quaternion: FloatArray  # rotation from the pose at rest, shape (frames, 4)
    acceleration: FloatArray  # of the base towards north and east, m/s², shape (2, n)
    sampling_interval: float  # of the acceleration, s; its first sample is at time 0

    bodies: ClassVar[tuple[Body, ...]] = ()
    """Polygons: none."""
    keys: ClassVar = "a and d turn the view, as dragging it does"
    """What keys of the player do beside those that all films have."""

    @property
    def poses(self) -> dict[str, tuple[FloatArray, ...]]:
        """Poses over the frames of what moves, by name."""
        return {"body": (self.position, self.quaternion)}

    def data(self, film: "Film") -> dict[str, Any]:
        """What the player needs of it."""
        motions = [_thinned(one, self.sampling_interval, film) for one in self.acceleration]
        return {
            "corners": np.round(self.corners, 5).tolist(),
            "faces": [list(face) for face in self.faces],
            "position": _packed(self.position),
            "quaternion": _packed(self.quaternion),
            "motions": [_packed(motion / 0.01) for motion, _ in motions],
            "motion": {"interval": round(motions[0][1], 9)},
        }


@dataclass(frozen=True)
class Film:
    """Panels that play in step."""

    title: str  # heading
    start: float  # time of the first frame, s after the record's start
    frame_interval: float  # s
    panels: tuple[Panel | SpacePanel, ...]  # one with fewer frames than another keeps its last one
    note: str = ""  # line below the film
    frames: int = field(init=False)

    def __post_init__(self) -> None:
        if not self.panels:
            raise ArgumentError("panels: none; a film needs at least one simulation")
        if not self.frame_interval > 0:
            raise ArgumentError(f"frame_interval: {self.frame_interval}; it must be a positive number of seconds")
        poses = [(panel.title, name, values) for panel in self.panels for name, values in panel.poses.items()]
        for title, name, values in poses:
            if not all(np.isfinite(one).all() for one in values):
                raise ArgumentError(f"{title}, {name}: a pose is not finite")
        frames = [values[0].shape[0] for _, _, values in poses]
        object.__setattr__(self, "frames", max(frames))

    @property
    def end(self) -> float:
        """Time of the last frame, s."""
        return self.start + (self.frames - 1) * self.frame_interval


def frame_times(first: float, last: float) -> FloatArray:
    """Times of the frames, s, from shortly before the first movement to shortly after the last one."""
    start = max(0.0, float(np.floor((first - LEAD_IN) / FRAME_INTERVAL)) * FRAME_INTERVAL)
    return np.asarray(start + FRAME_INTERVAL * np.arange(int(np.ceil((last + LINGER - start) / FRAME_INTERVAL)) + 1))


def about_the_peak(time: FloatArray, acceleration: FloatArray) -> tuple[float, float]:
    """Time worth showing where nothing moves, s: three seconds to either side of the motion's peak, within the path."""
    peak = float(time[int(np.abs(acceleration).argmax())])
    return max(0.0, peak - 3.0), min(float(time[-1]), peak + 3.0)


def way(body: Body) -> FloatArray:
    """Vertices of a body in all its frames, shape (frames, n, 2): s₀ + s cos θ + z sin θ, z₀ − s sin θ + z cos θ."""
    (s, z), cos, sin = body.vertices.T, np.cos(body.rotation)[:, None], np.sin(body.rotation)[:, None]
    return np.asarray(body.position[:, None] + np.stack([s * cos + z * sin, z * cos - s * sin], axis=-1))


def corners(body: Body, frame: int) -> FloatArray:
    """Vertices of a body in a frame, shape (n, 2); in its last one after that."""
    return np.asarray(way(body)[min(frame, body.rotation.size - 1)])


def view(film: Film) -> tuple[float, float, float, float]:
    """Extent (left, right, bottom, top) in m that holds every free body in every frame, the same for all panels."""
    points = [way(body).reshape(-1, 2) for panel in film.panels for body in panel.bodies if body.free]
    if not points:
        return -1.0, 1.0, -0.5, 1.5
    (left, bottom), (right, top) = (bound(np.concatenate(points), axis=0).tolist() for bound in (np.min, np.max))
    margin = 0.12 * max(right - left, top - bottom)
    return left - margin, right + margin, bottom - 1.5 * margin, top + margin


def _packed(values: ArrayLike) -> dict[str, Any]:
    """Numbers as 16-bit integers with a common scale: 1/32000 of the largest, a fraction of a pixel."""
    array = np.asarray(values, dtype=np.float64).ravel()
    largest = float(np.abs(array).max(initial=0.0))
    scale = float(f"{largest / 32000 or 1.0:.6g}")
    whole = np.clip(np.rint(array / scale), -32767, 32767).astype("<i2")
    return {"scale": scale, "data": base64.b64encode(whole.tobytes()).decode("ascii")}


def _thinned(acceleration: FloatArray, interval: float, film: Film) -> tuple[FloatArray, float]:
    """The part of a motion that the film shows, at about 100 samples per second: the extremes of each 0.02 s."""
    first, last = int(film.start / interval), int(np.ceil(film.end / interval)) + 1
    piece = np.concatenate([acceleration[first:last], np.zeros(max(0, last - max(first, acceleration.size)))])
    group = max(1, int(np.floor(0.0201 / interval)))
    if group <= 2 or piece.size < 2 * group:
        return piece, interval
    padded = np.pad(piece, (0, -piece.size % group), mode="edge").reshape(-1, group)
    places = np.sort(np.stack([padded.argmin(axis=1), padded.argmax(axis=1)], axis=1), axis=1)
    return np.take_along_axis(padded, places, axis=1).ravel(), interval * group / 2


def film_data(film: Film) -> dict[str, Any]:
    """What the player needs, as plain data for JSON: poses, motion, forces are base64 of scaled 16-bit integers."""
    return {
        "title": film.title,
        "start": round(film.start, 6),
        "interval": film.frame_interval,
        "frames": film.frames,
        "view": [round(float(edge), 4) for edge in view(film)],
        "note": film.note,
        "panels": [_panel_data(panel, film) for panel in film.panels],
    }


def _panel_data(panel: Panel | SpacePanel, film: Film) -> dict[str, Any]:
    return {
        "title": panel.title,
        "outcome": panel.outcome,
        "outcomeTime": None if np.isnan(panel.outcome_time) else round(float(panel.outcome_time), 4),
        **panel.data(film),
    }
