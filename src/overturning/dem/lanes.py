"""Cases side by side: how both kernels are compiled, and how named tuples lie in the rows of an array.

A kernel keeps its cases in one flat array of numbers: a row per quantity, a lane (column) per case, so that quantity ``Q`` of
lane ``j`` is ``array[Q + j]``. The equations are written for ONE case, as functions of named tuples; a loop over the lanes
loads the tuples, calls the functions and stores what comes out. LLVM makes full-width vector code of such a loop if

- every function that it calls is compiled with `INLINE`;
- nothing branches on a case's numbers: select (``a if c else b``) instead;
- the arrays are `aligned`: a vector that straddles two cache lines costs a fifth of the speed.

Three forms that read as well do not become vector code, or become slow: a named tuple *of arrays* (each array would be a base of
its own, which may overlap the others); choosing between two whole tuples before they are stored; and storing under a
condition (a masked store). `Access.store_unless` selects number by number instead.
"""

from collections.abc import Collection, Iterator
from typing import Any, Final, NamedTuple, get_type_hints

import numpy as np
from numba import njit, types
from numba.extending import intrinsic

from overturning.dem.cache import prefer_full_width

prefer_full_width()  # before anything is compiled

OPTIONS: Final[dict[str, Any]] = {"fastmath": False, "error_model": "numpy", "boundscheck": False}
"""Of every jitted function: no fast-math, no contraction, so that the bits are the same everywhere."""

INLINE: Final[dict[str, Any]] = {**OPTIONS, "forceinline": True}
"""Of those called within a loop over the lanes."""

_LINE: Final = 8
"""Numbers in a cache line, and in the widest vector."""


@njit(**OPTIONS)
def aligned(size: int) -> Any:
    """Zeros, as an array whose first number begins a cache line; Numba's own begin at any multiple of 32 bytes."""
    numbers = np.zeros(size + _LINE)
    skip = -(numbers.ctypes.data // 8) % _LINE
    return numbers[skip : skip + size]


class Access(NamedTuple):
    """Compiled functions that take a tuple from a lane and put it there."""

    load: Any
    """``load(array, j)`` gives the tuple of lane j;"""
    store: Any
    """``store(array, j, value)`` puts it there;"""
    store_unless: Any
    """``store_unless(array, j, keep, value)`` does where not `keep`, and else leaves the lane as it is."""


class Rows:
    """Which row of an array holds which number of some named tuples, of numbers or of further such tuples.

    A row has `lanes` numbers; those of the tuples get the rows in the order of the fields. Rows count from the array that
    the functions are given: it may as well be a slice of a larger one, with the rows of one body or pair out of many.
    """

    def __init__(self, lanes: int, *tuples: type) -> None:
        numbers = [(of, path) for of in tuples for path in _paths(of)]
        self.count: Final = len(numbers)
        self.size: Final = lanes * self.count
        self._rows = {number: lanes * row for row, number in enumerate(numbers)}
        self._made: dict[tuple[object, ...], Access] = {}

    def row(self, of: type, path: str) -> int:
        """Where a row begins: of the number at a path of field names, such as ``left.spring``, of one of the tuples."""
        return self._rows[of, path]

    def access(self, of: type, path: str = "", without: Collection[str] = ()) -> Access:
        """Functions that load and store one of the table's tuples, or a tuple within it at a path of field names.

        Fields `without` which a variant of a kernel does, at any depth, are not stored, and loaded as 0.
        """
        kind, prefix = of, ""
        for name in filter(None, path.split(".")):
            kind, prefix = get_type_hints(kind)[name], f"{prefix}{name}."
        inner = [inner for inner in _paths(kind) if not set(inner.split(".")) & set(without)]
        key = (of, path, *inner)
        if key not in self._made:
            self._made[key] = _access(kind, {p: self._rows[of, prefix + p] for p in inner})
        return self._made[key]


def _access(kind: Any, place: dict[str, int]) -> Access:
    """Functions for a tuple whose numbers begin at these rows: written in LLVM's language, which compiles in no time."""
    tuple_type = _numba_type(kind)

    def pointer(context: Any, builder: Any, signature: Any, values: Any, path: str) -> Any:
        """Where the number at a path lies, of the lane and array that are the first values."""
        assert signature.args[0].layout == "C", "rows lie one after another"
        data = context.make_array(signature.args[0])(context, builder, value=values[0]).data
        return builder.gep(data, [builder.add(values[1], values[1].type(place[path]))], inbounds=True)

    def make_load(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        def part(of: Any, path: str) -> Any:
            if hasattr(of, "fields"):
                parts = [part(inner, f"{path}{name}.") for name, inner in zip(of.fields, of.types, strict=True)]
                return context.make_tuple(builder, of, parts)
            if path[:-1] in place:
                return builder.load(pointer(context, builder, signature, values, path[:-1]))
            return context.get_constant(types.float64, 0.0)

        return part(tuple_type, "")

    def make_store(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        for path in place:
            number, of = values[-1], signature.args[-1]
            for name in path.split("."):
                at = of.fields.index(name)
                number, of = builder.extract_value(number, at), of.types[at]
            number = context.cast(builder, number, of, types.float64)
            to = pointer(context, builder, signature, values, path)
            if len(values) == 4:  # with a condition under which the lane keeps what it has
                number = builder.select(values[2], builder.load(to), number)
            builder.store(number, to)
        return context.get_dummy_value()

    @intrinsic
    def load(_: Any, array: Any, j: Any) -> Any:  # noqa: ARG001, an intrinsic is called with types
        return tuple_type(array, types.intp), make_load

    @intrinsic
    def store(_: Any, array: Any, j: Any, value: Any) -> Any:  # noqa: ARG001
        return types.none(array, types.intp, value), make_store

    @intrinsic
    def store_unless(_: Any, array: Any, j: Any, keep: Any, value: Any) -> Any:  # noqa: ARG001
        return types.none(array, types.intp, types.boolean, value), make_store

    return Access(load, store, store_unless)


def _numba_type(of: Any) -> Any:
    """Numba's type of a tuple of numbers and of such tuples."""
    if not hasattr(of, "_fields"):
        return types.float64
    return types.BaseTuple.from_types([_numba_type(kind) for kind in get_type_hints(of).values()], of)


def _paths(of: type, prefix: str = "") -> Iterator[str]:
    """Paths of field names to the numbers of a tuple, depth first."""
    for name, kind in get_type_hints(of).items():
        if hasattr(kind, "_fields"):
            yield from _paths(kind, f"{prefix}{name}.")
        else:
            yield prefix + name
