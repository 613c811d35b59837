"""Simulated fraction of the grid of stones, and the average over neighbouring faces."""

import numpy as np
import pytest

from overturning.surveys.design import average_over_orientations, simulated_cells_mask


@pytest.mark.parametrize("orientations", [6, 12])
def test_every_sixth_combination_with_all_frictions_evenly(orientations: int) -> None:
    masks = np.stack(
        [[simulated_cells_mask(h, b, 3, 13, orientations) for b in range(6)] for h in range(4)]
    )  # heights, shapes, frictions, levels, orientations
    assert masks.mean() == pytest.approx(1 / 6)
    assert masks.mean(axis=(0, 1, 3, 4)) == pytest.approx(np.full(3, 1 / 6))
    assert (masks.sum(axis=2) <= 1).all(), "one friction at most"
    used = masks.any(axis=2)  # heights, shapes, levels, orientations
    for axis in range(4):
        assert not (np.diff(used.astype(int), axis=axis) == 0).any(), "every second one along each dimension"
    assert (used[..., -1] != used[..., 0]).all(), "also across the turn after which the stone looks the same"
    # Along a row every second combination is simulated, in turn with each friction.
    row = masks[0, 0, :, :, 0]
    frictions = row.argmax(axis=0)[row.any(axis=0)]
    assert set(frictions[:3]) == {0, 1, 2}


def test_all_combinations_of_round_stones() -> None:
    assert simulated_cells_mask(1, 2, 3, 13, 1).all()


def test_falls_along_the_face_stay_along_the_face() -> None:
    """Stones of every orientation fall 10° clockwise of their face: so they do on average, with the same share."""
    bins, step, orientations = 72, 3, 12
    shares = np.zeros((2, orientations, bins + 1))
    for number in range(orientations):
        shares[:, number, (step * number + 2) % bins] = [0.3, 0.7]
    shares[..., bins] = 1 - shares[..., :bins].sum(axis=-1)
    averaged = average_over_orientations(shares, bins, step)
    # The last orientation and the first one are neighbours, with faces half a turn apart that look the same.
    assert averaged[:, 1:-1] == pytest.approx(shares[:, 1:-1])
    assert averaged.sum(axis=-1) == pytest.approx(np.ones((2, orientations)))
    ends = averaged[0, 0, :bins]
    assert ends[2] == pytest.approx(0.3 * 0.75)
    assert ends[(2 + bins // 2) % bins] == pytest.approx(0.3 * 0.25), (
        "the stone of the last orientation, half a turn on"
    )


def test_one_orientation_is_not_averaged() -> None:
    shares = np.random.default_rng(1).random((3, 1, 73))
    assert average_over_orientations(shares, 72, 3) is shares
