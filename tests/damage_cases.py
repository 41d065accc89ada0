"""Members to damage, and the errors that pass by themselves."""

import errno
import struct

import numpy as np

from roughsim.store.member_files import Member

PASSING = (
    errno.ENOLCK,
    errno.ESTALE,
    errno.EIO,
    errno.EACCES,
    errno.EMFILE,
    errno.ENFILE,
    errno.ETIMEDOUT,
    errno.EBUSY,
)
OLD_EXTENT = 28  # where the superblock of version 3 says where the file ends


def member(index=42, *, fields=True):
    rng = np.random.default_rng(index)
    return Member(
        1,
        index,
        numbers={"flash_temperature": rng.random(3), "contact_fraction": rng.random(1)},
        wavenumber=np.arange(8.0),
        spectrum=rng.random(8),
        fields={name: rng.random((24, 20)).astype(np.float32) for name in ("heights", "pressure") if fields},
        lengths=(2.0, 1.5),
        speeds=(0.0, 0.5, 3.0),
        provenance={"seed": 7},
    )


def without_seal(content):
    """The file as it was written before files had a digest of all their bytes."""
    (end,) = struct.unpack_from("<Q", content, OLD_EXTENT)
    assert end < len(content)
    return content[:end]
