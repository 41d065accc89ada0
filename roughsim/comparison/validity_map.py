"""The map of the theory's validity, one HDF5 file: measured/theory with its error at many points of load and roughness.

It has the groups `elastic`, `smoothed`, `capped` and `steps`, each with one table: `place` (points, coordinates),
`value` and `error` (points, quantities), and their names as attributes. `value` is measured/theory, `error` its total
relative 95 % error.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np

from roughsim.errors import RecordError
from roughsim.grid import Array
from roughsim.store.disk import read_bytes

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


def read_validity(path: Path | None = None) -> dict[str, Table]:
    """Read a map, the one that the package ships if `path` is left out.

    RecordError, naming the file, if it is missing, damaged, or of a newer format.
    """
    from roughsim.store.hdf5 import opened_hdf5  # loads h5py

    path = Path(str(files("roughsim") / "data" / "validity.h5")) if path is None else path
    tables = {}
    try:
        with opened_hdf5(read_bytes(path)) as file:
            if int(file.attrs["format_version"]) > FORMAT:
                raise RecordError(f"{path} has a newer format than {FORMAT}; update roughsim")
            for name, group in file.items():
                coordinates, labels, pairs = (
                    json.loads(group.attrs[k]) for k in ("coordinates", "labels", "quantities")
                )
                quantities = tuple((observable, np.nan if peclet is None else peclet) for observable, peclet in pairs)
                arrays = (group[part][()] for part in ("place", "value", "error"))
                tables[name] = Table(tuple(coordinates), tuple(labels), quantities, *arrays)
            if digest(tables) != file.attrs["sha256"]:
                raise ValueError("its SHA-256 does not match")
    except RecordError:
        raise
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise RecordError(f"{path} is no readable map of validity ({error}); install roughsim again") from error
    return tables


def digest(tables: Mapping[str, Table]) -> str:
    """Return the SHA-256 of the names and numbers of all tables."""
    seal = hashlib.sha256()
    for name in sorted(tables):
        table = tables[name]
        seal.update(repr((name, table.coordinates, table.labels, table.quantities)).encode())
        for array in (table.place, table.value, table.error):
            seal.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return seal.hexdigest()
