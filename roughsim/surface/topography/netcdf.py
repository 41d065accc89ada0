"""Maps and line scans in netCDF files, as xarray writes them: heights over coordinates x and y with units."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from roughsim.grid import Array
from roughsim.surface.topography.contents import (
    Contents,
    NoHeightsError,
    check_points,
    even_step,
    index_of_channel,
    length_unit,
    numbered,
)

_CLASSIC = b"CDF"
_HDF5 = b"\x89HDF\r\n\x1a\n"
_LENGTH = "length"  # attribute of x in files of SurfaceTopography, which reads them itself
_SCALES = (("scale_factor", 1.0), ("add_offset", 0.0))
_UNIT_KEYS = ("units", "unit")
_ATTRIBUTES = (*_UNIT_KEYS, _LENGTH, "_FillValue", "missing_value", *(key for key, _ in _SCALES))


class _Variable(NamedTuple):
    """A variable of a netCDF file."""

    axes: tuple[str, ...]  # names of its dimensions
    shape: tuple[int, ...]
    attributes: Mapping[str, Any]
    read: Callable[[], Any]

    def values(self) -> Array:
        """Return its numbers with scale and offset applied; undefined ones are NaN."""
        raw = np.asarray(self.read())
        if raw.dtype.kind not in "iuf":
            raise NoHeightsError(f"holds numbers of type {raw.dtype}; heights must be real numbers")
        values = np.array(raw, dtype=float)
        for key in ("_FillValue", "missing_value"):
            if key in self.attributes:
                values[np.isin(raw, self.attributes[key])] = np.nan
        scale, offset = (
            float(np.ravel(self.attributes.get(key, start))[0]) for key, start in _SCALES
        )
        values = values * scale + offset
        values[~np.isfinite(values)] = np.nan
        return values

    def unit(self, name: str) -> float | None:
        """Return its unit in m, None without one."""
        text = self.attributes.get("units", self.attributes.get("unit", ""))
        if np.size(text) == 1:  # netCDF-4 stores letters such as µ in an array of one string
            text = np.ravel(text)[0]
        text = text.decode(errors="replace") if isinstance(text, bytes) else str(text)
        return length_unit(text, name)


def of_netcdf(path: Path, start: bytes, channel: str | int | None) -> Contents | None:
    """Return the heights of a netCDF file that begins with `start`; None if it is none with axes of its own.

    `channel` is the name or the number of a variable.
    """
    if start.startswith(_CLASSIC):
        from scipy.io import netcdf_file

        with netcdf_file(path, "r", mmap=False) as classic:
            return _heights(_classic_variables(classic), channel)
    if start.startswith(_HDF5):
        import h5py

        with h5py.File(path, "r", locking=False) as file:
            return _heights(_hdf5_variables(file), channel)
    return None


def _classic_variables(file: Any) -> dict[str, _Variable]:
    """Return the variables of a classic file."""
    return {
        name: _Variable(
            tuple(one.dimensions),
            tuple(one.shape),
            {key: getattr(one, key) for key in _ATTRIBUTES if hasattr(one, key)},
            one.data.copy,
        )
        for name, one in file.variables.items()
    }


def _hdf5_variables(file: Any) -> dict[str, _Variable]:
    """Return the variables of the root group whose dimensions have scales, or else the lengths of x and y, and these.

    A unit of the file counts for all variables without one.
    """
    import h5py

    result = {}
    datasets = {name: one for name, one in file.items() if isinstance(one, h5py.Dataset)}
    datasets = {name: one for name, one in datasets.items() if one.shape is not None}
    points = {
        name: one.size for name, one in datasets.items() if name in ("x", "y") and one.ndim == 1
    }
    of_file = {key: file.attrs[key] for key in _UNIT_KEYS if key in file.attrs}
    of_file |= {
        key: one[()] for key, one in datasets.items() if key in _UNIT_KEYS and one.shape == ()
    }
    for name, one in datasets.items():
        scale = one.attrs.get("CLASS") == b"DIMENSION_SCALE"
        scales = [name] if scale else [axis[0].name for axis in one.dims if len(axis)]
        axes = tuple(scale.rsplit("/", 1)[-1] for scale in scales)
        if len(axes) != one.ndim:
            # the axes among x and y that have as many points as the dataset; x first if both orders fit
            orders = ((name,),) if name in points else (("x", "y"), ("y", "x"), ("x",))
            fitting = [order for order in orders if one.shape == tuple(map(points.get, order))]
            axes = next(iter(fitting), ())
        kind = bytes(one.attrs.get("NAME", b""))
        if axes and not kind.startswith(b"This is a netCDF dimension but not"):
            attributes = dict(one.attrs)
            own = {} if attributes.keys() & {*_UNIT_KEYS} else of_file
            read = partial(one.__getitem__, ())
            result[name] = _Variable(axes, one.shape, attributes | own, read)
    return result


def _heights(variables: Mapping[str, _Variable], channel: str | int | None) -> Contents | None:
    """Return the map of the variables, or the line scan if there is no map.

    Of several it is the chosen channel, or else the only one with a unit of length; NoHeightsError if there are more.
    """
    if any(_LENGTH in variables[axis].attributes for axis in "xy" if axis in variables):
        return None
    data = {name: one for name, one in variables.items() if name not in one.axes}
    for dimensions in (2, 1):
        sides = {name: sum(points > 1 for points in one.shape) for name, one in data.items()}
        names = [name for name in data if sides[name] == dimensions]
        if not names:
            continue
        lengths = [name for name in names if _is_length(data[name])]
        alike = lengths or names
        if channel is None and len(alike) > 1:
            raise NoHeightsError(
                f"holds several sets of numbers, {numbered(alike)}; write the name of one as topography_channel, or "
                "save the heights alone"
            )
        index = 0 if channel is None else index_of_channel(alike, channel)
        found = _with_axes(alike[index], data[alike[index]], variables)
        return found._replace(channel=index, channels=tuple(alike)) if len(names) > 1 else found
    return None


def _is_length(variable: _Variable) -> bool:
    try:
        return variable.unit("") is not None
    except NoHeightsError:
        return False


def _with_axes(name: str, variable: _Variable, variables: Mapping[str, _Variable]) -> Contents:
    """Return the heights of a variable over its axes, x first, both rising."""
    shape = tuple(n for n in variable.shape if n > 1)
    check_points(shape)
    heights = variable.values().reshape(shape)
    axes = [axis for axis, n in zip(variable.axes, variable.shape, strict=True) if n > 1]
    sizes = []
    units = []
    for k, axis in enumerate(axes):
        if axis not in variables:
            continue
        step = even_step(variables[axis].values().ravel(), f"its {axis}")
        heights = heights if step > 0.0 else np.flip(heights, k)
        sizes.append(abs(step) * shape[k])
        units.append(variables[axis].unit(f"its {axis}"))
    if len(set(units)) > 1:
        raise NoHeightsError(f"has {' and '.join(axes)} in different units; save both in m")
    if [axis.lower() for axis in axes] == ["y", "x"]:
        heights = heights.T
        sizes = sizes[::-1]
    whole = tuple(sizes) if len(sizes) == len(axes) else None
    unit = variable.unit(f"its {name}")
    lateral_unit = next(iter(units), None)
    return Contents(np.ascontiguousarray(heights), whole, unit, lateral_unit)
