"""The run folder: its description in run.json, opening it, and lines on members that are missing or damaged.

A folder may come from elsewhere, so nothing in it is trusted.
"""

import json
from pathlib import Path
from typing import Any, Literal

from roughsim.errors import RecordError
from roughsim.machine import available_memory, exceeds, in_words
from roughsim.results.members import Damaged
from roughsim.results.pressed import Pressed, Quarters
from roughsim.results.run import Run
from roughsim.scene import Scene, parse_scene
from roughsim.scene.numerics import Numerics
from roughsim.store.claims import writer
from roughsim.store.disk import checksum, is_temporary, place_bytes, read_bytes
from roughsim.store.member_files import AGAIN, check_format, member_name

KIND = "kind"  # key in run.json
RUN, MAP, QUARTERS = "run", "map", "quarters"  # its values
CONTENT = {RUN: "a run of drawn surfaces", MAP: "a pressed map", QUARTERS: "the quarters of a pressed map"}
PRESS = "press"  # key in run.json: "of" the map or its quarters, how it was made periodic, its checksum
_OPENED: dict[str, type[Run]] = {RUN: Run, MAP: Pressed, QUARTERS: Quarters}
_MOST_BYTES = 1 << 20  # of run.json and scene.toml: a scene has at most 64 KiB
_BEGUN = {"claims", "realizations"}  # names that a start may have made before run.json
_NAMED = 5  # members that a line names; of others it gives the number


def describe(folder: Path, description: dict[str, Any], scene: Scene, *, first: bool = False) -> None:
    """Write run.json and scene.toml before any slow work; with `first`, FileExistsError if a process has done so."""
    (folder / "realizations").mkdir(parents=True, exist_ok=True)
    guarded = {**description, "checksums": {key: checksum(value) for key, value in description.items()}}
    for name, text in (("run.json", json.dumps(guarded, indent=1) + "\n"), ("scene.toml", scene.to_toml())):
        path = folder / name
        # an equal file is not written again: a finished run on a full or read-only disk can be opened
        if first or not path.is_file() or path.read_bytes() != text.encode():
            place_bytes(path, text.encode(), first=first and name == "run.json")  # the first process writes both


def folder_state(folder: Path) -> Literal["free", "run", "foreign"]:
    """Return the state of a folder: a run can start ("free"), can continue ("run"), or is refused ("foreign").

    "free": the folder does not exist, is empty, or holds only files of a start interrupted before run.json.
    "run": it has a run.json. "foreign": it is a file, or holds other files.
    """
    if not folder.exists():
        return "free"
    if not folder.is_dir():
        return "foreign"
    if (folder / "run.json").exists():
        return "run"
    names = {path.name for path in folder.iterdir() if not is_temporary(path.name)}
    # a scene.toml alone may be a user's own file: describe() makes the folder for the realizations before it
    begun = _BEGUN | {"scene.toml"} if "realizations" in names else _BEGUN
    inside = folder / "realizations"
    empty = all(is_temporary(path.name) for path in inside.iterdir()) if inside.is_dir() else not inside.exists()
    return "free" if empty and not names - begun else "foreign"


def content_of(folder: Path) -> str:
    """Return the content of a file or folder that prevents a new run or study, in words."""
    if folder.is_file():
        return "is a file"
    words = {"study.json": "holds a study", "run.json": "holds a run"}
    return next((words[name] for name in words if (folder / name).exists()), "holds other files")


def read_description(folder: Path) -> dict[str, Any]:
    """Return the content of run.json.

    RecordError if the folder is no run, has a newer format, or if a value in run.json was changed by hand, with the
    key. OSError if run.json cannot be read now.
    """
    path = folder / "run.json"
    if not folder.exists():
        raise RecordError(f"{folder} does not exist; start it with `roughsim run` or `roughsim press`")
    if folder.is_file():
        raise RecordError(f"{folder} is a file; name the folder of a run")
    try:
        description: dict[str, Any] = json.loads(read_bytes(path, _MOST_BYTES).decode("utf-8"))
        version, checksums = int(description["format_version"]), description.get("checksums")
    except RecordError:
        raise
    except FileNotFoundError:
        if (folder / "study.json").exists():
            raise RecordError(f"{folder} is a study; name the folder of one of its points, in points/") from None
        raise RecordError(f"{folder} is no run: it has no run.json; name the folder that `roughsim run` made") from None
    except (ValueError, LookupError, TypeError, RecursionError) as error:
        raise RecordError(f"{path} is damaged ({error})") from error
    check_format(path, version, description)
    values = {key: checksum(value) for key, value in description.items() if key != "checksums"}
    expected = checksums if isinstance(checksums, dict) else {}
    for key in dict.fromkeys((*expected, *values)):
        if key not in values or expected.get(key) != values[key]:
            raise RecordError(
                f"{key} in {path} was changed since the run wrote it; put the old value back, or give the scene "
                f"that you want to a new folder"
            )
    return description


