"""Names that Numba, Matplotlib and xarray do not document: each use has a reason, and a test that guards it.

A release of these libraries may change such a name without notice. Numba's are the most, so pyproject.toml has an
upper bound for it; raise the bound when the guards pass with a new release.
"""

import ast
import re
import tomllib
from pathlib import Path
from typing import TypeGuard

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "overturning"

LIBRARIES = ("numba", "llvmlite", "matplotlib", "xarray")
DOCUMENTED_MODULES = {
    "numba",
    "numba.extending",
    "numba.types",
    "numba.typed",
    "llvmlite",
    "llvmlite.binding",
    "llvmlite.ir",
    "xarray",
}
"""Modules of Numba, llvmlite and xarray with documented names; those of Matplotlib are all that have no underscore."""

NAMED_TUPLE_MEMBERS = {"_fields", "_replace", "_asdict", "_make"}
"""Documented names of Python's named tuples."""

DAMAGED_CACHE_FILE_TEST_NODE_ID = "tests/dem/test_cache.py::test_a_damaged_cache_file_is_a_cache_miss"
COMPILER_SETTINGS_TEST_NODE_ID = (
    "tests/dem/test_cache.py::test_importing_the_package_changes_no_setting_of_numba_or_llvm"
)
ID_OF_TEST_OF_STORING_TUPLES_IN_LANES = (
    "tests/dem/test_lanes.py::test_store_unless_writes_neither_if_true_nor_omitted_fields"
)
VECTORISATION_TEST_NODE_ID = (
    "tests/dem/test_vector_code.py::test_small_loops_are_fully_vectorised_without_fused_multiply_add"
)

USED_PRIVATE_NAMES_BY_FILE: dict[str, dict[tuple[str, ...], tuple[str, str]]] = {
    "arrays.py": {
        ("xarray.namedarray", "_cached_duck_array_modules"): (
            "xarray imports dask (0.3 s) to learn that an array is none of dask's; without the table it still does",
            "tests/study/test_gather.py::test_dask_is_imported_only_when_a_cube_is_read_in_chunks",
        ),
    },
    "kernel_cache.py": {
        ("numba.core.runtime",): (
            "reference counts must be initialised before a kernel is loaded",
            DAMAGED_CACHE_FILE_TEST_NODE_ID,
        ),
        ("_cache", "_cache_file", "_cache_path", "_impl", "_load_overload", "load_overload", "save_overload"): (
            "the cache's folder is named after all sources, and a kernel that cannot be loaded is compiled again",
            DAMAGED_CACHE_FILE_TEST_NODE_ID,
        ),
        ("_source_stamp", "_index_path", "_data_path", "_data_name_pattern", "get_cache_path"): (
            "one index per model, and a stamp of the contents in place of the file's time",
            "tests/dem/test_cache.py::test_kernel_variants_compiled_by_different_processes_are_not_confused",
        ),
        ("_dump", "_load_index", "_load_data"): (
            "damaged machine code must not run: files end with a digest",
            DAMAGED_CACHE_FILE_TEST_NODE_ID,
        ),
    },
    "dem/kernel/compiler.py": {
        ("numba.core.compiler", "numba.core.compiler_machinery", "numba.core.typed_passes"): (
            "a pipeline of our own, as Numba documents for pipeline_class, though its classes lie in numba.core",
            COMPILER_SETTINGS_TEST_NODE_ID,
        ),
        ("numba.core.lowering",): (
            "an aligned stack, and no entry for Python in functions that only compiled code calls",
            "tests/dem/test_cache.py::test_an_inner_kernel_function_can_be_called_by_compiled_code_only",
        ),
        ("numba.core.codegen", "numba.core.registry"): (
            "no machine code for inner functions, which their callers contain (a quarter of the compilation)",
            "tests/dem/test_cache.py::test_an_inner_kernel_function_can_be_called_by_compiled_code_only",
        ),
        ("_pass_builder",): (
            "passes of LLVM over a whole kernel: arguments that no function uses are removed (up to a tenth of a step)",
            "tests/dem/test_vector_code.py::test_loops_of_a_kernel_get_no_arguments_that_they_do_not_use",
        ),
        ("_name",): ("the name that Numba requires of a pass", COMPILER_SETTINGS_TEST_NODE_ID),
    },
    "dem/kernel/lanes.py": {
        ("numba.core", "_getvalue"): (
            "views of arrays without owner and without bounds checks",
            VECTORISATION_TEST_NODE_ID,
        ),
        ("_nrt",): (
            "no reference counts in inner functions, which would keep loops from being vector code",
            VECTORISATION_TEST_NODE_ID,
        ),
    },
    "dem/kernel/tuples.py": {
        ("numba.core", "numba.core.errors"): (
            "named tuples are loaded and stored by generated LLVM code",
            ID_OF_TEST_OF_STORING_TUPLES_IN_LANES,
        ),
        ("llvmlite.ir.instructions", "_insert"): (
            "llvmlite's builder has no method for freeze",
            ID_OF_TEST_OF_STORING_TUPLES_IN_LANES,
        ),
    },
    "figures/style.py": {
        ("_repr_png_",): (
            "documented by IPython: a notebook shows a figure with it",
            "tests/test_python.py::test_each_cube_figure_is_drawn_without_changing_matplotlib_settings",
        ),
    },
    "figures/write.py": {
        ("draw",): (
            "the layout is computed without the drawing that Matplotlib discards (half of the time)",
            "tests/figures/test_svg.py::test_compact_svg_looks_the_same",
        ),
    },
}
"""By file: names, the reason for their use, and the test that fails if they no longer have the same meaning."""


