"""What the report says: one function for each section, listed here in their order.

To add a section, write a function from `Results` to `Section`, or None where it has nothing to say, and put it into the
list.
"""

from collections.abc import Callable
from typing import Final

from overturning.report.blocks import Report, Section
from overturning.report.results import Results
from overturning.report.sections.answer import answer
from overturning.report.sections.cause import cause
from overturning.report.sections.ensemble import ensemble
from overturning.report.sections.falls import falls
from overturning.report.sections.method import method
from overturning.report.sections.own_error import own_error
from overturning.report.sections.published import published
from overturning.report.sections.records import record_by_record, records
from overturning.report.sections.scene import scene
from overturning.report.sections.survey import surveys
from overturning.report.sections.telling import telling

SECTIONS: Final[tuple[Callable[[Results], Section | None], ...]] = (
    *(answer, scene, surveys, published, telling, falls, cause, ensemble, records, record_by_record, own_error, method),
)


def build_report(results: Results) -> Report:
    """The report of a study: all sections that have something to say."""
    built = (section(results) for section in SECTIONS)
    study = results.study
    return Report(study.title or study.name, study.question, tuple(section for section in built if section is not None))
