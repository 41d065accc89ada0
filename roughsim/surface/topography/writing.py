"""Heights in files that other contact programs start from."""

from io import BytesIO
from typing import Any

import numpy as np

from roughsim.grid import Field, Grid

ENDINGS = (".nc", ".npy")


def encoded(heights: Field, grid: Grid, ending: str) -> bytes:
    """Return the content of a file that SurfaceTopography, ContactMechanics and tamaas can start from.

    `heights` are in m, shape `grid.shape`. The ending ".nc" is classic netCDF with sizes, unit and periodicity, as
    ``SurfaceTopography.read_topography`` (and so ContactMechanics) takes it; ".npy" the bare array, for ``numpy.load``
    and so for tamaas. ValueError for another ending, or heights of another shape.
    """
    if ending not in ENDINGS:
        raise ValueError(
            f"ending = {ending!r} is no format of a surface; use {' or '.join(ENDINGS)}"
        )
    data = np.asarray(heights, dtype=float)
    stream = BytesIO()
    if data.shape != grid.shape:
        raise ValueError(f"heights has shape {data.shape}, but the grid has {grid.shape}")
    if ending == ".npy":
        np.save(stream, data, allow_pickle=False)
        return stream.getvalue()
    from scipy.io import netcdf_file

    file = netcdf_file(stream, "w", version=2)
    for axis, points, length in zip("xy", grid.shape, grid.lengths, strict=True):
        file.createDimension(axis, points)
        variable: Any = file.createVariable(axis, "d", (axis,))
        variable[:] = np.arange(points) * (length / points)
        variable.length = np.float64(length)  # a bare float would be stored in single precision
        variable.periodic = 1
        variable.unit = "m"
        variable.units = "m"
    variable = file.createVariable("heights", "d", ("x", "y"))
    variable[:] = data
    variable.unit = variable.units = "m"
    file.flush()
    content = stream.getvalue()
    file.close()  # and the stream with it
    return content
