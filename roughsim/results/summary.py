"""A summary beside the members: what estimates need of thousands of files, in one.

It spares time and decides nothing: each of its rows counts only while the member's file bears the same digest, and a
summary that is missing, damaged or of another run is as none. Layout: a line that names it, the length of a JSON header
in 16 digits, the header, the arrays it lists, and the SHA-256 of all that.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughsim.errors import RecordError
from roughsim.store.disk import place_bytes, read_bytes

NAME = "summary.bin"
_MARK = b"roughsim summary 1\n"
_DIGITS = 16
_HASH = hashlib.sha256().digest_size


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """The members of one level: their indices in order, a row of each column, and their stress spectra."""

    indices: NDArray[np.int64]
    columns: dict[str, NDArray[Any]]
    wavenumber: NDArray[np.float64]
    spectra: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Summary:
    """What the file holds.

    Attributes
    ----------
    blocks : list of Block
        By level.
    versions : list of dict
        Versions of packages; the members' columns have places in it.
    failures : dict of (int, int) to str
        Why members have no numbers.
    stop : dict
        What is known of where the run may stop, see `Run`.
    """

    blocks: list[Block]
    versions: list[dict[str, str]]
    failures: dict[tuple[int, int], str]
    stop: dict[str, Any] = field(default_factory=dict)


def read_summary(folder: Path, run: str) -> Summary | None:
    """Return the summary of a run folder, or None if there is none that is whole and of this run."""
    try:
        content = read_bytes(folder / NAME)
        return _parsed(content, run)
    except (OSError, RecordError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None


def write_summary(folder: Path, run: str, summary: Summary) -> None:
    """Write a summary whole or not at all; where the folder takes no files, there is none."""
    arrays = [array for block in summary.blocks for _, array in _named(block) if array.size]
    header = {
        "run": run,
        "versions": summary.versions,
        "failures": [[level, index, text] for (level, index), text in summary.failures.items()],
        "stop": summary.stop,
        "blocks": [
            [[name, array.dtype.str, list(array.shape)] for name, array in _named(block)] for block in summary.blocks
        ],
    }
    text = json.dumps(header).encode()
    parts: list[bytes | memoryview] = [_MARK, b"%0*d" % (_DIGITS, len(text)), text]
    parts += [np.ascontiguousarray(array).data.cast("B") for array in arrays]
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    try:
        place_bytes(folder / NAME, *parts, digest.digest())
    except OSError:
        return


def _named(block: Block) -> Iterator[tuple[str, NDArray[Any]]]:
    yield "indices", block.indices
    yield "wavenumber", block.wavenumber
    yield "spectra", block.spectra
    yield from block.columns.items()


def _parsed(content: bytes, run: str) -> Summary | None:
    end = len(content) - _HASH
    whole = content.startswith(_MARK) and hashlib.sha256(memoryview(content)[:end]).digest() == content[end:]
    if not whole:
        return None
    place = len(_MARK) + _DIGITS
    length = int(content[len(_MARK) : place])
    header = json.loads(content[place : place + length])
    if header["run"] != run:
        return None
    place += length
    blocks = []
    for listed in header["blocks"]:
        arrays = {}
        for name, kind, shape in listed:
            count = int(np.prod(shape, dtype=np.int64))
            arrays[name] = np.frombuffer(content, kind, count, place).reshape(shape)
            place += arrays[name].nbytes
        indices, wavenumber, spectra = (arrays.pop(name) for name in ("indices", "wavenumber", "spectra"))
        blocks.append(Block(indices, arrays, wavenumber, spectra))
    return Summary(blocks, header["versions"], {(a, b): text for a, b, text in header["failures"]}, header["stop"])


@cache
def code_digest() -> str:
    """Return a digest of the code that estimates: what was known by other code is not known any more."""
    digest = hashlib.sha256()
    for package in ("roughsim", "theory"):
        for path in sorted((Path(__file__).parents[2] / package).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()
