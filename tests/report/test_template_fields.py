"""Every field that a template names exists, also in sentences that no findings of the tests print."""

from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import jinja2.nodes as nodes
import pytest
from pydantic import BaseModel

from overturning.findings import contrast, direction
from overturning.findings.collect import Findings
from overturning.findings.standing import StoneSurvivalUnderHazardFindings
from overturning.findings.survey_commands import ResultsPrintedBySurveyCommands
from overturning.report.render import LANGUAGES, ReportMedia, create_template_environment
from overturning.report.write import TextsAboutReportFilm

FINDINGS_BY_PRINTED_TEMPLATE = {
    "report": Findings,
    "survey": ResultsPrintedBySurveyCommands,
    "survey_summary": ResultsPrintedBySurveyCommands,
    "displacements": ResultsPrintedBySurveyCommands,
    "motions": ResultsPrintedBySurveyCommands,
    "stood": StoneSurvivalUnderHazardFindings,
}
"""Class of the findings for each template that is rendered by itself; the others are parts of these."""


def plain_type(annotation: Any) -> Any:
    """Return a type without None and metadata; a name in quotes is looked up."""
    if isinstance(annotation, str) or hasattr(annotation, "__forward_arg__"):
        name = getattr(annotation, "__forward_arg__", annotation)
        return getattr(contrast, name, None) or getattr(direction, name)
    if get_origin(annotation) is Annotated:
        return plain_type(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return plain_type(next(one for one in get_args(annotation) if one is not type(None)))
    return annotation


def type_of_list_or_dict_entries(container: Any, of: int = 0) -> Any:
    """Return the type of the entries of a list, or of the keys (0) or values (1) of a dict; None for other types."""
    kinds = get_args(container)
    return plain_type(kinds[min(of, len(kinds) - 1)]) if kinds else None


class FieldChecker:
    """Checker that walks through a template and those that it includes, and collects fields that do not exist."""

    def __init__(self, language: str) -> None:
        self.templates = create_template_environment(language)
        self.unknown: set[str] = set()

    def check(self, name: str, types: dict[str, Any]) -> None:
        """Check a template; ``types`` maps its variables to their types, or to None if unknown."""
        assert self.templates.loader is not None
        source = self.templates.loader.get_source(self.templates, name)[0]
        self.check_template_nodes(self.templates.parse(source).body, types, name)

    def check_template_nodes(self, parts: list[Any], types: dict[str, Any], name: str) -> None:
        for part in parts:
            if isinstance(part, nodes.For):
                inner = types | {"loop": None} | self.types_of_targets(part, types, name)
                self.check_template_nodes([*([part.test] if part.test else []), *part.body], inner, name)
                self.check_template_nodes(part.else_, types, name)
            elif isinstance(part, nodes.Include):
                assert isinstance(part.template, nodes.Const)
                self.check(part.template.value, types)
            elif isinstance(part, nodes.Expr):
                self.type_of(part, types, name)
            else:
                self.check_template_nodes(list(part.iter_child_nodes()), types, name)

    def types_of_targets(self, loop: nodes.For, types: dict[str, Any], name: str) -> dict[str, Any]:
        """Return the types of the variables of a `for` loop, by name; None if unknown."""
        entry = type_of_list_or_dict_entries(self.type_of(loop.iter, types, name))
        if isinstance(loop.target, nodes.Name):
            return {loop.target.name: entry}
        assert isinstance(loop.target, nodes.Tuple)
        names = [one.name for one in loop.target.items if isinstance(one, nodes.Name)]
        return {one: type_of_list_or_dict_entries(entry, place) for place, one in enumerate(names)}

    def type_of(self, part: nodes.Node, types: dict[str, Any], name: str) -> Any:
        """Return the type of an expression, None if it is not known; note fields that do not exist."""
        if isinstance(part, nodes.Name):
            return types[part.name]
        if isinstance(part, nodes.Getattr):
            return self.find_field_type_or_note_unknown_field(self.type_of(part.node, types, name), part, name)
        found = [self.type_of(one, types, name) for one in part.iter_child_nodes()]
        if isinstance(part, nodes.Getitem):
            if isinstance(part.arg, nodes.Slice):
                return found[0]
            return type_of_list_or_dict_entries(found[0], 1 if get_origin(found[0]) is dict else 0)
        if isinstance(part, nodes.Filter) and part.name == "items":
            return list[tuple[get_args(found[0])]] if get_args(found[0]) else None  # type: ignore[misc]
        if isinstance(part, nodes.CondExpr):
            return found[1] if isinstance(part.expr1, nodes.Getattr) else None
        return list[found[0]] if isinstance(part, nodes.List) and found else None  # type: ignore[valid-type]

    def find_field_type_or_note_unknown_field(self, owner: Any, part: nodes.Getattr, name: str) -> Any:
        """Return the type of a field of an object; note it if the object has no such field."""
        if not isinstance(owner, type) or owner not in (ReportMedia, TextsAboutReportFilm):
            if not isinstance(owner, type) or not issubclass(owner, BaseModel):
                return None
            if part.attr in owner.model_fields:
                return plain_type(owner.model_fields[part.attr].annotation)
        elif part.attr == "films":
            return list[TextsAboutReportFilm]
        elif part.attr in get_type_hints(owner):
            return plain_type(get_type_hints(owner)[part.attr])
        if not hasattr(owner, part.attr):
            self.unknown.add(f"{name}, line {part.lineno}: {owner.__name__}.{part.attr}")
        return None


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(("name", "findings"), FINDINGS_BY_PRINTED_TEMPLATE.items())
def test_templates_name_only_fields_that_exist(name: str, findings: type[BaseModel], language: str) -> None:
    checker = FieldChecker(language)
    checker.check(f"{name}.md.j2", {"f": findings, "media": ReportMedia})
    assert not checker.unknown
