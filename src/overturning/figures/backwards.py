"""What a survey says of the motion: its azimuth, its strength, and which motions could have been it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from overturning.arrays import FloatArray
from overturning.figures.style import FALLS, INK, SERIES, compass, labels


def posterior_figure(
    title: str,
    turned: str,
    azimuth: FloatArray,
    of_azimuths: FloatArray,
    of_sources: Mapping[str, float],
    strength: Mapping[str, tuple[FloatArray, FloatArray, FloatArray]],
) -> Figure:
    """Figure of a posterior.

    Parameters
    ----------
    title, turned : str
        Of the figure, and what the azimuth is of.
    azimuth, of_azimuths : ndarray, shape (r,)
        Azimuths, degrees, and their probability.
    of_sources : mapping of str to float
        Probability by motion; the twelve likeliest are shown.
    strength : mapping of str to (ndarray, ndarray, ndarray)
        By name of a measure with its unit: values, ascending, probability not exceeded, and the same of the prior.
    """
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=(9.5, 3.6), layout="constrained")
    width = np.radians(360 / azimuth.size)
    polar: Any = figure.add_subplot(1, 2 + len(strength), 1, projection="polar")
    compass(polar)
    polar.bar(np.radians(azimuth), of_azimuths, width=width, color=FALLS, zorder=2)
    polar.set_yticks([])
    polar.set_title(turned, fontsize=9)
    bars = figure.add_subplot(1, 2 + len(strength), 2)
    best = sorted(of_sources.items(), key=lambda item: -item[1])[:12][::-1]
    bars.barh([name for name, _ in best], [100 * share for _, share in best], color=SERIES[0])
    labels(bars, "probability, %", "")
    for place, (name, (values, below, before)) in enumerate(strength.items()):
        axes = figure.add_subplot(1, 2 + len(strength), 3 + place)
        axes.plot(values, before, color=INK, linewidth=1, linestyle=(0, (3, 1.5)), label="before the survey")
        axes.plot(values, below, color=FALLS, linewidth=1.8, label="after it")
        axes.set_xscale("log")
        axes.grid(True)
        axes.legend(fontsize=7)
        labels(axes, name, "probability not exceeded")
    figure.suptitle(title, fontsize=10)
    return figure
