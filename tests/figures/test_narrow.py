"""Figures for a phone: panels below each other, letters as large as on a page."""

import pytest

from overturning.figures.answer import PlottedEstimate, overturned_share_contrast_figure
from overturning.figures.style import NARROW_WIDTH, narrow_figures, project_style


@pytest.mark.parametrize("narrow", [False, True])
def test_panels_stand_below_each_other_on_a_phone_only(narrow: bool) -> None:
    shares = {"here": [PlottedEstimate(0.4, 0.2, 0.6)], "there": [PlottedEstimate(0.1, 0.0, 0.2)]}
    arguments = ["all cases"], shares, [PlottedEstimate(0.3, 0.2, 0.4)]
    with project_style():
        if narrow:
            with narrow_figures():
                figure = overturned_share_contrast_figure(*arguments)
        else:
            figure = overturned_share_contrast_figure(*arguments)
        figure.draw_without_rendering()
    left, right = (axes.get_position() for axes in figure.axes)
    assert bool(right.y1 < left.y0) is narrow
    assert bool(right.x0 > left.x1) is not narrow
    # 366 CSS pixels of a phone of 390; the smallest letter has 7.5 pt.
    assert bool(7.5 * 366 / (72 * figure.get_figwidth()) >= 11) is narrow
    assert bool(figure.get_figwidth() == NARROW_WIDTH) is narrow
