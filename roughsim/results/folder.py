"""Opening a run folder, and lines on members that are missing or damaged.

A folder may come from elsewhere, so nothing in it is trusted.
"""

from pathlib import Path

from roughsim.errors import RecordError
from roughsim.machine import available_memory, exceeds, in_words
from roughsim.results.description import MOST_BYTES, read_description
from roughsim.results.members import Damaged
from roughsim.results.run import Run
from roughsim.scene import Scene, parse_scene
from roughsim.store.claims import writer
from roughsim.store.disk import read_bytes
from roughsim.store.member_files import AGAIN

_NAMED = 5  # members that a line names; of others it gives the number


def open_run(folder: str | Path, *, damaged: Damaged = "refuse") -> Run:
    """Open a run folder for reading, also while another process writes to it.

    Parameters
    ----------
    folder : str or Path
        The folder of a run.
    damaged : {"refuse", "skip", "redo"}, optional
        Treatment of a damaged file: "refuse" raises RecordError with the name of the file. "skip" opens the run, counts
        the members that are lost as failed, and adds the reason to `Run.damaged`. "redo", for runs that compute them
        again, also moves the file into the folder "damaged" with a warning.

    Returns
    -------
    Run
        With `estimate`, `samples` and `correlation`.

    Raises
    ------
    RecordError
        If it is no run, of another format, or one of its files is damaged.
    """
    run = unread_run(Path(folder), damaged)
    run.refresh()
    return run


def unread_run(folder: Path, damaged: Damaged, scene: Scene | None = None) -> Run:
    """Return the run of a folder before its members are read, by `Run.refresh`; arguments and errors as `open_run`.

    `scene` is the scene that this process has written to the folder; None reads it.
    """
    description, path = read_description(folder), folder / "scene.toml"
    try:
        if scene is None:
            # roughsim stores tables inline in scene.toml: a scene with names of files is not its own
            scene = parse_scene(read_bytes(path, MOST_BYTES).decode("utf-8"), source=str(path))
        stored, written = dict(description.scene), scene.identity()
        if stored != written:
            key = next(
                (key for key in stored | written if stored.get(key) != written.get(key)), "a key"
            )
            raise ValueError(
                f"run.json and scene.toml are of different scenes: {key} differs; undo the edit"
            )
        most = max(level.shape[0] * level.shape[1] for level in description.numerics.levels)
        if exceeds(8.0 * most, 0.5):
            needed = f"{8e-9 * most:.3g} GB, more than half of the {in_words(available_memory())}"
            raise ValueError(
                f"run.json: a field of {most} points needs {needed}; open the run on a larger machine"
            )
        return Run(folder, description, scene, damaged)
    except (ValueError, LookupError, TypeError, AttributeError) as error:
        raise RecordError(f"{folder} cannot be opened: {error}") from error


def gap(run: Run) -> list[str]:
    """Return a line on gaps, members that are missing although later ones exist; empty without gaps.

    They are lost if no process computes the run now; this check takes a few seconds.
    """
    if not run.missing:
        return []
    process, count = writer(run.folder), f"only the {run.realizations} realizations before count"
    if process:
        return [
            f"not there yet: {_listed(run.missing)}; {process} computes the run now; {count} so far"
        ]
    missing = open_run(
        run.folder, damaged="skip"
    ).missing  # a process may have ended the run meanwhile
    return [f"lost: {_listed(missing)}; {count}; {AGAIN} to have them"] if missing else []


def left_out(run: Run) -> list[str]:
    """Return a line each on missing and on damaged members, with the consequence; empty for a complete run."""
    names = _listed([*run.damaged])
    damaged = [f"damaged and left out of the means: {names}; {AGAIN} to have them"] if names else []
    return gap(run) + damaged


def _listed(names: list[str]) -> str:
    """Return the first names, and the number of further ones."""
    return ", ".join(names[:_NAMED]) + (
        f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    )
