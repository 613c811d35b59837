"""Which cells of a grid have neighbours of the same flag."""

import numpy as np


def agreeing_neighbours(flags: np.ndarray) -> np.ndarray:
    """Cells whose neighbours in azimuth and B/H have the same flag in the reference."""
    after = np.roll(flags, -1, axis=0)
    after[-1] = -flags[0]  # half a turn further the sides are exchanged
    before = np.roll(flags, 1, axis=0)
    before[0] = -flags[-1]
    agree = (after == flags) & (before == flags)
    agree[:, :, 1:] &= flags[:, :, :-1] == flags[:, :, 1:]
    agree[:, :, :-1] &= flags[:, :, 1:] == flags[:, :, :-1]
    return agree
