"""Pictures that commands of the pages draw: the snapshots of docs/explore.md, and the reactions of docs/reactions.md.

    python experiments/pictures.py [--toy] [-o FOLDER] [--evidence]

Runs the commands in FOLDER. --evidence copies the pictures to docs/figures; --toy draws the snapshots alone.
"""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

from script import Command, show_on_pages

REACTS = "--set 'sliding.background_temperature=700 K' --set 'reaction.prefactor=1e13 1/s'"
PICTURES = {
    "snapshots": (
        "run demo --set sliding.history=sliding --set sliding.slid_distance=4mm --target-error 50% --max 2 -o sliding",
        "plot sliding snapshots --speed 35 --size 7.2x3.8 --no-title --dpi 200 -o snapshots.png",
    ),
    "reactions_of_steel": (
        f'run steel-1.2GPa {REACTS} --set \'reaction.activation_energy=["0.6 eV", "1.5 eV"]\' -o reacts',
        "plot reacts reaction --size 5.2x2.7 --dpi 200 -o reactions_of_steel.png",
    ),
}


def draw(folder: Path, lines: tuple[str, ...]) -> None:
    """Run commands in a folder, one after the other."""
    for line in lines:
        print(f"$ roughsim {line}", flush=True)
        subprocess.run(
            [sys.executable, "-m", "roughsim", *shlex.split(line)], cwd=folder, check=True
        )


def main() -> None:
    options = Command(__file__, __doc__, "the snapshots alone").parse()
    names = ["snapshots"] if options.toy else list(PICTURES)
    for name in names:
        draw(options.output, PICTURES[name])
    if options.evidence:
        show_on_pages(*(options.output / f"{name}.png" for name in names))


if __name__ == "__main__":
    main()
