"""The folder of a run on disk: which files hold its members, how a process saves its own, and how all become one file.

``RUN/members/OWNER-000.h5`` … are parts of at most 128 members. OWNER is the name of the process that wrote them, and
only this process writes its last part again, with more members. ``RUN/members.h5`` has all members of a finished run.
No process takes a lock. A file is removed only after another with all its members is on disk.
"""

import os
import random
import re
import secrets
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from roughsim.observables.member import Member
from roughsim.store.disk import not_readable, set_aside
from roughsim.store.member_files import write_fields
from roughsim.store.parts import Part, of_run, read_sound, write_part
from roughsim.untrusted import ChildEndedError, call_in_child

MOST = 128  # members of a part
WHOLE = "members.h5"
_PART = re.compile(r"\w[\w.-]*-\d{3,}\.h5")
_UNFINISHED = re.compile(r"\.(?:run\.json|scene\.toml|\w[\w.-]*\.h5)\.[\w-]+\.tmp")
_TRIES = 10  # to merge parts while other processes do
_PAUSE = 0.02  # s at most before the second try; twice as long before each later one
Stamp = tuple[int, int, int]  # of the content of a file: inode, time of writing, bytes


def part_path(folder: Path, owner: str, number: int) -> Path:
    """Return the place of a part in a run folder."""
    return folder / "members" / f"{owner}-{number:03d}.h5"


def listed(folder: Path) -> dict[Path, Stamp]:
    """Return the files with members of a run, with their stamps, as they are at one moment."""
    before, now = None, _stamps(folder)
    while now != before:  # else a file that is renamed meanwhile might be seen at neither place
        before, now = now, _stamps(folder)
    return {Path(path): stamp for path, stamp in sorted(now.items()) if stamp}


def _stamps(folder: Path) -> dict[str, Stamp | None]:
    """Return the stamps of files as they are found one after another; None for a file that has gone meanwhile."""
    paths = [str(folder / WHOLE)]
    with suppress(FileNotFoundError, NotADirectoryError), os.scandir(folder / "members") as entries:
        paths += [entry.path for entry in entries if _PART.fullmatch(entry.name)]
    found: dict[str, Stamp | None] = dict.fromkeys(paths)
    for path in paths:
        try:
            about = os.stat(path)
        except FileNotFoundError:
            continue
        except OSError as error:
            raise not_readable(Path(path), error) from error
        found[path] = about.st_ino, about.st_mtime_ns, about.st_size
    return found


class Saver:
    """The members that this process computes for a run, and the parts in which it saves them."""

    def __init__(self, folder: Path, owner: str, run: Mapping[str, Any]):
        self.folder, self.owner, self.run = folder, owner, run
        self._unsaved: list[Member] = []
        self._last: list[Member] = []  # members of the last part
        self._number = 0  # of the last part

    def add(self, member: Member) -> Member:
        """Take a member, and return it without its fields, which are on disk from now on; errors as `save`."""
        write_fields(self.folder, self.run, member)  # before the part that names them
        shapes = {name: values.shape for name, values in member.fields.items()}
        member = replace(member, fields={}, kept=shapes)
        self._unsaved.append(member)
        return member

    def save(self) -> int:
        """Save all members, and return the number of parts that were written.

        OSError, naming the file, if the disk refuses: what was saved before stays.
        """
        parts = 0
        while self._unsaved:
            room = MOST - len(self._last)
            members = self._last + self._unsaved[:room]
            write_part(part_path(self.folder, self.owner, self._number), self.run, members)
            self._last, self._unsaved = members, self._unsaved[room:]
            if len(members) == MOST:
                self._last, self._number = [], self._number + 1
            parts += 1
        return parts


def merge(folder: Path, owner: str, read: Callable[[], Part]) -> None:
    """Put all members of a finished run into one file.

    `read` reads the files that are new, and returns all members. `owner` is the name of this process. Any number of
    processes may merge at once: files of others are renamed first, so that what is read, and then removed, has no other
    name, and no other process writes it. On a file system without hard links the one file stays among the parts: no
    other way to place it refuses the file of another process.
    """
    whole = folder / WHOLE
    for tried in range(_TRIES):
        found = listed(folder)
        if not found.keys() - {whole}:
            return
        with suppress(FileNotFoundError, FileExistsError):  # another process merges, too
            if _merge_found(folder, owner, found, read):
                return  # without another look: each takes files until it has placed its own, so that all end
        time.sleep(random.uniform(0.0, _PAUSE * 2.0**tried))  # else they take turns for ever


def _merge_found(folder: Path, owner: str, found: Iterable[Path], read: Callable[[], Part]) -> bool:
    """Merge these files; False if another process may have done the same unseen, without hard links."""
    own = [_own(folder, path, owner) for path in found]
    merged = own[0]
    if len(own) > 1:
        part, merged = read(), _new_part(folder, owner)
        write_part(merged, of_run(part.header), part.members)
    kept = None
    try:
        os.link(merged, folder / WHOLE)
    except (FileNotFoundError, FileExistsError):
        raise
    except OSError:
        kept = merged
    for path in {*own, merged} - {kept}:
        path.unlink(missing_ok=True)
    return kept is None or len(own) == 1


def _own(folder: Path, path: Path, owner: str) -> Path:
    """Give a file with members a name of this process, whatever the file holds at this moment; return its path."""
    if path.name.startswith((f"{owner}-", f"{owner}.")):
        return path
    own = _new_part(folder, owner)
    os.rename(path, own)
    return own


def _new_part(folder: Path, owner: str) -> Path:
    """Return a new name of a part of a process, none of its `Saver`, which does not read its own files."""
    return part_path(folder, f"{owner}.{secrets.token_hex(4)}", 0)


def sound_part(path: Path) -> Part:
    """Return the members of a damaged file whose own digests match, read in a process of its own; or none."""
    try:
        part: Part = call_in_child(read_sound, path, seconds=5.0 + path.stat().st_size / 1e7)
    except (ChildEndedError, OSError):
        return Part({}, [])
    return part


def replace_damaged(path: Path, folder: Path, sound: Part) -> Path:
    """Move a damaged file of a run aside, after its sound members are in a new part; return its new path.

    FileNotFoundError if another process has moved it.
    """
    if sound.members:
        write_part(_new_part(folder, path.stem), of_run(sound.header), sound.members)
    return set_aside(path, folder / "damaged")


def remove_unfinished(folder: Path) -> None:
    """Remove the unfinished files of killed processes; a process that is at work on one writes it again."""
    for home in (folder, folder / "members", folder / "fields"):
        with suppress(FileNotFoundError):
            for path in home.iterdir():
                if _UNFINISHED.fullmatch(path.name):
                    path.unlink(missing_ok=True)
