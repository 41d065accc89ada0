"""What the folder of a run holds, by its run.json: drawn surfaces, a pressed map, or the quarters of one."""

import json
from pathlib import Path
from typing import Any

from roughsim.store.disk import read_bytes

DESCRIPTION, STUDY = "run.json", "study.json"
MOST_BYTES = 1 << 20  # of run.json and scene.toml: a scene has at most 64 KiB
KIND = "kind"  # key in run.json; runs of older versions have none
RUN, MAP, QUARTERS = "run", "map", "quarters"  # its values
CONTENT = {RUN: "a run of drawn surfaces", MAP: "a pressed map", QUARTERS: "the quarters of a pressed map"}
PRESS = "press"  # key in run.json: "of" the map or its quarters, how it was made periodic, its checksum


def kind_of(folder: Path) -> str | None:
    """Return what a folder holds, or may alone hold: `RUN`, `MAP` or `QUARTERS`; None where any run may begin.

    Folders of older versions are recognized by the key `PRESS`, or by the run of the quarters that the folder of a map
    has within it.
    """
    folder = folder.resolve()
    record = _record(folder)
    if (kind := record.get(KIND)) in CONTENT:
        return str(kind)
    if isinstance(about := record.get(PRESS), dict) and about.get("of") in (MAP, QUARTERS):
        return str(about["of"])
    begun = (folder / DESCRIPTION).exists()
    if begun and (folder / QUARTERS / DESCRIPTION).exists():
        return MAP
    inside = folder.name == QUARTERS and (folder.parent / DESCRIPTION).exists() and kind_of(folder.parent) == MAP
    return QUARTERS if inside else RUN if begun else None


def again(folder: Path) -> str:
    """Return, for advice, how to compute what a folder lacks."""
    kind = kind_of(folder)
    if kind not in (MAP, QUARTERS):
        return "run the scene again"
    home = folder.resolve().parent if kind == QUARTERS else folder
    return f"press the map again (roughsim press SCENE -o {home})"


def content_of(folder: Path) -> str:
    """Return in words what stands in the way of a new run or study; a file, or a folder that is not empty."""
    if folder.is_file():
        return "is a file"
    if (folder / STUDY).exists():
        return "holds a study"
    kind = kind_of(folder)
    return "holds other files" if kind is None else f"holds {CONTENT[kind]}"


def _record(folder: Path) -> dict[str, Any]:
    """Return run.json as it is, unchecked; empty where there is none, or none that can be read."""
    try:
        record = json.loads(read_bytes(folder / DESCRIPTION, MOST_BYTES))
    except (OSError, ValueError, RecursionError):  # RecordError is a ValueError
        return {}
    return record if isinstance(record, dict) else {}
