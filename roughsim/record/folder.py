"""The run folder: what it says of itself, and opening it. It may come from elsewhere, so nothing in it is believed."""

from __future__ import annotations

import json
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from roughsim.errors import RecordError
from roughsim.foreign import memory, regular_file
from roughsim.means import OBSERVABLES
from roughsim.record.disk import place_bytes
from roughsim.record.files import check_format
from roughsim.record.run import Run

if TYPE_CHECKING:
    from roughsim.numerics import Numerics
    from roughsim.scene import Scene

_MOST_BYTES = 1 << 20  # of run.json and scene.toml: a scene has at most 64 KiB


def describe(folder: Path, description: dict[str, Any], scene: Scene) -> None:
    """Write what a run is, before anything slow."""
    (folder / "realizations").mkdir(parents=True, exist_ok=True)
    place_bytes(folder / "scene.toml", scene.to_toml().encode())
    place_bytes(folder / "run.json", (json.dumps(description, indent=1) + "\n").encode())


def read_description(folder: Path) -> dict[str, Any]:
    """Return what `describe` wrote.

    Raises
    ------
    RecordError
        If the folder is no run, or one of a newer format.
    """
    path = folder / "run.json"
    if not folder.exists():
        raise RecordError(f"{folder} does not exist; start it with: roughsim run SCENE -o {folder}")
    try:
        description = json.loads(_text(path))
        version = int(description["format_version"])
    except RecordError:
        raise
    except FileNotFoundError:
        raise RecordError(f"{folder} is no run: it has no run.json") from None
    except (OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        raise RecordError(f"{path} is damaged ({error})") from error
    check_format(path, version)
    return dict(description)


def _text(path: Path) -> str:
    """The text of a file of the folder, if it has no more bytes than such a file can have."""
    with open(regular_file(path), "rb") as file:
        content = file.read(_MOST_BYTES + 1)
    if len(content) > _MOST_BYTES:
        raise RecordError(f"{path} has more than {_MOST_BYTES >> 20} MiB: roughsim does not write such")
    return content.decode("utf-8")


def open_run(folder: str | Path, *, damaged: Literal["refuse", "skip"] = "refuse") -> Run:
    """Open a run folder for reading, also while another process writes to it.

    Parameters
    ----------
    folder : str or Path
        What `run` was given.
    damaged : {"refuse", "skip"}, optional
        What becomes of a damaged file among good ones: the run is refused, naming it; or the rest is opened, the
        realization counts as failed, and `Run.damaged` says why.

    Returns
    -------
    Run
        With `estimate`, `samples` and `correlation`.

    Raises
    ------
    RecordError
        If it is no run, of another format, or one of its files is damaged.
    """
    from roughsim.numerics import Numerics
    from roughsim.scene import parse_scene

    place = Path(folder)
    description = read_description(place)
    try:
        # a stored scene holds its tables inline: one that names files did not come from here
        scene = parse_scene(_text(place / "scene.toml"), source=str(place / "scene.toml"))
        numerics = Numerics.from_dict(description["numerics"])
        _check(description, scene, numerics)
        run = Run(place, description, scene, numerics, skip_damaged=damaged == "skip")
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise RecordError(f"{place} cannot be opened: {error}") from error
    run.refresh()
    return run


def _check(description: dict[str, Any], scene: Scene, numerics: Numerics) -> None:
    """Refuse a description that does not go with its scene, or asks for more than this machine has."""
    speeds, share = len(scene.speeds), description["heat_partition"]
    for name in ("seed", "max_realizations"):
        if not isinstance(description[name], int) or description[name] < 0:
            raise ValueError(f"run.json: {name} = {description[name]!r} must be a whole number ≥ 0")
    if len(share) != speeds or not all(isfinite(part) and 0.0 < part <= 1.0 for part in share):
        raise ValueError(f"run.json: heat_partition must be {speeds} numbers in (0, 1], one for each speed")
    for name, goal in description["until"].items():
        if name not in OBSERVABLES or not 0.0 < goal < 1.0:
            raise ValueError(f"run.json: until = {name!r}, {goal!r} is no observable with a goal between 0 and 1")
    if not all(len(reason) == 3 and all(isinstance(word, str) for word in reason) for reason in description["reasons"]):
        raise ValueError("run.json: reasons must be lists of choice, value and reason")
    if description["scene"] != scene.identity():
        raise ValueError("run.json and scene.toml are of different scenes")
    most = max(level.shape[0] * level.shape[1] for level in numerics.levels)
    if 8.0 * most > 0.5 * memory():
        raise ValueError(f"run.json: a field of {most} points needs more than half of the machine's memory")
