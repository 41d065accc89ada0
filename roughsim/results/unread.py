"""The bridge from stored fields to xarray, which is imported here: only who asks for a dataset needs it."""

from typing import Any

from xarray.backends import BackendArray
from xarray.core import indexing

from roughsim.results.arrays import Stored


class Unread(BackendArray):
    """What xarray asks of a storage backend. It is pickled with the paths of the files, not with their content."""

    def __init__(self, stored: Stored):
        self.stored, self.shape, self.dtype = stored, stored.shape, stored.dtype

    def __getitem__(self, key: Any) -> Any:
        basic = indexing.IndexingSupport.BASIC
        return indexing.explicit_indexing_adapter(key, self.shape, basic, self.stored.__getitem__)


def lazy(stored: Stored) -> indexing.LazilyIndexedArray:
    """Return a field that is read when it is used."""
    return indexing.LazilyIndexedArray(Unread(stored))
