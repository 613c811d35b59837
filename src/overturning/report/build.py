"""All sections of the report, in their order.

To add a section, write a function from `Results` to `Section`, or None where it has nothing to say, and put it into the
list.
"""

from collections.abc import Callable
from typing import Final

from overturning.report.blocks import Report, Section
from overturning.report.results import Results
from overturning.report.sections import (
    answer,
    backwards,
    cause,
    convergence,
    criteria,
    ensemble,
    falls,
    ground,
    illustrative,
    maps,
    method,
    population,
    published,
    records,
    scene,
    space,
    survey,
)

SECTIONS: Final[tuple[Callable[[Results], Section | None], ...]] = (
    answer.answer,
    ground.ground,
    maps.maps,
    scene.scene,
    survey.surveys,
    backwards.backwards,
    published.published,
    illustrative.illustrative,
    falls.falls,
    space.follows,
    space.plane_beside,
    space.twists,
    cause.cause,
    criteria.criteria,
    population.population,
    ensemble.ensemble,
    records.records,
    records.record_by_record,
    convergence.convergence,
    method.method,
)


def build_report(results: Results) -> Report:
    """The report of a study: all sections that have something to say."""
    built = (section(results) for section in SECTIONS)
    study = results.study
    return Report(study.title or study.name, study.question, tuple(section for section in built if section is not None))
