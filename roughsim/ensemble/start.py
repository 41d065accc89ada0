"""How a run begins or goes on in its folder: what is refused before any work, who plans, and what is damaged."""

from __future__ import annotations

import errno
import os
import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

from roughsim import prediction
from roughsim.errors import RecordError
from roughsim.pipeline import versions
from roughsim.planning.plan import plan
from roughsim.results.folder import describe, folder_state, read_description
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics, Reason
from roughsim.store.claims import Claims
from roughsim.store.disk import is_temporary, set_aside
from roughsim.store.member_files import FORMAT, MEMBER_NAME, check_member

_MEMBER = re.compile(rf"{MEMBER_NAME.pattern}\.h5|\.{MEMBER_NAME.pattern}\.h5\..+\.tmp")
_BEGUN = re.compile(r"\.(run\.json|scene\.toml|summary\.bin)\..+\.tmp")


def begin(scene: Scene, folder: Path, numerics: Numerics | None = None) -> Numerics:
    """Make a folder that holds this very scene, or see that it does, and return the numerics that count there.

    Without `numerics` those of the run in the folder count, else those of `plan`. RecordError, before anything is
    planned, if the folder holds other files or another scene, naming the first key that differs.
    """
    try:
        os.path.abspath(folder)
    except FileNotFoundError:
        reason = "the current directory was deleted; change to another one, or give the whole path of the run folder"
        raise FileNotFoundError(errno.ENOENT, reason) from None
    state = folder_state(folder)
    if state == "foreign":
        reason = "holds other files; name a new folder" if folder.is_dir() else "is a file; name a folder"
        raise RecordError(f"{folder} {reason} for the run")
    if state != "run":
        planned = plan(scene) if numerics is None else numerics
        try:
            describe(folder, _description(scene, planned), scene, first=True)
            return planned
        except FileExistsError:
            # another process was quicker: its numerics count, since plans made at different times may differ
            pass
    stored = read_description(folder)
    if numerics is None:
        numerics = _stored_numerics(folder, stored, scene)
    description = _description(scene, numerics)
    for part in ("scene", "numerics"):
        for key in dict.fromkeys((*stored[part], *description[part])):
            old, new = stored[part].get(key), description[part].get(key)
            if old != new and key != "keep_fields":
                raise RecordError(
                    f"{folder} holds another scene: {key} is {old} there and {new} here; name another folder, or give "
                    f"the scene as it was"
                )
    # what differs from process to process stays as the first one wrote it
    description |= {key: stored[key] for key in ("versions", "reasons") if key in stored}
    describe(folder, description, scene)
    return numerics


def _stored_numerics(folder: Path, stored: dict[str, Any], scene: Scene) -> Numerics:
    """Return the numerics that a run began with: planned again, for a longer run, they could be others."""
    try:
        numerics = Numerics.from_dict(stored["numerics"])
        reasons = tuple(Reason(*words) for words in stored["reasons"])
    except (KeyError, TypeError, ValueError) as error:
        raise RecordError(f"{folder} cannot be opened: {error}") from error
    keep = scene.numerics.keep_fields
    return replace(numerics, keep_fields=numerics.keep_fields if keep is None else keep, reasons=reasons)


def _description(scene: Scene, numerics: Numerics) -> dict[str, Any]:
    """Return what run.json says: all that the run is, as JSON values."""
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


def sweep(folder: Path, claims: Claims) -> None:
    """Move damaged members aside, with a warning each, and remove what killed writers left half done.

    OSError if a member cannot be read now: that is no damage, and nothing is done about it.
    """
    clear(folder, claims)
    for path in member_files(folder):
        if is_temporary(path.name):
            continue
        try:
            check_member(path)
        except FileNotFoundError:
            continue  # another process has moved it
        except RecordError as error:
            try:
                kept = set_aside(path)
            except FileNotFoundError:
                continue
            reason = str(error).partition(";")[0]
            warnings.warn(f"{reason}; it was moved to {kept} and is done again", RuntimeWarning, stacklevel=3)


def clear(folder: Path, claims: Claims) -> None:
    """Remove what killed writers left half done: of members that nobody computes now, and beside them."""
    for path in member_files(folder):
        if is_temporary(path.name) and not claims.claimed(path.name[1:].partition(".")[0]):
            path.unlink(missing_ok=True)  # a writer without a claim, if there is one, writes it again
    for path in folder.iterdir():
        if _BEGUN.fullmatch(path.name) and is_temporary(path.name):
            path.unlink(missing_ok=True)  # so does a process that is at work


def member_files(folder: Path) -> list[Path]:
    """Return the members of a run folder, whole or begun; what else lies there is somebody's own."""
    return sorted(path for path in (folder / "realizations").iterdir() if _MEMBER.fullmatch(path.name))
