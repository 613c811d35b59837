"""Figures of fall rates: labels of logarithmic axes, and names of degrees of intensity."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from overturning.figures.fall_rate import overturned_fraction_by_intensity_figure
from overturning.figures.style import set_logarithmic_ticks
from overturning.statistics.fragility import FittedFragilityCurve


@pytest.mark.parametrize(("low", "high"), [(57.0, 181.0), (21.0, 49.0), (0.3, 0.6), (1.0, 1000.0), (40.0, 60.0)])
def test_a_logarithmic_axis_has_at_least_two_labels(low: float, high: float) -> None:
    figure, axes = plt.subplots()
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    set_logarithmic_ticks(axes.xaxis)
    figure.canvas.draw()
    labels = [label for label in axes.get_xticklabels() if low <= label.get_position()[0] <= high and label.get_text()]
    assert 2 <= len(labels) <= 10
    plt.close(figure)


@pytest.mark.parametrize(
    ("least", "most", "names"),
    [
        (4.6, 6.6, ["5+", "6−", "6+", "7"]),
        (6.1, 6.6, ["6+", "7"]),  # from within 6 upper
        (6.47, 6.8, ["7"]),  # hardly any of 6 upper
        (5.2, 5.4, ["5+"]),
        (6.7, 6.9, ["7"]),
    ],
)
def test_every_visible_degree_of_seismic_intensity_has_its_name(least: float, most: float, names: list[str]) -> None:
    curve = FittedFragilityCurve("all stones", "PGV", "cm/s", 50.0, 0.5, (40.0, 60.0), 10.0, 100.0)
    level = np.geomspace(10, 100, 10)[None]
    figure = overturned_fraction_by_intensity_figure(level / 100, level, curve, np.linspace(least, most, 10)[None])
    panel = figure.axes[1]
    assert [text.get_text() for text in panel.texts] == names
    assert all(panel.get_xlim()[0] <= text.get_position()[0] <= panel.get_xlim()[1] for text in panel.texts)
    plt.close(figure)
