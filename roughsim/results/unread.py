"""Stored fields as lazy arrays of xarray: the only module that imports xarray at its top."""

from typing import Any

from xarray.backends import BackendArray
from xarray.core import indexing

from roughsim.results.arrays import Stored


class _Unread(BackendArray):
    """A storage backend of xarray. It is pickled with the paths of the files, not with their content."""

    def __init__(self, stored: Stored):
        self.stored, self.shape, self.dtype = stored, stored.shape, stored.dtype

    def __getitem__(self, key: Any) -> Any:
        basic = indexing.IndexingSupport.BASIC
        return indexing.explicit_indexing_adapter(key, self.shape, basic, self.stored.__getitem__)


def lazy(stored: Stored) -> indexing.LazilyIndexedArray:
    """Return a field that is read when it is used."""
    return indexing.LazilyIndexedArray(_Unread(stored))
