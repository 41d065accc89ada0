"""Kinds of run folders, by their run.json: drawn surfaces, a pressed map, or the quarters of a map."""

import json
from pathlib import Path

from roughsim.store.disk import read_bytes

DESCRIPTION, STUDY = "run.json", "study.json"
MOST_BYTES = 1 << 20  # of run.json and scene.toml: a scene has at most 64 KiB
KIND = "kind"  # key in run.json
RUN, MAP, QUARTERS = "run", "map", "quarters"  # its values
CONTENT = {RUN: "a run of drawn surfaces", MAP: "a pressed map", QUARTERS: "the quarters of a pressed map"}
PRESS = "press"  # key in run.json: "of" the map or its quarters, how it was made periodic, its checksum


def kind_of(folder: Path) -> str | None:
    """Return the kind of the run in a folder, or the only kind that may begin there; None if any may begin."""
    folder = folder.resolve()
    try:
        kind = json.loads(read_bytes(folder / DESCRIPTION, MOST_BYTES))[KIND]
        if kind in CONTENT:
            return str(kind)
    except (OSError, ValueError, LookupError, TypeError, RecursionError):  # RecordError is a ValueError
        pass
    if (folder / DESCRIPTION).exists():
        return RUN
    return QUARTERS if folder.name == QUARTERS and kind_of(folder.parent) == MAP else None


def again(folder: Path) -> str:
    """Return the advice to compute missing members of a run."""
    kind = kind_of(folder)
    if kind not in (MAP, QUARTERS):
        return "run the scene again"
    home = folder.resolve().parent if kind == QUARTERS else folder
    return f"press the map again (roughsim press SCENE -o {home})"


def content_of(folder: Path) -> str:
    """Return the content of a file or folder that prevents a new run or study, in words."""
    if folder.is_file():
        return "is a file"
    if (folder / STUDY).exists():
        return "holds a study"
    kind = kind_of(folder)
    return "holds other files" if kind is None else f"holds {CONTENT[kind]}"
