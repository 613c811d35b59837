"""Cases side by side: how all kernels are compiled, and how named tuples lie in the rows of an array.

A kernel keeps its cases in one flat array of numbers: a row per quantity, a lane (column) per case, so that quantity
``Q`` of lane ``j`` is ``array[Q + j]``. The equations are written for ONE case, as functions of named tuples; a loop
over the lanes loads the tuples, calls the functions and stores what comes out. LLVM makes full-width vector code of
such a loop if

- every function that it calls is compiled with `INLINE`;
- nothing branches on a case's numbers: choose (``a if c else b``) instead, and by `select` where one of the two is
  what is stored there already;
- the arrays are `aligned`: a vector that straddles two cache lines costs a fifth of the speed.

Three forms that read as well do not become vector code, or become slow: a named tuple *of arrays* (each array would be
a base of its own, which may overlap the others); choosing between two whole tuples before they are stored, or between
numbers among a tuple's own arguments; and storing under a condition (a masked store). `Access.store_unless` selects
number by number instead.
"""

import hashlib
from collections.abc import Collection
from functools import cache
from typing import Any, Final, NamedTuple, get_type_hints

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from overturning.dem.kernel.compiler import ApartCompiler, InnerCompiler, KernelCompiler
from overturning.dem.kernel.tuples import by_numbers, chosen, loads, paths_of, stores, stores_unless, zeros

OPTIONS: Final[dict[str, Any]] = {
    "fastmath": False,
    "error_model": "numpy",
    "boundscheck": False,
    "pipeline_class": KernelCompiler,
}
"""Of every jitted function: no fast-math, no contraction, so that the bits are the same everywhere."""

QUEUE: Final[dict[str, Any]] = {**OPTIONS, "nogil": True, "no_cfunc_wrapper": True}
"""Of the one that Python calls; without an entry for C."""

OWNER: Final[dict[str, Any]] = {**OPTIONS, "no_cfunc_wrapper": True, "forceinline": True}
"""Of those that a queue calls and that may make arrays; without entries for Python and C, long for named tuples."""

INNER: Final[dict[str, Any]] = {
    **OPTIONS,
    "pipeline_class": InnerCompiler,
    "no_cfunc_wrapper": True,
    "_nrt": False,
    "forceinline": False,
}
"""Of those that compiled code alone calls: they take arrays that are `borrowed`, make none, and count no references.

Numba lets a function that does not say whether it is to be inlined do as its caller: then all of a kernel is one
function, which takes twice the time to compile.
"""

APART: Final[dict[str, Any]] = {**INNER, "pipeline_class": ApartCompiler}
"""Of loops over the lanes that store nothing where another of their arrays is read or stored: none is looked for then.

Without, each loop is there twice, and looks at every call whether its arrays overlap.
"""

INLINE: Final[dict[str, Any]] = {**INNER, "forceinline": True}
"""Of those called within a loop over the lanes."""

_LINE: Final = 8
"""Numbers in a cache line, and in the widest vector."""


