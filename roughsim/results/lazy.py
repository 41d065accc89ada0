"""Stored arrays as xarray sees them: read when they are used. Needs the extra `xarray`."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from roughsim.results.labelled import Stored

_backends: Any = import_module("xarray.backends")
_indexing: Any = import_module("xarray.core.indexing")
_Base: Any = _backends.BackendArray


class _Arrays(_Base):  # type: ignore[misc]
    """The bridge that xarray asks of a storage backend."""

    def __init__(self, stored: Stored):
        self.stored, self.shape, self.dtype = stored, stored.shape, stored.dtype

    def __getitem__(self, key: Any) -> Any:
        basic = _indexing.IndexingSupport.BASIC
        return _indexing.explicit_indexing_adapter(key, self.shape, basic, self.stored.__getitem__)


def lazily(stored: Stored) -> Any:
    """Return stored arrays as data of an xarray variable that are not read yet."""
    return _indexing.LazilyIndexedArray(_Arrays(stored))
