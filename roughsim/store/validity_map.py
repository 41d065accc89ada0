"""The map of the theory's validity as one HDF5 file: measured/theory with errors over the places where it was measured.

Groups `elastic`, `smoothed`, `capped` and `steps`; in each a table: `place` (points, coordinates), `value` and `error`
(points, quantities), their names as attributes. `value` is measured/theory, `error` its total relative 95 % error.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.store.disk import place_hdf5

Array = NDArray[np.float64]
Quantity = tuple[str, float]  # observable, and Péclet number v/(D q_r); NaN where there is none
_FORMAT = 1


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """One table of the map.

    Attributes
    ----------
    coordinates : tuple of str
        What says where a point lies.
    labels : tuple of str
        A name per point; empty for most.
    quantities : tuple of (str, float)
        Observable and Péclet number.
    place : ndarray
        Shape (points, coordinates).
    value, error : ndarray
        Measured/theory and its total relative error (95 %), shape (points, quantities); NaN where nothing was measured.
    """

    coordinates: tuple[str, ...]
    labels: tuple[str, ...]
    quantities: tuple[Quantity, ...]
    place: Array
    value: Array
    error: Array


def write_validity(path: Path, tables: Mapping[str, Table], provenance: Mapping[str, Any]) -> None:
    """Write the tables into one HDF5 file, whole or not at all.

    Raises
    ------
    OSError
        If the disk refuses, naming the path.
    """

    def fill(file: Any) -> None:
        for name, table in tables.items():
            _fill(file.create_group(name), table)
        file.attrs.update(format="roughsim validity map", format_version=_FORMAT, sha256=_digest(tables))
        file.attrs["provenance"] = json.dumps(dict(provenance), sort_keys=True)

    place_hdf5(path, fill)


def read_validity(path: Path | None = None) -> dict[str, Table]:
    """Read a map, the one that the package ships if `path` is left out.

    Raises
    ------
    RecordError
        If the file is missing, damaged, or of a newer format; the message names it.
    """
    import h5py

    place = Path(str(files("roughsim") / "data" / "validity.h5")) if path is None else path
    try:
        with h5py.File(place, "r", locking=False) as file:
            if int(file.attrs["format_version"]) > _FORMAT:
                raise RecordError(f"{place} has a newer format than {_FORMAT}; update roughsim")
            tables = {name: _table(file[name]) for name in file}
            if _digest(tables) != file.attrs["sha256"]:
                raise ValueError("its SHA-256 does not match")
    except RecordError:
        raise
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise RecordError(f"{place} is no readable map of validity ({error}); install roughsim again") from error
    return tables


def _fill(group: Any, table: Table) -> None:
    group.attrs["coordinates"] = json.dumps(table.coordinates)
    group.attrs["labels"] = json.dumps(table.labels)
    group.attrs["quantities"] = json.dumps([[name, None if np.isnan(pe) else pe] for name, pe in table.quantities])
    for name in ("place", "value", "error"):
        data = np.ascontiguousarray(getattr(table, name), dtype="<f8")
        group.create_dataset(name, data=data, compression="gzip", shuffle=True, fletcher32=True)


def _table(group: Any) -> Table:
    quantities = tuple((name, np.nan if pe is None else pe) for name, pe in json.loads(group.attrs["quantities"]))
    coordinates, labels = (tuple(json.loads(group.attrs[name])) for name in ("coordinates", "labels"))
    return Table(coordinates, labels, quantities, *(group[name][()] for name in ("place", "value", "error")))


def _digest(tables: Mapping[str, Table]) -> str:
    digest = hashlib.sha256()
    for name in sorted(tables):
        table = tables[name]
        digest.update(repr((name, table.coordinates, table.labels, table.quantities)).encode())
        for array in (table.place, table.value, table.error):
            digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()
