"""A file beside the members with what estimates need of thousands of them: it saves time and decides nothing.

Each of its rows counts only while the member's file has the same digest. A summary that is missing, damaged or of
another run is ignored. Layout: a line that names the format, the length of a JSON header in 16 digits, the header, the
arrays that the header lists, and the SHA-256 of all that.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.store.disk import place_bytes, read_bytes

NAME = "summary.bin"
FORMAT_LINE = b"roughsim summary 1\n"
LENGTH_DIGITS = 16
HASH_BYTES = 32


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """The members of one level: their indices in order, a row of each column, and their stress spectra."""

    indices: NDArray[np.int64]
    columns: dict[str, NDArray[Any]]
    wavenumber: NDArray[np.float64]
    spectra: NDArray[np.float64]

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return all arrays by name, in the order of the file."""
        return {"indices": self.indices, "wavenumber": self.wavenumber, "spectra": self.spectra} | self.columns


@dataclass(frozen=True, slots=True, eq=False)
class Summary:
    """Blocks by level; the versions that rows refer to; why members failed; how many realizations do not suffice."""

    blocks: list[Block]
    versions: list[dict[str, str]]
    failures: dict[tuple[int, int], str]
    stop: dict[str, Any] = field(default_factory=dict)


def read_summary(folder: Path, run: str) -> Summary | None:
    """Return the summary of a run folder, or None if there is none that is whole and of this run."""
    try:
        content = read_bytes(folder / NAME)
        end = len(content) - HASH_BYTES
        if not content.startswith(FORMAT_LINE):
            return None
        if hashlib.sha256(memoryview(content)[:end]).digest() != content[end:]:
            return None
        start = len(FORMAT_LINE) + LENGTH_DIGITS
        offset = start + int(content[len(FORMAT_LINE) : start])
        header = json.loads(content[start:offset])
        if header["run"] != run:
            return None
        blocks = []
        for listed in header["blocks"]:
            arrays = {}
            for name, kind, shape in listed:
                count = int(np.prod(shape, dtype=np.int64))
                arrays[name] = np.frombuffer(content, kind, count, offset).reshape(shape)
                offset += arrays[name].nbytes
            indices, wavenumber, spectra = (arrays.pop(name) for name in ("indices", "wavenumber", "spectra"))
            blocks.append(Block(indices, arrays, wavenumber, spectra))
        failures = {(level, index): reason for level, index, reason in header["failures"]}
        return Summary(blocks, header["versions"], failures, header["stop"])
    except (OSError, RecordError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None


def write_summary(folder: Path, run: str, summary: Summary) -> None:
    """Write a summary whole or not at all; a folder that takes no files has none."""
    blocks = [block.arrays() for block in summary.blocks]
    header = {
        "run": run,
        "versions": summary.versions,
        "failures": [[level, index, reason] for (level, index), reason in summary.failures.items()],
        "stop": summary.stop,
        "blocks": [[[name, a.dtype.str, list(a.shape)] for name, a in arrays.items()] for arrays in blocks],
    }
    text = json.dumps(header).encode()
    parts: list[bytes | memoryview] = [FORMAT_LINE, b"%0*d" % (LENGTH_DIGITS, len(text)), text]
    parts += [np.ascontiguousarray(a).data.cast("B") for arrays in blocks for a in arrays.values() if a.size]
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    try:
        place_bytes(folder / NAME, *parts, digest.digest())
    except OSError:
        return


@cache
def code_digest() -> str:
    """Return a digest of the code that estimates: what other code found insufficient is tried again."""
    digest = hashlib.sha256()
    for package in ("roughsim", "theory"):
        for path in sorted((Path(__file__).parents[2] / package).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()