def open_run(folder: str | Path, *, damaged: Damaged = "refuse") -> Run:
    """Open a run folder for reading, also while another process writes to it.

    Parameters
    ----------
    folder : str or Path
        The folder of a run.
    damaged : {"refuse", "skip", "redo"}, optional
        Treatment of a damaged file: "refuse" raises RecordError with the name of the file. "skip" opens the run, counts
        the realization as failed, and adds the reason to `Run.damaged`. "redo", for runs that recompute it, moves the
        file into the folder "damaged" with a warning.

    Returns
    -------
    Run
        With `estimate`, `pairs` and `correlation`.

    Raises
    ------
    RecordError
        If it is no run, of another format, or one of its files is damaged.
    """
    folder = Path(folder)
    description, path = read_description(folder), folder / "scene.toml"
    try:
        # roughsim stores tables inline in scene.toml: a scene with names of files is not its own
        scene = parse_scene(read_bytes(path, _MOST_BYTES).decode("utf-8"), source=str(path))
        numerics = Numerics.from_dict(description["numerics"])
        _refuse_impossible(description, scene, numerics)
        run = _OPENED[description[KIND]](folder, description, scene, numerics, damaged)
        if isinstance(run, Pressed):
            run.quarters = open_run(folder / QUARTERS, damaged=damaged)
    except (ValueError, LookupError, TypeError, AttributeError) as error:
        raise RecordError(f"{folder} cannot be opened: {error}") from error
    run.refresh()
    return run


def _refuse_impossible(description: dict[str, Any], scene: Scene, numerics: Numerics) -> None:
    """Refuse a description that does not match its scene, or needs more memory than available."""
    if not all(len(reason) == 3 and all(isinstance(word, str) for word in reason) for reason in description["reasons"]):
        raise ValueError("run.json: reasons must be lists of choice, value and reason")
    stored, written = description["scene"], scene.identity()
    if stored != written:
        key = next((key for key in stored | written if stored.get(key) != written.get(key)), "a key")
        raise ValueError(f"run.json and scene.toml are of different scenes: {key} differs; undo the edit")
    most = max(level.shape[0] * level.shape[1] for level in numerics.levels)
    if exceeds(8.0 * most, 0.5):
        needed = f"{8e-9 * most:.3g} GB, more than half of the {in_words(available_memory())}"
        raise ValueError(f"run.json: a field of {most} points needs {needed}; open the run on a larger machine")


def gap(run: Run) -> list[str]:
    """Return a line on gaps, members that are missing although later ones exist; empty without gaps.

    They are lost if no process computes the run now; this check takes a few seconds.
    """
    if not run.missing:
        return []
    process, count = writer(run.folder), f"only the {run.realizations} realizations before count"
    if process:
        return [f"not there yet: {_listed(run.missing)}; {process} computes the run now; {count} so far"]
    missing = open_run(run.folder, damaged="skip").missing  # a process may have ended the run meanwhile
    return [f"lost: {_listed(missing)}; {count}; {AGAIN} to have them"] if missing else []


def left_out(run: Run) -> list[str]:
    """Return a line each on missing and on damaged members, with the consequence; empty for a complete run."""
    names = _listed([member_name(*key) for key in run.damaged])
    damaged = [f"damaged and left out of the means: {names}; {AGAIN} to have them"] if names else []
    return gap(run) + damaged


def _listed(names: list[str]) -> str:
    """Return the first names, and the number of further ones."""
    return ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")
