"""Figures of the number that answers a study's question: positions, order and intervals of values, and grey print."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from overturning.figures.answer import (
    RECORD_GROUP_COLOURS,
    PlottedEstimate,
    fall_alignment_with_reference_axes_figure,
    fault_normal_alignment_by_earthquake_figure,
    format_estimate,
    overturned_shares_and_difference_figure,
)
from overturning.figures.style import PAGE_WIDTH_INCHES, use_package_matplotlib_settings

NAN = float("nan")


def marker_positions_of_colour(axes: plt.Axes, colour: str) -> list[tuple[float, float]]:
    """Return the positions (x, row) of the markers of one colour, that of a group of records, from the top down."""
    dots = [line for line in axes.lines if line.get_color() == colour and len(line.get_xdata()) == 1]
    return sorted(((line.get_xdata()[0], line.get_ydata()[0]) for line in dots), key=lambda dot: dot[1])


def interval_positions_of_colour(axes: plt.Axes, colour: str) -> list[tuple[float, float, float]]:
    """Return the intervals (low, high, row) of one colour, that of a group of records, from the top down."""
    lines = [line for line in axes.lines if line.get_color() == colour and len(line.get_xdata()) == 2]
    return sorted(((*line.get_xdata(), line.get_ydata()[0]) for line in lines), key=lambda line: line[2])


def axes_texts(axes: plt.Axes) -> list[str]:
    return [text.get_text() for text in axes.texts]


def figure_of_sorted_fall_alignments() -> Figure:
    values = {
        "with a pulse": {"A": -0.4, "B": 0.7, "C": NAN, "D": 0.004},
        "without": {"B": -0.003, "E": 0.2},
    }
    return fault_normal_alignment_by_earthquake_figure(
        values, {"with a pulse": PlottedEstimate(0.1, -0.2, 0.4, 3), "without": PlottedEstimate(0.1, NAN, NAN, 2)}
    )


def test_alignment_figure_sorts_earthquakes_and_prints_each_value_and_the_mean() -> None:
    with use_package_matplotlib_settings():
        left, right = figure_of_sorted_fall_alignments().axes
    plt.close("all")
    assert [label.get_text() for label in left.get_yticklabels()] == ["B", "D", "A", "C", "mean"]
    assert [x for x, _ in marker_positions_of_colour(left, RECORD_GROUP_COLOURS[0])] == [0.7, 0.004, -0.4, 0.1]
    assert [(low, high) for low, high, _ in interval_positions_of_colour(left, RECORD_GROUP_COLOURS[0])] == [
        (-0.2, 0.4)
    ]
    assert axes_texts(left) == ["0.70", "0.00", "−0.40", "no alignment"]
    assert "0.10 (−0.20 to 0.40)" in left.get_title()
    assert "3 earthquakes" in left.get_title()
    assert interval_positions_of_colour(right, RECORD_GROUP_COLOURS[1]) == [], "too few earthquakes for an interval"
    assert axes_texts(right) == ["0.20", "0.00"]
    for axes in (left, right):
        ticks = dict(zip(axes.get_xticks(), (label.get_text() for label in axes.get_xticklabels()), strict=True))
        assert ["along" in ticks[-1], "neither" in ticks[0], "across" in ticks[1]] == [True] * 3


def figure_of_fall_alignment_with_reference_axes() -> Figure:
    pulse = {
        "pulse": PlottedEstimate(0.4, 0.2, 0.6, 11),
        "peak velocity": PlottedEstimate(0.56, 0.4, 0.7, 11),
        "normal": PlottedEstimate(NAN, NAN, NAN, 0),
    }
    control = {"peak velocity": PlottedEstimate(0.38, None, None, 7), "pulse": PlottedEstimate(-0.1, -0.3, 0.1, 7)}
    return fall_alignment_with_reference_axes_figure({"with": pulse, "without": control})


def test_alignments_with_reference_directions_are_dots_with_intervals() -> None:
    """Each reference direction has a row, in the order of the first group; an unknown alignment has a note, no dot."""
    with use_package_matplotlib_settings():
        figure = figure_of_fall_alignment_with_reference_axes()
    (axes,) = figure.axes
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    plt.close("all")
    assert [label.get_text() for label in axes.get_yticklabels()] == ["peak velocity", "pulse", "normal"]
    assert [x for x, _ in marker_positions_of_colour(axes, RECORD_GROUP_COLOURS[0])] == [0.56, 0.4]
    assert [x for x, _ in marker_positions_of_colour(axes, RECORD_GROUP_COLOURS[1])] == [0.38, -0.1]
    assert [(low, high) for low, high, _ in interval_positions_of_colour(axes, RECORD_GROUP_COLOURS[0])] == [
        (0.4, 0.7),
        (0.2, 0.6),
    ]
    assert [(low, high) for low, high, _ in interval_positions_of_colour(axes, RECORD_GROUP_COLOURS[1])] == [
        (-0.3, 0.1)
    ]
    rows = [row for _, row in marker_positions_of_colour(axes, RECORD_GROUP_COLOURS[0])]
    assert np.round(rows).tolist() == [0, 1]
    printed = {"0.56 (0.40 to 0.70)", "0.40 (0.20 to 0.60)", "0.38", "−0.10 (−0.30 to 0.10)", "not known"}
    assert set(axes_texts(axes)) == printed
    assert legend == ["with, 11 earthquakes", "without, 7 earthquakes"]
    assert (axes.get_xlim()[0] <= -1, axes.get_xlim()[1] >= 1) == (True, True)


def figure_of_two_overturned_shares() -> Figure:
    one, other = (
        [PlottedEstimate(0.663), PlottedEstimate(1.0, 0.9, 1.0)],
        [PlottedEstimate(0.669), PlottedEstimate(0.9, 0.8, 0.95)],
    )
    rows = ["all cases", "B/H 0.1"]
    return overturned_shares_and_difference_figure(
        rows, {"with": one, "without": other}, [PlottedEstimate(-0.006), PlottedEstimate(0.1, 0.02, 0.15)]
    )


def test_figure_of_two_settings_shows_overturned_shares_and_their_difference() -> None:
    with use_package_matplotlib_settings():
        left, right = figure_of_two_overturned_shares().axes
    plt.close("all")
    assert [x for x, _ in marker_positions_of_colour(left, RECORD_GROUP_COLOURS[0])] == pytest.approx([66.3, 100.0])
    assert [x for x, _ in marker_positions_of_colour(left, RECORD_GROUP_COLOURS[1])] == pytest.approx([66.9, 90.0])
    assert interval_positions_of_colour(left, RECORD_GROUP_COLOURS[1])[0][:2] == pytest.approx((80.0, 95.0))
    assert axes_texts(left) == ["66.3", "100.0", "66.9", "90.0"]
    assert axes_texts(right) == ["−0.6", "10.0 (2.0 to 15.0)"]
    low, high = right.get_xlim()
    assert (low, high) == (-high, high)
    assert high >= 15.0


@pytest.mark.parametrize(
    "draw",
    [figure_of_sorted_fall_alignments, figure_of_fall_alignment_with_reference_axes, figure_of_two_overturned_shares],
)
def test_letters_of_answer_figures_have_at_least_7_points_at_printed_width(draw: object) -> None:
    with use_package_matplotlib_settings():
        figure = draw()  # type: ignore[operator]
    sizes = [text.get_fontsize() for text in figure.findobj(Text) if text.get_text() and text.get_visible()]
    plt.close("all")
    assert figure.get_figwidth() <= PAGE_WIDTH_INCHES
    assert min(sizes) >= 7.0


def test_text_of_an_estimate_contains_its_interval() -> None:
    assert format_estimate(PlottedEstimate(-0.004, -0.2, 0.1)) == "0.00 (−0.20 to 0.10)"
    assert format_estimate(PlottedEstimate(0.5, None, None)) == "0.50"
    assert format_estimate(PlottedEstimate(None)) == "not known"
