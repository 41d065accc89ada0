"""run.json, the description of a run, and the state of a folder in which a run may begin."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, Self

from roughsim.errors import RecordError
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics
from roughsim.show.remarks import Remark
from roughsim.store.disk import checksum, is_temporary, make_folder, place_bytes, read_bytes
from roughsim.store.member_files import FORMAT, check_format

_KINDS = {"run": "a run of drawn surfaces", "map": "a pressed map"}
MOST_BYTES = 1 << 20  # of run.json and scene.toml: a scene has at most 64 KiB
_BEGUN = {"claims", "members"}  # names that a start may have made before run.json


@dataclass(frozen=True, slots=True)
class RunDescription:
    """Scene and numerics of a run, as run.json has them."""

    scene: Mapping[str, Any]  # the identity of the scene
    numerics: Numerics  # with the reasons of the plan
    versions: Mapping[str, str]  # of the process that began the run
    # of a pressed map alone: the way to make it periodic, and the checksum of its heights
    press: Mapping[str, str] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """The kind of the run, a key of `_KINDS`."""
        return "map" if self.press else "run"

    def write(self, folder: Path, scene: Scene, *, first: bool = False) -> None:
        """Write run.json and scene.toml before any slow work; with `first`, FileExistsError if another process has.

        RecordError if the folder is a link that leads nowhere.
        """
        make_folder(folder / "members")
        values = {
            "format_version": FORMAT,
            "scene": self.scene,
            "numerics": self.numerics.to_dict(),
            "reasons": [list(reason.row) for reason in self.numerics.reasons],
            "versions": self.versions,
            "kind": self.kind,
            **({"press": self.press} if self.press else {}),
        }
        guarded = values | {"checksums": {key: checksum(value) for key, value in values.items()}}
        for name, text in (
            ("run.json", json.dumps(guarded, indent=1) + "\n"),
            ("scene.toml", scene.to_toml()),
        ):
            path = folder / name
            # an equal file is not written again: a finished run on a full or read-only disk can be opened
            if first or not path.is_file() or path.read_bytes() != text.encode():
                place_bytes(
                    path, text.encode(), first=first and name == "run.json"
                )  # the first process writes both

    def refuse_other(self, folder: Path, stored: Self) -> None:
        """Refuse a folder with another kind of run, scene, map or numerics: RecordError with the first such key."""
        if stored.kind != self.kind:
            raise RecordError(
                f"{folder} holds {_KINDS[stored.kind]}, not {_KINDS[self.kind]}; name another folder"
            )
        there, here = ({**of.press, **of.scene, **of.numerics.to_dict()} for of in (stored, self))
        for key in there | here:
            old = there.get(key, "absent")
            new = here.get(key, "absent")
            if old != new and key != "keep_fields":
                raise RecordError(
                    f"{folder} holds another scene: {key} is {old} there and {new} here; name another folder, or give "
                    "the scene as it was"
                )


def read_description(folder: Path) -> RunDescription:
    """Return the description of a run.

    RecordError if the folder is no run, has another format, or if a value in run.json was changed by hand, with the
    key. OSError if run.json cannot be read now.
    """
    path = folder / "run.json"
    if not folder.exists():
        raise RecordError(
            f"{folder} does not exist; start it with `roughsim run` or `roughsim press`"
        )
    if folder.is_file():
        raise RecordError(f"{folder} is a file; name the folder of a run")
    try:
        content: dict[str, Any] = json.loads(read_bytes(path, MOST_BYTES).decode("utf-8"))
        version, checksums = int(content["format_version"]), content.pop("checksums", None)
    except RecordError:
        raise
    except FileNotFoundError:
        if (folder / "study.json").exists():
            raise RecordError(
                f"{folder} is a study; name the folder of one of its points, in points/"
            ) from None
        raise RecordError(
            f"{folder} is no run: it has no run.json; name the folder that `roughsim run` made"
        ) from None
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise RecordError(f"{path} is damaged ({error})") from error
    _check_format(path, version, content)
    expected = checksums if isinstance(checksums, dict) else {}
    for key in expected | content:
        if key not in content or expected.get(key) != checksum(content[key]):
            raise RecordError(
                f"{key} in {path} was changed since the run wrote it; put the old value back, or give the scene "
                f"that you want to a new folder"
            )
    try:  # a forger can make checksums too
        rows = (map(str, words) for words in content["reasons"])
        reasons = tuple(Remark("choice", key, why, value) for key, value, why in rows)
        numerics = replace(Numerics.from_dict(content["numerics"]), reasons=reasons)
        return RunDescription(
            content["scene"], numerics, content["versions"], content.get("press", {})
        )
    except (ValueError, LookupError, TypeError, AttributeError) as error:
        raise RecordError(f"{folder} cannot be opened: {error}") from error


def _check_format(path: Path, version: int, content: Mapping[str, Any]) -> None:
    """Refuse another format than the one of a kind of run: RecordError with advice."""
    if version < FORMAT and content.get("kind") in ("map", "quarters"):
        raise RecordError(
            f"{path} is of a pressed map in the older format {version}; press the map again, into a new folder"
        )
    check_format(path, version, content)


def folder_state(folder: Path) -> Literal["free", "run", "foreign"]:
    """Return the state of a folder: a run can start ("free"), can continue ("run"), or is refused ("foreign").

    "free": the folder does not exist, is empty, or holds only files of a start interrupted before run.json.
    "run": it has a run.json. "foreign": it is a file, or holds other files.
    """
    if not folder.exists():
        return "free"
    if not folder.is_dir():
        return "foreign"
    names = {path.name for path in folder.iterdir() if not is_temporary(path.name)}
    # a scene.toml alone may be a user's own file: `write` makes the folder for the members before it
    begun = _BEGUN | {"scene.toml"} if "members" in names else _BEGUN
    inside = folder / "members"
    empty = (
        all(is_temporary(path.name) for path in inside.iterdir())
        if inside.is_dir()
        else not inside.exists()
    )
    if (
        folder / "run.json"
    ).exists():  # at last: another process may have made it meanwhile, with all before
        return "run"
    return "free" if empty and not names - begun else "foreign"


def content_of(folder: Path) -> str:
    """Return the content of a file or folder that prevents a new run or study, in words."""
    if folder.is_file():
        return "is a file"
    words = {"study.json": "holds a study", "run.json": "holds a run"}
    return next((words[name] for name in words if (folder / name).exists()), "holds other files")
