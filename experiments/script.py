"""What all scripts share: a command line with --toy and -o FOLDER, and figures that need no screen."""

import argparse
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")


class Command(argparse.ArgumentParser):
    """The command line of a script; `toy` says what its quick size leaves out."""

    def __init__(self, file: str, doc: str | None, toy: str = "small and quick, to see it work"):
        super().__init__(description=(doc or "").splitlines()[0])
        self.add_argument("--toy", action="store_true", help=toy.replace("%", "%%"))
        folder = Path("runs") / Path(file).stem
        self.add_argument("-o", "--output", type=Path, default=folder, help=f"folder of all that is written: {folder}")

    def parse(self) -> argparse.Namespace:
        """Return the options; the folder is there by then."""
        options = self.parse_args()
        options.output.mkdir(parents=True, exist_ok=True)
        return options
