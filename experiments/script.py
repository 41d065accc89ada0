"""What all scripts share: a command line with --toy and -o FOLDER, figures that need no screen, rows that are kept."""

import argparse
import json
import platform
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl

import roughsim
from roughsim.errors import RecordError
from roughsim.store.disk import place_bytes

mpl.use("Agg")
Row = dict[str, float | str]
CONTENT = "rows of roughsim"
EVIDENCE = Path(__file__).resolve().parents[1] / "docs" / "evidence"


class Command(argparse.ArgumentParser):
    """The command line of a script; `toy` says what its quick size leaves out."""

    def __init__(self, file: str, doc: str | None, toy: str = "small and quick, to see it work"):
        super().__init__(description=(doc or "").splitlines()[0])
        self.add_argument("--toy", action="store_true", help=toy.replace("%", "%%"))
        folder = Path("runs") / Path(file).stem
        self.add_argument(
            "-o",
            "--output",
            type=Path,
            default=folder,
            help=f"folder of all that is written: {folder}",
        )
        self.add_argument(
            "--evidence", action="store_true", help="write the file of docs/evidence, too"
        )

    def parse(self) -> argparse.Namespace:
        """Return the options; the folder is there by then."""
        options = self.parse_args()
        options.output.mkdir(parents=True, exist_ok=True)
        return options


class Rows:
    """Named rows of a long computation, in a JSON file that is whole after each; with `resume` those of it are kept.

    RecordError if the file to resume holds no rows.
    """

    def __init__(self, path: Path, *, resume: bool = False):
        self.path = path
        self._tables: dict[
            str, dict[str, Row]
        ] = {}  # rows by table and name, in the order in which they came
        if resume and self.path.exists():
            try:
                self._tables = dict(json.loads(self.path.read_text("utf-8"))[CONTENT])
            except (ValueError, LookupError, TypeError) as error:
                raise RecordError(
                    f"{path} holds no rows to go on with ({error}); give another path"
                ) from error

    def __getitem__(self, table: str) -> dict[str, Row]:
        """The rows of a table by name."""
        return dict(self._tables.get(table, {}))

    def once(self, table: str, name: str, compute: Callable[[], Row]) -> Row:
        """Return the row of this name: the stored one, or what `compute` gives, stored before it is returned."""
        if name not in self[table]:
            self.extend(table, {name: compute()})
        return self._tables[table][name]

    def extend(self, table: str, rows: dict[str, Row]) -> None:
        """Store several rows at once."""
        self._tables.setdefault(table, {}).update(rows)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        place_bytes(self.path, json.dumps({CONTENT: self._tables}, indent=1).encode())


def show_on_pages(*pictures: Path) -> None:
    """Copy pictures to docs/figures under their own names."""
    for picture in pictures:
        shutil.copyfile(picture, EVIDENCE.parent / "figures" / picture.name)


def processor() -> str:
    """Return the name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next(
        (line.partition(": ")[2] for line in lines if line.startswith("model name")),
        platform.machine(),
    )


def write_evidence(name: str, command: str, **content: Any) -> None:
    """Write docs/evidence/NAME.json, of which docs/evidence.py makes tables and figures, and compares pages.

    `content` may have `rows`, the measured numbers as they are, `numbers`, which pages quote by their name, `tables` of
    cells as they are printed, the first row their heads, and `texts`, the output of commands.
    """
    origin = {"command": command, "version": roughsim.__version__, "processor": processor()}
    EVIDENCE.mkdir(exist_ok=True)
    text = json.dumps(origin | content, indent=1, ensure_ascii=False, default=float)
    place_bytes(EVIDENCE / f"{name}.json", f"{text}\n".encode())
