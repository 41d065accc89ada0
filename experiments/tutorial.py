"""What the commands of the tutorial print and draw: docs/evidence/tutorial.json, with which its blocks are compared.

    python experiments/tutorial.py [--toy] [-o FOLDER] [--evidence]

Runs the commands of docs/start/tutorial.md in FOLDER, one after the other; a run that is there is deleted first. --toy
leaves out the run and all that reads it, and draws the theory.
"""

import shlex
import shutil
import subprocess
import sys

from script import EVIDENCE, Command, write_evidence

import roughsim as rs

SPEED = 35.0  # m/s
COMMANDS = {
    "theory": "theory my.toml",
    "plan": "plan my.toml",
    "run": "run my.toml -o runs/my",
    "compare": "compare runs/my --chart comparison.png",
    "plot": "plot runs/my temperature --speed 35 -o temperature.png",
}
DRAWN = "comparison", "temperature"  # on the page
PYTHON = """
import roughsim as rs

run = rs.open_run("runs/my")
flash = run.estimate("flash_temperature")
print(flash.mean.round(1))
print(flash.explain())
"""


def printed(folder, words):
    """Return what a command prints, of which its warnings are a part."""
    command = [sys.executable, *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout + done.stderr


def numbers_of(folder):
    """Return the numbers of the text, all at 35 m/s: theory, and ratios in per cent."""
    rows = {
        row.observable: row
        for row in rs.compare(rs.open_run(folder / "runs" / "my")).rows
        if row.speed == SPEED
    }
    flash = rows["flash_temperature"]
    return {
        "theory": flash.theory,
        "width": 1e6 * rows["flash_width"].theory,
        "hotter": 100 * float(flash.ratios["smoothed_over_theory"].mean - 1),
        "left": 100 * float(flash.ratios["capped_over_smoothed"].mean),
    }


def main() -> None:
    options = Command(__file__, __doc__, "theory and plan alone").parse()
    folder, texts = options.output, {}
    shutil.rmtree(folder / "runs", ignore_errors=True)
    scene = printed(folder, ["-m", "roughsim", "new", "demo"])
    (folder / "my.toml").write_text(scene, encoding="utf-8")
    for name, line in COMMANDS.items():
        if options.toy and name in ("run", "compare", "plot"):
            line = "theory my.toml --chart theory.png"  # noqa: PLW2901
        texts[name] = printed(folder, ["-m", "roughsim", *shlex.split(line)])
        print(f"$ roughsim {line}\n{texts[name]}")
    if not options.toy:
        texts["python"] = printed(folder, ["-c", PYTHON])
        print(texts["python"])
    if options.evidence:
        command = "python experiments/tutorial.py --evidence"
        write_evidence("tutorial", command, texts=texts, numbers=numbers_of(folder))
        for name in DRAWN:
            shutil.copyfile(
                folder / f"{name}.png", EVIDENCE.parent / "figures" / f"tutorial_{name}.png"
            )


if __name__ == "__main__":
    main()
