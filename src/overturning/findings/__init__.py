"""Findings of a study as data: numbers with intervals and units, from which reports and commands are written.

The module can be called: ``overturning.findings(path)`` is `overturning.findings.collect.findings`.
"""

import sys
from types import ModuleType
from typing import Any


class _CallableModule(ModuleType):
    """Module class that makes the module `overturning.findings` callable: a call runs its function `findings`."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        from overturning.findings.collect import findings

        return findings(*args, **kwargs)


sys.modules[__name__].__class__ = _CallableModule