def private_library_names_used_in(source: str, own_private_names: frozenset[str]) -> set[str]:
    """Return the undocumented names of Numba, llvmlite, Matplotlib and xarray that a source text uses.

    These are undocumented modules, names and strings that begin with an underscore, and methods that are replaced on
    an object. Attributes, keywords and strings in `own_private_names`, those of this package, are left out.
    """
    if not re.search(rf"^\s*(from|import) ({'|'.join(LIBRARIES)})\b", source, re.MULTILINE):
        return set()
    nodes = list(ast.walk(ast.parse(source)))
    functions = {node.name for node in nodes if isinstance(node, ast.FunctionDef)}
    of_package = {alias.name for one in nodes if _is_import_from_overturning(one) for alias in one.names}
    found: set[str] = set()
    for node in nodes:
        if isinstance(node, ast.Import | ast.ImportFrom):
            found |= _private_or_undocumented_names_in_import(node)
        elif isinstance(node, ast.Attribute) and not _is_self_or_cls(node.value):
            found |= {node.attr} if _is_private(node.attr) and node.attr not in own_private_names else set()
        elif isinstance(node, ast.ClassDef) and node.bases:
            members = (name for one in node.body if isinstance(one, ast.Assign) for name in one.targets)
            found |= {one.id for one in members if isinstance(one, ast.Name) and _is_private(one.id)}
        elif isinstance(node, ast.Assign):
            found |= _library_attributes_replaced_by_functions(node, functions, of_package)
        elif isinstance(node, ast.Call | ast.Dict):
            found |= {
                name for name in _names_in_getattr_keywords_and_dict_keys(node) if _is_private(name)
            } - own_private_names
    return found


def _private_or_undocumented_names_in_import(node: ast.Import | ast.ImportFrom) -> set[str]:
    """Return the undocumented library modules and underscored names that an import statement names.

    The underscored names are those imported from a library that begin with an underscore.
    """
    modules = [node.module or ""] if isinstance(node, ast.ImportFrom) else [alias.name for alias in node.names]
    ours = [name for name in modules if name.split(".")[0] in LIBRARIES]
    found = {name for name in ours if not _is_documented_library_module(name)}
    if ours and isinstance(node, ast.ImportFrom):
        found |= {alias.name for alias in node.names if alias.name.startswith("_")}
    return found


def _names_in_getattr_keywords_and_dict_keys(node: ast.AST) -> list[str]:
    """Return the keywords of a call and the name that it passes to `getattr` or the like, or the keys of a dict."""
    texts: list[ast.expr | None] = []
    keywords: list[str | None] = []
    if isinstance(node, ast.Call):
        keywords = [one.arg for one in node.keywords]
        if isinstance(node.func, ast.Name) and node.func.id in ("getattr", "hasattr", "setattr", "delattr"):
            texts += node.args[1:2]
    elif isinstance(node, ast.Dict):
        texts += node.keys
    constants = [one.value for one in texts if isinstance(one, ast.Constant)]
    return [name for name in (*keywords, *constants) if isinstance(name, str)]


