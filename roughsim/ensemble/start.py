"""How a run begins or goes on in its folder: what is refused before any work, who plans, and what is damaged."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughsim import prediction
from roughsim.errors import RecordError
from roughsim.pipeline import versions
from roughsim.planning.plan import plan
from roughsim.results.folder import describe, folder_state, read_description
from roughsim.scene.numerics import Numerics, Reason
from roughsim.store.claims import Claims
from roughsim.store.disk import is_temporary, set_aside
from roughsim.store.member_files import FORMAT, check_member

if TYPE_CHECKING:
    from roughsim.scene import Scene

_MEMBER = re.compile(r"L\d+-\d{6,}\.h5|\.L\d+-\d{6,}\.h5\..+\.tmp")
_BEGUN = re.compile(r"\.(run\.json|scene\.toml|summary\.bin)\..+\.tmp")


def begin(scene: Scene, place: Path, numerics: Numerics | None = None) -> Numerics:
    """Make a folder that holds this very scene, or see that it does, and return the numerics that count there.

    What does not fit is refused before anything is planned. Of several processes that begin at once, the first one to
    write decides, and the others take its numerics: plans made at different times may differ.

    Parameters
    ----------
    scene : Scene
        What is to be computed.
    place : Path
        The run folder.
    numerics : Numerics, optional
        Left out: those that the run in the folder has, else from `plan`.

    Raises
    ------
    RecordError
        If the folder holds other files or another scene, naming the first key that differs.
    """
    state = folder_state(place)
    if state == "foreign":
        reason = "holds other files; name a new folder" if place.is_dir() else "is a file; name a folder"
        raise RecordError(f"{place} {reason} for the run")
    if state != "run":
        first = plan(scene) if numerics is None else numerics
        try:
            describe(place, _description(scene, first), scene, first=True)
            return first
        except FileExistsError:
            pass  # another process was quicker
    there = read_description(place)
    agreed = _numerics_there(place, there, scene) if numerics is None else numerics
    description = _description(scene, agreed)
    _refuse_other(place, there, description)
    # what differs from process to process stays as the first one wrote it
    description |= {key: there[key] for key in ("versions", "reasons") if key in there}
    describe(place, description, scene)
    return agreed


def _numerics_there(place: Path, there: dict[str, Any], scene: Scene) -> Numerics:
    """Return the numerics that a run began with: planned again, for a longer run, they could be others."""
    try:
        numerics = Numerics.from_dict(there["numerics"])
        reasons = tuple(Reason(*words) for words in there["reasons"])
    except (KeyError, TypeError, ValueError) as error:
        raise RecordError(f"{place} cannot be opened: {error}") from error
    kept = scene.numerics.keep_fields
    return replace(numerics, keep_fields=numerics.keep_fields if kept is None else kept, reasons=reasons)


def _refuse_other(place: Path, there: dict[str, Any], wanted: dict[str, Any]) -> None:
    for part in ("scene", "numerics"):
        for key in dict.fromkeys((*there[part], *wanted[part])):
            old, new = there[part].get(key), wanted[part].get(key)
            if old != new and key != "keep_fields":
                raise RecordError(
                    f"{place} holds another scene: {key} is {old} there and {new} here; name another folder, or give "
                    f"the scene as it was"
                )


def _description(scene: Scene, numerics: Numerics) -> dict[str, Any]:
    """What run.json says: all that the run is, as JSON values."""
    return {
        "format_version": FORMAT,
        "scene": scene.identity(),
        "numerics": numerics.to_dict(),
        "seed": scene.ensemble.seed,
        "until": dict(scene.ensemble.until),
        "max_realizations": scene.ensemble.max_realizations,
        "heat_partition": prediction.heat_partition(scene).tolist(),
        "reasons": [list(reason) for reason in numerics.reasons],
        "versions": versions(),
    }


def sweep(place: Path, claims: Claims) -> None:
    """Move damaged members aside, with a warning each, and remove what killed writers left half done.

    Raises
    ------
    OSError
        If a member cannot be read now: that is no damage, and nothing is done about it.
    """
    clear(place, claims)
    for path in _ours(place):
        if is_temporary(path.name):
            continue
        try:
            check_member(path)
        except FileNotFoundError:
            continue  # another process has moved it
        except RecordError as error:
            try:
                where = set_aside(path)
            except FileNotFoundError:
                continue
            reason = str(error).partition(";")[0]
            warnings.warn(f"{reason}; it was moved to {where} and is done again", RuntimeWarning, stacklevel=3)


def clear(place: Path, claims: Claims) -> None:
    """Remove what killed writers left half done: of members that nobody computes now, and beside them."""
    for path in _ours(place):
        if is_temporary(path.name) and not claims.claimed(path.name[1:].partition(".")[0]):
            path.unlink(missing_ok=True)  # a writer without a claim, if there is one, writes it again
    for path in place.iterdir():
        if _BEGUN.fullmatch(path.name) and is_temporary(path.name):
            path.unlink(missing_ok=True)  # so does one that is at work


def _ours(place: Path) -> list[Path]:
    """The members of a run folder, whole or begun; what else lies there is somebody's own."""
    return sorted(path for path in (place / "realizations").iterdir() if _MEMBER.fullmatch(path.name))
