"""A small study with a convergence check."""

from overturning.study.load import check_study
from overturning.study.schema import Study


def study(**more: object) -> Study:
    base = {
        "name": "small", "records": {"use": ["a", "b"]}, "azimuth": {"step": 60}, "b_over_h": [0.2, 0.3, 0.4],
        "height": [0.6], "friction": [0.58], "verification": {"at_least": 10},
    }  # fmt: skip
    return check_study(base | more, "small")
