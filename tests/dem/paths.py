"""Helpers for gravestone trajectories: the stone, and the penetration of its lower corners."""

import numpy as np
import xarray as xr


def trajectory_of_element_named_stone(path: xr.Dataset) -> xr.Dataset:
    """Return the part of a trajectory that belongs to the element "stone"."""
    return path.sel(element="stone")


def lower_corner_penetrations(path: xr.Dataset) -> np.ndarray:
    """Return the penetration of the left and the right lower corner, shape (2, time), m; negative above the ground."""
    one = trajectory_of_element_named_stone(path)
    corners = one["vertices"].to_numpy()
    lower = corners[corners[:, 1] < 0]
    angle, z = one["rotation"].to_numpy(), one["z"].to_numpy()
    return np.stack([p * np.sin(angle) - q * np.cos(angle) - z for p, q in lower[np.argsort(lower[:, 0])]])
