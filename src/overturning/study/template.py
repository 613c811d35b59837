"""The text of a new study: what is most often changed, each line with what it means."""

from collections.abc import Sequence

_TEXT = """\
# Every key is explained in config/README.md.
name: {name} # of the folder under results/
title: {title}
question: Which way do gravestones fall?
records: {{use: [{records}]}} # ids of config/records.tsv
azimuth: {{step: {step:g}}} # degrees; a divisor of 360
b_over_h: {{start: 0.1, stop: 0.6, step: 0.1}} # width over height
height: [0.6] # m
friction: [0.58, 1.0]
"""


def study_template(name: str, records: Sequence[str], title: str = "", step: float = 15.0) -> str:
    """A study file of these records, whose name may be any; it is checked when it is read."""
    return _TEXT.format(name=name, title=title or name, records=", ".join(records), step=step)
