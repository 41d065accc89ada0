"""Views of flat arrays in kernels: slices and `reshape` take numba several times as long to compile.

Nothing is checked: start and stop, or the plane, lie within the array.
"""

from typing import Any

from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np import arrayobj

make_array: Any = arrayobj.make_array
pack_array: Any = cgutils.pack_array
populate_array: Any = arrayobj.populate_array


def _part(context: Any, flat: Any, start: Any, stop: Any) -> Any:
    """The points start … stop − 1 of a flat array."""

    def build(compiler: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return view(compiler, builder, flat, arguments[0], arguments[1], [builder.sub(arguments[2], arguments[1])])

    return flat(flat, types.intp, types.intp), build


def _plane(context: Any, flat: Any, table: Any, row: Any) -> Any:
    """The plane in a flat array that a row of a table names: its start, rows and columns."""
    plane = types.Array(flat.dtype, 2, "C")

    def build(compiler: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        numbers = make_array(table)(compiler, builder, arguments[1]).data
        first = builder.mul(arguments[2], cgutils.intp_t(3))
        start, *shape = (builder.load(builder.gep(numbers, [builder.add(first, cgutils.intp_t(k))])) for k in range(3))
        return view(compiler, builder, plane, arguments[0], start, shape)

    return plane(flat, table, types.intp), build


def view(compiler: Any, builder: Any, kind: Any, flat: Any, start: Any, shape: list[Any]) -> Any:
    """Build an array of this shape that begins at a point of a flat one."""
    source = make_array(types.Array(kind.dtype, 1, "C"))(compiler, builder, flat)
    result, size = make_array(kind)(compiler, builder), source.itemsize
    strides = [size] if len(shape) == 1 else [builder.mul(shape[1], size), size]
    data, shape, strides = builder.gep(source.data, [start]), pack_array(builder, shape), pack_array(builder, strides)
    populate_array(result, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None)
    return result._getvalue()


def _interpreted_part(flat: Any, start: int, stop: int) -> Any:
    """The same for kernels that are not compiled."""
    return flat[start:stop]


def _interpreted_plane(flat: Any, table: Any, row: int) -> Any:
    """The same for kernels that are not compiled."""
    start, rows, columns = table[row]
    return flat[start : start + rows * columns].reshape(rows, columns)


part: Any = _interpreted_part if config.DISABLE_JIT else intrinsic(_part)  # type: ignore[attr-defined]
plane: Any = _interpreted_plane if config.DISABLE_JIT else intrinsic(_plane)  # type: ignore[attr-defined]
