"""How a kernel is compiled in less time: what Numba does that no kernel needs is left out (docs/design-notes.md)."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from types import BuiltinFunctionType, SimpleNamespace
from typing import Any, ClassVar, Final

import llvmlite.binding as llvm
import numba
from llvmlite.binding import Linkage
from numba.core import errors, event
from numba.core.codegen import JITCodeLibrary
from numba.core.postproc import PostProcessor, VariableLifetime
from numba.core.transforms import canonicalize_cfg
from numba.core.typed_passes import NopythonRewrites
from numba.core.types.functions import BaseFunction
from numba.core.typing.context import BaseContext

KNOWN: Final = "0.68."
"""Version of Numba whose inner workings are changed here; another compiles as it always does, which takes longer."""

_SMALL = 100
"""Instructions of a function that is linked into its callers at once, where LLVM may inline it."""

STACK: Final = 64
"""Bytes at a multiple of which the stack of each function begins: a cache line, the widest vector."""


def _inlined(function: Any) -> bool:
    """Whether LLVM puts a function into all that call it."""
    return any(b"alwaysinline" in attributes for attributes in function.attributes)


class _Linked(JITCodeLibrary):
    """Code of a function; that which Python cannot call is linked into its callers, and gets no machine code itself.

    What is large and not to be inlined is linked in last, by what Python calls: every caller on the way there would
    optimise it again.
    """

    _last: tuple["_Linked", ...] = ()
    _among_its_own: ClassVar[bool] = False

    @cached_property
    def has_entry(self) -> bool:
        return any(function.name.startswith("_ZN7cpython") for function in self._of_its_own())

    @cached_property
    def _waits(self) -> bool:
        own = list(self._of_its_own())
        if self.has_entry or any(map(_inlined, own)):
            return False
        instructions = (one for function in own for block in function.blocks for one in block.instructions)
        return any(number == _SMALL for number, _ in enumerate(instructions))

    def _of_its_own(self) -> Iterator[Any]:
        return (
            one for one in self._final_module.functions if one.linkage == Linkage.external and not one.is_declaration
        )

    def finalize(self) -> None:
        called = [library for library in self._linking_libraries if isinstance(library, _Linked)]
        last = [one for library in called for one in (*library._last, *([library] if library._waits else ()))]
        self._last = tuple(dict.fromkeys(last))
        self._linking_libraries = [library for library in self._linking_libraries if library not in self._last]
        before, _Linked._among_its_own = _Linked._among_its_own, True
        try:
            super().finalize()
        finally:
            _Linked._among_its_own = before

    def _get_module_for_linking(self) -> Any:
        own = super()._get_module_for_linking()
        if _Linked._among_its_own or self.has_entry or not self._last:
            return own
        # For a function compiled in another way, by a test, which links in nothing last.
        return self._with_last(own.clone())

    def _with_last(self, module: Any) -> Any:
        # Callers first: of what nobody calls yet a definition that others may have, too, is left out.
        for library in reversed(self._last):
            module.link_in(super(_Linked, library)._get_module_for_linking(), preserve=True)
        return module

    def _optimize_functions(self, ll_module: Any) -> None:
        if all(_inlined(one) for one in ll_module.functions if not one.is_declaration):
            ll_module.data_layout = self._codegen._data_layout  # and no passes: its callers have theirs
        else:
            super()._optimize_functions(ll_module)

    def _optimize_final_module(self) -> None:
        super()._optimize_final_module()
        if not self.has_entry or not self._last:
            return
        self._with_last(self._final_module)
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.linkonce_odr:
                function.linkage = "private"  # with other arguments, nobody else may find it by its name
        # Of an array most functions use the address of its numbers alone, out of seven arguments.
        passes = llvm.create_new_module_pass_manager()
        passes.add_ipsccp_pass()
        passes.add_dead_arg_elimination_pass()
        passes.add_global_opt_pass()
        passes.run(self._final_module, self._codegen._pass_builder())

    def _finalize_final_module(self) -> None:
        if self.has_entry:
            super()._finalize_final_module()
        else:
            self._finalize_dynamic_globals()
            self._finalized = True


_PLAIN = SimpleNamespace(**dict.fromkeys(("code", "errmsg", "filename", "indicate", "highlight", "reset"), str))
"""In place of colours in messages: most say which operators do not fit, and are thrown away."""

_call_type, _value_type = BaseFunction.get_call_type, BaseContext.resolve_value_type


def _known_call_type(self: Any, context: Any, given: Any, named: Any) -> Any:
    """Signature of a call, as of `_call_type`, which goes through all forms of an operator each time."""
    known, key = vars(self).setdefault("_known", {}), (given, *dict(named).items())
    if key not in known:
        known[key] = _call_type(self, context, given, named)
    return known[key]


def _known_value_type(self: Any, value: Any) -> Any:
    """Type of a global, as of `_value_type`, which first words at length that an operator is no number."""
    return (isinstance(value, BuiltinFunctionType) and self._get_global_type(value)) or _value_type(self, value)


def _processed(self: Any, emit_dels: bool = False, extend_lifetimes: bool = False) -> None:
    """Tidy up a function after each pass, as of `PostProcessor.run`, but look for what lives where once, at the end."""
    self.func_ir.blocks = canonicalize_cfg(self.func_ir.blocks)
    self.func_ir.variable_lifetime = VariableLifetime(self.func_ir.blocks)
    self.func_ir.generator_info = None
    if emit_dels:
        self._insert_var_dels(extend_lifetimes=extend_lifetimes)


@contextmanager
def without_unused_work(context: Any) -> Iterator[None]:
    """Compile what `INNER` functions do for their callers alone, and without what Numba does beside it.

    The machine code of these functions took an eighth of the time, the rest as much again.
    """
    if not numba.__version__.startswith(KNOWN):
        yield
        return
    executable = context.get_executable

    def executable_of(library: Any, description: Any, environment: Any) -> Any:
        return executable(library, description, environment) if library.has_entry else object()

    declare = context.declare_function

    def declare_aligned(module: Any, description: Any) -> Any:
        # Vectors that find no register lie on the stack, which by itself begins at 16 bytes: across two cache lines.
        function = declare(module, description)
        function.attributes.alignstack = STACK
        function.attributes.add("nounwind")  # llvmlite writes no alignment alone
        return function

    changed: list[tuple[Any, str, Any]] = [
        (context.codegen(), "_library_class", _Linked),
        (context, "get_executable", executable_of),
        (context, "create_cfunc_wrapper", lambda *_: None),
        (context, "declare_function", declare_aligned),
        (errors, "_termcolor_inst", _PLAIN),
        (event, "broadcast", lambda _: None),
        (BaseFunction, "get_call_type", _known_call_type),
        (BaseContext, "resolve_value_type", _known_value_type),
        (PostProcessor, "run", _processed),
        (NopythonRewrites, "run_pass", lambda *_: False),
    ]
    usual = [getattr(owner, name) for owner, name, _ in changed]
    collects = gc.isenabled()
    gc.disable()  # what is compiled is many objects in use: looking for others took a tenth of the time
    try:
        for owner, name, ours in changed:
            setattr(owner, name, ours)
        yield
    finally:
        for (owner, name, _), theirs in zip(changed, usual, strict=True):
            setattr(owner, name, theirs)
        if collects:
            gc.enable()
