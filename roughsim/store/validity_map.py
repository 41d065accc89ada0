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
from roughsim.store.disk import hdf5_bytes, place_bytes

Array = NDArray[np.float64]
Quantity = tuple[str, float]  # observable, and Péclet number v/(D q_r); NaN where there is none
FORMAT = 1


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """One table of the map: points at which quantities were measured."""

    coordinates: tuple[str, ...]  # what says where a point lies
    labels: tuple[str, ...]  # a name per point; empty for most
    quantities: tuple[Quantity, ...]
    place: Array  # (points, coordinates)
    value: Array  # measured/theory, (points, quantities); NaN where nothing was measured
    error: Array  # its total relative error, 95 %, (points, quantities)


def write_validity(path: Path, tables: Mapping[str, Table], provenance: Mapping[str, Any]) -> None:
    """Write the tables into one HDF5 file, whole or not at all; OSError, naming the path, if the disk refuses."""

    def fill(file: Any) -> None:
        for name, table in tables.items():
            group = file.create_group(name)
            group.attrs["coordinates"] = json.dumps(table.coordinates)
            group.attrs["labels"] = json.dumps(table.labels)
            # JSON has no NaN
            quantities = [[name, None if np.isnan(peclet) else peclet] for name, peclet in table.quantities]
            group.attrs["quantities"] = json.dumps(quantities)
            for part in ("place", "value", "error"):
                data = np.ascontiguousarray(getattr(table, part), dtype="<f8")
                group.create_dataset(part, data=data, compression="gzip", shuffle=True, fletcher32=True)
        file.attrs.update(format="roughsim validity map", format_version=FORMAT, sha256=_digest(tables))
        file.attrs["provenance"] = json.dumps(dict(provenance), sort_keys=True)

    place_bytes(path, hdf5_bytes(fill))


def read_validity(path: Path | None = None) -> dict[str, Table]:
    """Read a map, the one that the package ships if `path` is left out.

    RecordError, naming the file, if it is missing, damaged, or of a newer format.
    """
    import h5py

    path = Path(str(files("roughsim") / "data" / "validity.h5")) if path is None else path
    tables = {}
    try:
        with h5py.File(path, "r", locking=False) as file:
            if int(file.attrs["format_version"]) > FORMAT:
                raise RecordError(f"{path} has a newer format than {FORMAT}; update roughsim")
            for name, group in file.items():
                coordinates, labels, pairs = (
                    json.loads(group.attrs[k]) for k in ("coordinates", "labels", "quantities")
                )
                quantities = tuple((observable, np.nan if peclet is None else peclet) for observable, peclet in pairs)
                arrays = (group[part][()] for part in ("place", "value", "error"))
                tables[name] = Table(tuple(coordinates), tuple(labels), quantities, *arrays)
            if _digest(tables) != file.attrs["sha256"]:
                raise ValueError("its SHA-256 does not match")
    except RecordError:
        raise
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise RecordError(f"{path} is no readable map of validity ({error}); install roughsim again") from error
    return tables


def _digest(tables: Mapping[str, Table]) -> str:
    digest = hashlib.sha256()
    for name in sorted(tables):
        table = tables[name]
        digest.update(repr((name, table.coordinates, table.labels, table.quantities)).encode())
        for array in (table.place, table.value, table.error):
            digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()
