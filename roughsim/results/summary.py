"""A file beside the members with what estimates need of thousands of them: it saves time and decides nothing.

Each of its rows counts only while the member's file has the same digest. A summary that is missing, damaged or of
another run is ignored. Layout: a line that names the format, a line of JSON, for each level its table and wavenumbers
as NumPy's .npy files, and the SHA-256 of all that.
"""

from __future__ import annotations

import hashlib
import json
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.errors import RecordError
from roughsim.results.members import Members
from roughsim.store.disk import place_bytes, read_bytes

NAME = "summary.bin"
FORMAT_LINE = b"roughsim summary 3\n"
HASH_BYTES = 32


def read_summary(folder: Path, run: str, members: Members) -> dict[str, Any] | None:
    """Let `members`, which has none yet, adopt those of a summary, and return what `write_summary` got as `stop`.

    None if there is no summary that is whole and of this run; `members` is of no use then.
    """
    try:
        content = read_bytes(folder / NAME)
        if hashlib.sha256(memoryview(content)[:-HASH_BYTES]).digest() != content[-HASH_BYTES:]:
            return None
        file = BytesIO(content)
        if file.readline() != FORMAT_LINE:
            return None
        header = json.loads(file.readline())
        if header["run"] != run:
            return None
        for level in range(len(members.tables)):
            members.adopt(level, *(np.load(file) for _ in ("table", "wavenumber")))
        members.versions = header["versions"]
        members.failures = {(level, index): reason for level, index, reason in header["failures"]}
        return dict(header["stop"])
    except (OSError, RecordError, ValueError, LookupError, TypeError, AttributeError, RecursionError, MemoryError):
        return None


def write_summary(folder: Path, run: str, members: Members, stop: dict[str, Any]) -> None:
    """Write a summary of all members that were read from files, whole or not at all; a folder may take no files."""
    in_file = [key for key in members.failures if key in members and members.row(key)["size"]]
    failures = [[*key, members.failures[key]] for key in in_file]
    header = {"run": run, "versions": members.versions, "failures": failures, "stop": stop}
    file = BytesIO()
    file.write(FORMAT_LINE + json.dumps(header).encode() + b"\n")
    for level, rows in enumerate(members.tables):
        seen = (rows["state"] > 0) & (rows["size"] > 0)
        table = rows[: np.max(np.flatnonzero(seen), initial=-1) + 1].copy()
        table["state"][~seen[: len(table)]] = 0
        np.save(file, table)
        np.save(file, members.wavenumber.get(level, np.empty(0)))
    content = file.getbuffer()
    with suppress(OSError):
        place_bytes(folder / NAME, content, hashlib.sha256(content).digest())
