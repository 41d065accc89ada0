"""The map as the file that the package ships; `roughsim.comparison.validity_map` says its layout and reads it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.comparison.validity_map import FORMAT, Table, digest
from roughsim.store.disk import place_bytes
from roughsim.store.hdf5 import hdf5_bytes


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
        file.attrs.update(format="roughsim validity map", format_version=FORMAT, sha256=digest(tables))
        file.attrs["provenance"] = json.dumps(dict(provenance), sort_keys=True)

    place_bytes(path, hdf5_bytes(fill))