@njit(**OWNER)
def aligned(size: int) -> Any:
    """Zeros, as an array whose first number begins a cache line; Numba's own begin at any multiple of 32 bytes."""
    numbers = np.zeros(size + _LINE)
    skip = -(numbers.ctypes.data // 8) % _LINE
    return numbers[skip : skip + size]


def _borrowed(_: Any, value: Any) -> Any:
    """The same arrays, one or those of nested tuples, without owners: nothing counts references to them.

    Counted, their slices took a fifth of the time. Whoever borrows has to hold on to the arrays themselves.
    """

    def lent(context: Any, builder: Any, kind: Any, value: Any) -> Any:
        if isinstance(kind, types.Array):
            view = context.make_array(kind)(context, builder, value=value)
            view.meminfo, view.parent = view.meminfo.type(None), view.parent.type(None)
            return view._getvalue()
        inners: Any = kind if isinstance(kind, types.BaseTuple) else ()
        for number, inner in enumerate(inners):
            one = lent(context, builder, inner, builder.extract_value(value, number))
            value = builder.insert_value(value, one, number)
        return value

    def make(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return lent(context, builder, signature.args[0], values[0])

    return value(value), make


borrowed: Final[Any] = intrinsic(_borrowed)


def windows(size: int, first: int = 0, step: int | None = None) -> Any:
    """``window(array, k)`` for compiled code: so many numbers of a flat, borrowed array, from ``first + k * step`` on.

    The k-th of such windows without a gap where no step is given. It is a slice, but nobody looks at its bounds, which
    takes long to compile.
    """

    def window(_: Any, array: Any, k: Any) -> Any:  # noqa: ARG001
        def make(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            length, begin, apart = (context.get_constant(types.intp, n) for n in (size, first, step or size))
            view = context.make_array(signature.args[0])(context, builder, value=values[0])
            view.data = builder.gep(view.data, [builder.add(builder.mul(values[1], apart), begin)])
            view.nitems, view.shape = length, cgutils.pack_array(builder, [length])
            return view._getvalue()

        return array(array, types.intp), make

    return intrinsic(window)


def _select(_: Any, condition: Any, first: Any, second: Any) -> Any:
    """The first number where the condition holds, else the second, without a branch; as `chosen`."""

    def make(_: Any, builder: Any, __: Any, values: Any) -> Any:
        return chosen(builder, *values)

    return second(condition, first, second), make


select: Final[Any] = intrinsic(_select)


def _unknown(_: Any, number: Any) -> Any:
    def make(_: Any, builder: Any, __: Any, values: Any) -> Any:
        kind = ir.FunctionType(values[0].type, [values[0].type])
        return builder.asm(kind, "", "=r,0", [values[0]], side_effect=False)

    return number(number), make


unknown: Final[Any] = intrinsic(_unknown)
"""``unknown(n)`` returns n, hidden from LLVM: a short loop of n passes is then vectorised, not unrolled."""


class Access(NamedTuple):
    """Compiled functions that take a tuple from a lane and put it there."""

    load: Any
    """``load(array, j)`` gives the tuple of lane j;"""
    store: Any
    """``store(array, j, value)`` puts it there;"""
    store_unless: Any
    """``store_unless(array, j, keep, value)`` does where not `keep`, and else leaves the lane as it is."""


class Arithmetic(NamedTuple):
    """Compiled functions that compute with all numbers of a tuple alike."""

    zero: Any
    """``zero()`` is a tuple of zeros;"""
    plus: Any
    """``plus(a, b)`` is the sum of two tuples,"""
    minus: Any
    """``minus(a, b)`` their difference,"""
    largest: Any
    """and ``largest(a, b)`` has the larger of each two numbers."""


@cache
def arithmetic(of: type) -> Arithmetic:
    """Arithmetic of a named tuple of numbers or of further such tuples."""
    name = f"{of.__module__}.{of.__qualname__}"

    def larger(builder: Any, x: Any, y: Any) -> Any:
        return chosen(builder, builder.fcmp_ordered(">", x, y), x, y)

    return Arithmetic(
        zeros(of),
        by_numbers(of, f"plus.{name}", lambda builder, x, y: builder.fadd(x, y)),
        by_numbers(of, f"minus.{name}", lambda builder, x, y: builder.fsub(x, y)),
        by_numbers(of, f"largest.{name}", larger),
    )


class Rows:
    """Which row of an array holds which number of some named tuples.

    Parameters
    ----------
    lanes : int
        Numbers in a row.
    *tuples : type
        Named tuples of numbers or of further such tuples; their numbers get the rows in the order of the fields.

    Notes
    -----
    Rows count from the array that the functions are given: it may as well be a slice of a larger one, with the rows of
    one body or pair out of many.
    """

    def __init__(self, lanes: int, *tuples: type) -> None:
        numbers = [(of, path) for of in tuples for path in paths_of(of)]
        self.count: Final = len(numbers)
        self.size: Final = lanes * self.count
        self._rows = {number: lanes * row for row, number in enumerate(numbers)}
        self._made: dict[tuple[object, ...], Access] = {}

    def row(self, of: type, path: str) -> int:
        """Where a row begins: of the number at a path of field names, such as ``left.spring``, of one of the tuples."""
        return self._rows[of, path]

    def access(self, of: type, path: str = "", without: Collection[str] = ()) -> Access:
        """Functions that load and store a tuple.

        Parameters
        ----------
        of : type
            One of the table's tuples.
        path : str
            Path of field names to a tuple within it; the whole one where not given.
        without : collection of str
            Names of fields, at any depth, that a variant of a kernel does without: not stored, and loaded as 0.
        """
        kind, prefix = of, ""
        for name in path.split(".") if path else ():
            kind, prefix = get_type_hints(kind)[name], f"{prefix}{name}."
        inner = [inner for inner in paths_of(kind) if not set(inner.split(".")) & set(without)]
        key = (of, path, *inner)
        if key not in self._made:
            self._made[key] = self._make(of, kind, prefix, inner)
        return self._made[key]

    def _make(self, of: type, kind: type, prefix: str, inner: list[str]) -> Access:
        rows = [self._rows[of, prefix + path] if path in inner else None for path in paths_of(kind)]
        # By the rows: what has another name in the machine code is another function.
        name = f"{kind.__module__}.{kind.__qualname__}.{hashlib.sha256(str(rows).encode()).hexdigest()[:16]}"
        return Access(loads(kind, rows, name), stores(kind, rows, name), stores_unless(kind, rows, name))
