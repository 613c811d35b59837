"""Labels of the lines that `overturning findings` prints."""

import importlib
import pkgutil
import typing
from collections.abc import Iterator

from overturning import findings
from overturning.findings.lines import _ENTRY_LABEL_FIELDS, _JSON_ONLY_FIELDS
from overturning.findings.values import FindingBaseClass


def all_finding_classes_of_package(base: type[FindingBaseClass] = FindingBaseClass) -> Iterator[type[FindingBaseClass]]:
    """Yield the classes derived from `base` that the package of findings defines, without those of tests."""
    for module in pkgutil.iter_modules(findings.__path__):
        importlib.import_module(f"{findings.__name__}.{module.name}")
    for derived in base.__subclasses__():
        if derived.__module__.startswith(f"{findings.__name__}."):
            yield derived
        yield from all_finding_classes_of_package(derived)


def test_fields_that_label_or_hide_lines_are_fields_of_findings() -> None:
    known = {name for one in all_finding_classes_of_package() for name in one.model_fields}
    assert {*_ENTRY_LABEL_FIELDS, *_JSON_ONLY_FIELDS} <= known


def test_entries_of_lists_of_findings_have_a_label() -> None:
    """All classes of list entries have a field for a label, except soil layers, which are numbered in their order."""
    entries = {
        entry
        for one in all_finding_classes_of_package()
        if one.model_rebuild() is not False  # resolves the names of classes that are defined later
        for field in one.model_fields.values()
        if typing.get_origin(field.annotation) in (list, tuple)
        for entry in typing.get_args(field.annotation)
        if isinstance(entry, type) and issubclass(entry, FindingBaseClass)
    }
    without_label = {one.__name__ for one in entries if not {*_ENTRY_LABEL_FIELDS} & {*one.model_fields}}
    assert without_label == {"SoilLayerSummary"}