def _is_documented_library_module(module: str) -> bool:
    """True if a module of a library belongs to its documented interface."""
    return module in DOCUMENTED_MODULES or (module.startswith("matplotlib") and "._" not in module)


def _is_private(name: str) -> bool:
    """True if a name begins with one underscore and is no documented method of named tuples."""
    return bool(re.fullmatch(r"_[a-z]\w*", name)) and name not in NAMED_TUPLE_MEMBERS


def _is_self_or_cls(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and node.id in ("self", "cls")


def _is_import_from_overturning(node: ast.AST) -> TypeGuard[ast.ImportFrom]:
    return isinstance(node, ast.ImportFrom) and (node.module or "").startswith("overturning")


def _library_attributes_replaced_by_functions(node: ast.Assign, functions: set[str], of_package: set[str]) -> set[str]:
    """Return attributes of other libraries' objects to which a function of this module or a lambda is assigned."""
    found = set()
    for target in node.targets:
        targets, values = (one.elts if isinstance(one, ast.Tuple) else [one] for one in (target, node.value))
        for to, value in zip(targets, values, strict=False):
            is_function = isinstance(value, ast.Lambda) or (isinstance(value, ast.Name) and value.id in functions)
            other = (
                isinstance(to, ast.Attribute)
                and not _is_self_or_cls(to.value)
                and ast.unparse(to.value) not in of_package
            )
            if is_function and isinstance(to, ast.Attribute) and other:
                found.add(to.attr)
    return found


def private_names_defined_in(source: str) -> set[str]:
    """Return the private names that a module defines: functions, classes, and attributes of self."""
    return set(re.findall(r"(?:\b(?:def|class) |\bself\.)(_[a-z]\w*)", source))


def test_each_used_private_library_name_has_a_listed_reason_and_test() -> None:
    sources = {path.relative_to(PACKAGE).as_posix(): path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    own = frozenset(name for source in sources.values() for name in private_names_defined_in(source))
    found = {name: used for name, source in sources.items() if (used := private_library_names_used_in(source, own))}
    listed = {name: {one for names in groups for one in names} for name, groups in USED_PRIVATE_NAMES_BY_FILE.items()}
    assert found == listed, (
        "a private name is new, or no longer used: list it in USED_PRIVATE_NAMES_BY_FILE with its reason and its guard"
    )


@pytest.mark.parametrize(
    "guard", sorted({guard for groups in USED_PRIVATE_NAMES_BY_FILE.values() for _, guard in groups.values()})
)
def test_the_test_listed_for_each_private_library_name_exists(guard: str) -> None:
    path, name = guard.split("::")
    text = (ROOT / path).read_text(encoding="utf-8")
    assert re.search(rf"^def {name}\(", text, re.MULTILINE), (
        "a guard was renamed or removed: change USED_PRIVATE_NAMES_BY_FILE"
    )


@pytest.mark.parametrize(
    ("line", "names"),
    [
        ("from numba.core import types", {"numba.core"}),
        ("from matplotlib import _api", {"_api"}),
        ("import matplotlib._layoutgrid", {"matplotlib._layoutgrid"}),
        ("import xarray as xr\nxr.Dataset()._construct_dataarray", {"_construct_dataarray"}),
        ("import xarray as xr\ngetattr(xr, '_table')", {"_table"}),
        ("from matplotlib.figure import Figure\nfigure = Figure()\nfigure.draw = lambda renderer: None", {"draw"}),
        ("import numba\nclass Own(numba.Base):\n    _kind = 1", {"_kind"}),
        ("from numba import njit\nfrom matplotlib.figure import Figure\nnjit(lambda x: x)._fields", set()),
    ],
)
def test_a_private_library_name_in_a_source_is_detected(line: str, names: set[str]) -> None:
    assert private_library_names_used_in(line, frozenset()) == names


def test_the_numba_requirement_has_an_upper_bound() -> None:
    dependencies = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    (bound,) = (one for one in dependencies if one.startswith("numba"))
    assert "<" in bound
