"""Templates hold sentences only, and those of all languages have the same parts."""

from functools import cache
from importlib import resources
from pathlib import Path

import jinja2
import jinja2.nodes
import pytest
from jinja2 import meta

from overturning.report.render import LANGUAGES, create_template_environment

ALLOWED_TEMPLATE_NODES = (
    *("Template", "Output", "TemplateData", "Name", "Getattr", "Getitem", "Const", "List", "Slice", "If", "For"),
    *("Include", "Filter", "Test", "Compare", "Operand", "And", "Or", "Not", "CondExpr", "Neg", "Keyword", "Tuple"),
)
"""Nodes of a template: text, values, filters, `if` and `for`; neither arithmetic nor assignments nor macros."""


def languages_and_paths_of_templates() -> list[tuple[str, Path]]:
    """Return language and path of each report template."""
    folder = Path(str(resources.files("overturning"))) / "report" / "templates"
    return [(language, path) for language in LANGUAGES for path in sorted((folder / language).glob("*.j2"))]


@cache
def parse_template(language: str, path: Path) -> jinja2.nodes.Template:
    return create_template_environment(language).parse(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("language", "path"), languages_and_paths_of_templates(), ids=lambda one: getattr(one, "stem", one)
)
def test_templates_have_no_arithmetic_and_no_logic_beyond_if_and_for(language: str, path: Path) -> None:
    tree = parse_template(language, path)
    assert {type(node).__name__ for node in tree.find_all(jinja2.nodes.Node)} <= set(ALLOWED_TEMPLATE_NODES)
    assert meta.find_undeclared_variables(tree) <= {"f", "media", "one", "strength", "survey"}


def directly_included_templates(language: str, name: str) -> set[str]:
    """Return the names of the templates that a template includes, without the macros of its language."""
    found = meta.find_referenced_templates(
        parse_template(language, dict(template_names_and_paths_of_language(language))[name])
    )
    return {str(one) for one in found} - {"to.md.j2"}


def template_names_and_paths_of_language(language: str) -> list[tuple[str, Path]]:
    """Return name and path of each template of a language."""
    return [(path.name, path) for one, path in languages_and_paths_of_templates() if one == language]


def test_templates_of_all_languages_include_the_same_parts() -> None:
    names = [[name for name, _ in template_names_and_paths_of_language(language)] for language in LANGUAGES]
    assert all(one == names[0] for one in names)
    for name in names[0]:
        found = {language: directly_included_templates(language, name) for language in LANGUAGES}
        assert all(one == found["en"] for one in found.values()), name
