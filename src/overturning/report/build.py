"""All sections of the report, in their order.

To add a section, write a function that says its blocks one by one, none where it has nothing to say, name it by
`blocks.section`, and put it into the list.
"""

from collections.abc import Callable
from typing import Final

from overturning.report.blocks import Report, Section
from overturning.report.results import Results
from overturning.report.sections import (
    alignment,
    answer,
    causes,
    exactness,
    ground,
    method,
    population,
    records,
    scene,
    space,
    surveys,
)

SECTIONS: Final[tuple[Callable[[Results], Section | None], ...]] = (
    answer.answer,
    ground.ground,
    records.maps,
    scene.scene,
    surveys.surveys,
    surveys.backwards,
    causes.published,
    records.illustrative,
    alignment.falls,
    space.follows,
    space.plane_beside,
    space.twists,
    causes.cause,
    causes.criteria,
    population.population,
    exactness.ensemble,
    records.records,
    records.record_by_record,
    exactness.convergence,
    method.method,
)


def build_report(results: Results) -> Report:
    """The report of a study: all sections that have something to say."""
    built = (section(results) for section in SECTIONS)
    study = results.study
    return Report(study.title or study.name, study.question, tuple(section for section in built if section is not None))
