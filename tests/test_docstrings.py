"""Names in docstrings: each parameter, attribute, class and module that a docstring names exists."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "overturning"
PYTHON_FILES = sorted(
    path
    for folder in (PACKAGE, ROOT / "verification", ROOT / "tests")
    for path in folder.rglob("*.py")
    if "__pycache__" not in path.parts
)
NUMPYDOC_SECTION = r"^{}\n-+\n(.*?)(?=^\S[^\n]*\n-{{3,}}\n|\Z)"


def names_listed_in_section(docstring: str, section_title: str) -> list[str]:
    """Return the names that a numpydoc section such as Parameters lists, without asterisks."""
    section = re.search(NUMPYDOC_SECTION.format(section_title), docstring, re.MULTILINE | re.DOTALL)
    entries = re.findall(r"^([*\w][*\w, ]*?)(?: : .*)?$", section[1] if section else "", re.MULTILINE)
    return [name.strip().lstrip("*") for entry in entries for name in entry.split(",")]


def parameter_names(function: ast.FunctionDef) -> set[str]:
    """Return the names of all parameters of a function, with those of its starred parameters."""
    arguments = function.args
    starred = [one for one in (arguments.vararg, arguments.kwarg) if one is not None]
    return {one.arg for one in [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs, *starred]}


def names_defined_in_class(node: ast.ClassDef) -> set[str]:
    """Return the names of fields, methods and attributes that a class defines, in its body or in its methods."""
    found: set[str] = set()
    for one in ast.walk(node):
        if isinstance(one, ast.FunctionDef):
            found.add(one.name)
        targets = one.targets if isinstance(one, ast.Assign) else [one.target] if isinstance(one, ast.AnnAssign) else []
        for target in targets:
            found |= {target.id} if isinstance(target, ast.Name) else set()
            found |= {target.attr} if isinstance(target, ast.Attribute) else set()
    return found


def classes_of_file(path: Path) -> Iterator[ast.ClassDef]:
    """Yield the classes of a Python file, nested ones too."""
    yield from (one for one in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(one, ast.ClassDef))


def module_file(parts: list[str]) -> Path:
    """Return the path of a module of the package, given by the parts of its name."""
    base = PACKAGE.parent.joinpath(*parts)
    return base / "__init__.py" if base.is_dir() else base.with_suffix(".py")


def names_defined_imported_or_quoted_in_module(parts: list[str]) -> set[str]:
    """Return the names that a module defines, imports or uses, and its strings, which can name lazy imports."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(module_file(parts).read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        if isinstance(node, ast.Import | ast.ImportFrom):
            found |= {one.asname or one.name for one in node.names}
        if isinstance(node, ast.Name):
            found.add(node.id)
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.add(node.value)
    return found


@pytest.fixture(scope="module")
def own_and_inherited_names_by_class() -> dict[str, set[str]]:
    """Names that each class of the project has, by class name; those of its bases in the project are included."""
    own: dict[str, set[str]] = {}
    bases: dict[str, set[str]] = {}
    for path in PYTHON_FILES:
        for node in classes_of_file(path):
            own[node.name] = own.get(node.name, set()) | names_defined_in_class(node)
            bases.setdefault(node.name, set()).update(ast.unparse(base).split("[")[0] for base in node.bases)

    def names_with_bases(name: str) -> set[str]:
        """Return the names of a class of the project and of all its bases in the project."""
        return own[name].union(*(names_with_bases(base) for base in bases[name] if base in own and base != name))

    return {name: names_with_bases(name) for name in own}


def test_sections_of_docstrings_list_existing_parameters_and_attributes(own_and_inherited_names_by_class):
    wrong = []
    for path in PYTHON_FILES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.FunctionDef | ast.ClassDef):
                continue
            text = ast.get_docstring(node) or ""
            listed = names_listed_in_section(text, "Parameters") + names_listed_in_section(text, "Attributes")
            known = (
                parameter_names(node)
                if isinstance(node, ast.FunctionDef)
                else set(own_and_inherited_names_by_class[node.name])
            )
            for one in node.body:
                known |= parameter_names(one) if isinstance(one, ast.FunctionDef) and one.name == "__init__" else set()
            wrong += [f"{path.relative_to(ROOT)}, {node.name}: {name}" for name in listed if name not in known]
    assert wrong == []


def test_attributes_that_docstrings_name_with_their_class_exist(own_and_inherited_names_by_class):
    wrong = []
    for path in PYTHON_FILES:
        mentions = re.findall(r"`(?:[\w.]+\.)?([A-Z]\w+)\.(\w+)(?:\(\))?`", path.read_text(encoding="utf-8"))
        wrong += [
            f"{path.relative_to(ROOT)}: {of}.{name}"
            for of, name in mentions
            if of in own_and_inherited_names_by_class and name not in own_and_inherited_names_by_class[of]
        ]
    assert wrong == []


def test_modules_and_their_contents_that_docstrings_name_exist():
    wrong = []
    for path in PYTHON_FILES:
        for mention in re.findall(r"`(overturning(?:\.\w+)+)(?:\(\))?`", path.read_text(encoding="utf-8")):
            parts = mention.split(".")
            length = max(count for count in range(1, len(parts) + 1) if module_file(parts[:count]).is_file())
            if length < len(parts) and parts[length] not in names_defined_imported_or_quoted_in_module(parts[:length]):
                wrong.append(f"{path.relative_to(ROOT)}: {mention}")
    assert wrong == []
