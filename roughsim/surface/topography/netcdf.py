"""Maps and line scans in netCDF files, as xarray writes them: heights over coordinates x and y with units."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from roughsim.grid import Array
from roughsim.surface.topography.contents import Contents, NoHeightsError, even_step, length_unit

_CLASSIC, _HDF5 = b"CDF", b"\x89HDF\r\n\x1a\n"
_LENGTH = "length"  # attribute of x in files of SurfaceTopography, which reads them itself
_SCALES = (("scale_factor", 1.0), ("add_offset", 0.0))
_ATTRIBUTES = ("unit", "units", _LENGTH, "_FillValue", "missing_value", *(key for key, _ in _SCALES))


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
        values = np.array(raw, dtype=np.float64)
        for key in ("_FillValue", "missing_value"):
            if key in self.attributes:
                values[np.isin(raw, self.attributes[key])] = np.nan
        scale, offset = (float(np.ravel(self.attributes.get(key, start))[0]) for key, start in _SCALES)
        values = values * scale + offset
        values[~np.isfinite(values)] = np.nan
        return values

    def unit(self, name: str) -> float | None:
        """Return its unit in m, None without one."""
        text = self.attributes.get("units", self.attributes.get("unit", ""))
        if np.size(text) == 1:  # netCDF-4 stores letters such as µ in an array of one string
            text = np.ravel(text)[0]
        return length_unit(text.decode(errors="replace") if isinstance(text, bytes) else str(text), name)


def of_netcdf(path: Path, start: bytes, check: Callable[[tuple[int, ...]], None]) -> Contents | None:
    """Return the heights of a netCDF file that begins with `start`; None if it is none with axes of its own.

    `check` refuses a shape before its numbers are read.
    """
    if start.startswith(_CLASSIC):
        from scipy.io import netcdf_file

        with netcdf_file(path, "r", mmap=False) as classic:
            return _heights(_classic_variables(classic), check)
    if start.startswith(_HDF5):
        import h5py

        with h5py.File(path, "r", locking=False) as file:
            return _heights(_hdf5_variables(file), check)
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
    """Return the variables of the root group whose dimensions have scales, and these."""
    import h5py

    result = {}
    for name, one in file.items():
        if not isinstance(one, h5py.Dataset) or one.shape is None:
            continue
        scale = one.attrs.get("CLASS") == b"DIMENSION_SCALE"
        axes = (name,) if scale else tuple(axis[0].name.rsplit("/", 1)[-1] for axis in one.dims if len(axis))
        without_values = bytes(one.attrs.get("NAME", b"")).startswith(b"This is a netCDF dimension but not")
        if len(axes) == one.ndim and not without_values:
            result[name] = _Variable(axes, one.shape, dict(one.attrs), partial(one.__getitem__, ()))
    return result


def _heights(variables: Mapping[str, _Variable], check: Callable[[tuple[int, ...]], None]) -> Contents | None:
    """Return the map of the variables, or the line scan if there is no map."""
    if any(_LENGTH in variables[axis].attributes for axis in "xy" if axis in variables):
        return None
    data = {name: one for name, one in variables.items() if name not in one.axes}
    for dimensions in (2, 1):
        name = _only_name(data, dimensions)
        if name is not None:
            return _with_axes(name, data[name], variables, check)
    return None


def _only_name(data: Mapping[str, _Variable], dimensions: int) -> str | None:
    """Return the name of the variable of so many dimensions, of those with a unit of length if any have one.

    None without such a variable; NoHeightsError if there are several.
    """
    found = [name for name, one in data.items() if sum(points > 1 for points in one.shape) == dimensions]
    lengths = [name for name in found if _is_length(data[name])]
    names = lengths or found
    if len(names) > 1:
        raise NoHeightsError(f"holds several sets of numbers, {', '.join(sorted(names))[:80]}; save the heights alone")
    return names[0] if names else None


def _is_length(variable: _Variable) -> bool:
    try:
        return variable.unit("") is not None
    except NoHeightsError:
        return False


def _with_axes(
    name: str, variable: _Variable, variables: Mapping[str, _Variable], check: Callable[[tuple[int, ...]], None]
) -> Contents:
    """Return the heights of a variable over its axes, x first, both rising."""
    shape = tuple(n for n in variable.shape if n > 1)
    check(shape)
    heights = variable.values().reshape(shape)
    axes = [axis for axis, n in zip(variable.axes, variable.shape, strict=True) if n > 1]
    sizes, units = [], []
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
        heights, sizes = heights.T, sizes[::-1]
    whole = tuple(sizes) if len(sizes) == len(axes) else None
    return Contents(np.ascontiguousarray(heights), whole, variable.unit(f"its {name}"), units[0] if units else None)
