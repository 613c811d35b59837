"""Films for tests, from closed forms: a block that falls towards +s and one that stands; path of a falling 3-D body."""

import math

import numpy as np
import xarray as xr

from overturning.dem.trajectory import trajectory
from overturning.figures.film import Film, FilmBody, FilmPanel
from overturning.motion.motion import Motion


def trajectory_of_3d_body(motion: Motion, b_over_h: float = 0.25) -> xr.Dataset:
    """Compute the trajectory of a slender 3-D body, 0.6 m high, under a motion."""
    return trajectory(motion, "rectangle", orientation_deg=10.0, height=0.6, b_over_h=b_over_h, friction=0.8)


def rocking_film_block(rotation: np.ndarray, width: float = 0.24, height: float = 0.6) -> FilmBody:
    """Return a film block with a rotation in each frame, rad, about its right base corner (if > 0) or its left one."""
    pivot = np.where(rotation >= 0, width / 2, -width / 2)
    s = pivot - pivot * np.cos(rotation) + height / 2 * np.sin(rotation)
    z = pivot * np.sin(rotation) + height / 2 * np.cos(rotation)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [width / 2, height / 2]
    return FilmBody("block", corners, np.stack([s, z], axis=1), rotation)


FILM_BASE = FilmBody(
    "base", np.array([[-5, -0.3], [5, -0.3], [5, 0], [-5, 0.0]]), np.zeros((1, 2)), np.zeros(1), is_free=False
)


def film_of_one_falling_and_one_rocking_block(
    duration: float = 4.0, title: str = "Test block", forces: bool = True
) -> Film:
    """Return a film of two blocks: the first falls at 2.5 s, the second rocks and stands."""
    time = np.arange(0, duration + 1e-9, 0.02)
    falls = np.clip((time - 1.0) / 1.5, 0, 1) ** 3 * math.pi / 2
    rocks = 0.1 * np.sin(2 * np.pi * time) * np.exp(-time)
    acceleration = 3 * np.sin(2 * np.pi * np.arange(0, duration, 0.01))
    force, point = np.zeros((2, time.size, 2, 2))
    force[:, :, 1], point[:, 0, 0], point[:, 1, 0] = 0.5, -0.12, 0.12
    contacts = (point, force) if forces else (None, None)
    ground = 0.1 * np.stack([np.sin(np.pi * time), 0 * time], axis=1)
    panels = (
        FilmPanel(
            name,
            outcome,
            at,
            (FILM_BASE, rocking_film_block(rotation)),
            acceleration,
            0.01,
            ("N240°E", name),
            *contacts,
            ground_displacement_by_frame=ground,
        )
        for name, rotation, outcome, at in (
            ("N60°E", falls, "falls towards N60°E at 2.10 s", 2.1),
            ("N330°E", rocks, "stands", math.nan),
        )
    )
    return Film(title, 0.0, 0.02, tuple(panels), note_below_film="The frame moves with the base.")
