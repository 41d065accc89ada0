"""Members to damage, and the errors that pass by themselves."""

import errno
import hashlib
import json
import struct
from contextlib import contextmanager

import h5py
import numpy as np

from roughsim.observables.member import Member, StoredMoments

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
END = 28  # where the superblock of version 3 says where the HDF5 data end


def member(index=42, *, fields=True, below=True):
    rng = np.random.default_rng(index)

    def moments(modes):
        numbers = {"flash_temperature": rng.random(3), "contact_fraction": rng.random(1)}
        return StoredMoments(numbers, np.arange(float(modes)), rng.random(modes))

    return Member(
        1,
        index,
        moments=(moments(8), moments(5)) if below else (moments(8),),
        fields={
            name: rng.random((24, 20)).astype(np.float32)
            for name in ("heights", "pressure")
            if fields
        },
        lengths=(2.0, 1.5),
        speeds=(0.0, 0.5, 3.0),
        provenance={"seed": 7, "text": "ünïcode"},
    )


def without_seal(content):
    """The HDF5 data of a member alone."""
    (end,) = struct.unpack_from("<Q", content, END)
    assert end < len(content)
    return content[:end]


def sealed(path, content):
    """Write HDF5 data with a seal that is sound."""
    content += f"\nroughsim {path.name} sha256 ".encode()
    path.write_bytes(content + hashlib.sha256(content).hexdigest().encode() + b"\n")


@contextmanager
def forged(path):
    """Change a member's file with h5py, and seal it again as who forges one can."""
    with h5py.File(path, "r+", libver="v110") as file:  # leaves the seal out
        yield file
    sealed(path, path.read_bytes())


def with_header(path, **changes):
    """Forge the header of a member."""
    with forged(path) as file:
        file.attrs["header"] = json.dumps(json.loads(file.attrs["header"]) | changes)


@contextmanager
def level_of(path):
    """Change what the header of a part has on its only level."""
    with forged(path) as file:
        header = json.loads(file.attrs["header"])
        (level,) = header["levels"]
        yield level
        file.attrs["header"] = json.dumps(header)
