"""Storms of SIGKILL on runs and presses: the end has the same bits as without a kill.

    python tests/ensemble/storms.py [--kills 60] [-o FOLDER]

Members are saved every 0.03 s, in parts of 24. Each storm kills a random process, a moment after a member was stored,
and starts the same command again. Each run that has ended is compared with an undisturbed one, and the next run begins
in a new folder.
"""

import argparse
import os
import random
import time
import warnings
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path

import numpy as np

import roughsim as rs
from roughsim.ensemble import sources, tasks
from roughsim.store import saving
from roughsim.store.member_files import fields_path, read_fields
from roughsim.store.parts import read_part

MOST = 60  # members of the lowest level
PATIENCE = 100.0  # s to wait for a member
PAUSE = 0.3  # s at most, from a member to the next kill
# s more that a process which has workers takes for a member: they have started before all members are computed
SLOWER = {"run": 0.05, "press": 0.3}
SURFACE = {
    "run": 'rms_height = "0.9 um"\nhurst = 0.8\nq_min = 6350\nq_roll_off = 2e4\nq_max = 2e5',
    "press": 'topography = "map.npy"\ntopography_size = [1e-3, 1e-3]\ntopography_unit = "um"',
}
NUMERICS = """
[numerics]
lengths = [2e-3, 2e-3]
levels = [
  { column = "capped", shape = [64, 64], q_max = 5e4 },
  { column = "capped", shape = [256, 256], q_max = 2e5 },
]
"""
SCENE = """
[surface]
{surface}
[body]
youngs_modulus = "200 GPa"
poisson_ratio = 0.3
penetration_hardness = "1 GPa"
conductivity = 30
density = 7900
heat_capacity = 500
[counterface]
youngs_modulus = "200 GPa"
poisson_ratio = 0.3
conductivity = 30
density = 7900
heat_capacity = 500
[sliding]
nominal_pressure = "90 MPa"
friction_coefficient = 0.11
speed = [0.1, 35]
heat_partition = 0.9
{numerics}
"""
COMMANDS = {
    "one writer": (1, 1),
    "two workers": (1, 2),
    "three processes": (3, 1),
}  # commands at once, workers of each


@dataclass
class Tally:
    """Counts of a storm."""

    kills: int = 0
    of_workers: int = 0
    runs: int = 0
    members: int = 0
    between: list[int] = field(default_factory=list)  # members stored between two kills

    def __str__(self):
        idle = sum(not written for written in self.between)
        return (
            f"{self.kills} kills ({self.of_workers} of worker processes), {self.runs} runs with {self.members} "
            f"members, all with the bits of the undisturbed run; {np.mean(self.between):.1f} members between two "
            f"kills, none between {idle}"
        )


def write_scene(folder, verb):
    """Write the scene of a run, or a map and the scene of its press; return the path of the scene."""
    folder.mkdir(parents=True, exist_ok=True)
    if verb == "press":
        grid = rs.Grid((64, 64), (1e-3, 1e-3))
        spectrum = rs.SelfAffineSpectrum.from_rms_height(3e-7, hurst=0.8, q_min=6.3e3, q_max=9e4)
        np.save(folder / "map.npy", 1e6 * rs.synthesize(spectrum, grid, np.random.default_rng(2)))
    path = folder / "scene.toml"
    path.write_text(SCENE.format(surface=SURFACE[verb], numerics=NUMERICS if verb == "run" else ""))
    return path


def compute(verb, scene, home, workers):
    """Compute or resume a run or a press."""
    warnings.simplefilter("ignore")
    tasks.INTERVAL, tasks.SHARE, saving.MOST = 0.03, 1.0, 24
    if workers > 1:
        genuine = sources.solve_problem
        sources.solve_problem = lambda *rest: (time.sleep(SLOWER[verb]), genuine(*rest))[1]
    if verb == "press":
        rs.press(scene, home, workers=workers)
    else:
        rs.run(rs.load_scene(scene), home, workers=workers, max_realizations=MOST, until={})


def stored(folder):
    """Return the members in the files of a run, as they are at one moment; none of a folder without a run."""
    while True:
        try:
            members = [one for path in saving.listed(folder) for one in read_part(path).members]
            return {(one.level, one.index): one for one in members}
        except OSError:
            continue  # another process has moved a file


def children(pid):
    """Return the processes that a process has started."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = entry.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == pid and fields[0] != "Z":
            found.append(int(entry.parent.name))
    return found


def semaphores(pid):
    """Return the semaphores that a process has open."""
    try:
        words = Path(f"/proc/{pid}/maps").read_text().split()
    except OSError:
        return set()  # it has ended
    return {Path(word) for word in words if word.startswith("/dev/shm/sem.")}


def started_workers(pid):
    """Return the workers of a process that have begun to take tasks from the queue of their pool."""
    return [child for child in children(pid) if semaphores(child)]


def assert_same_bits(folder, undisturbed):
    """Check all members of a run against those of an undisturbed one, and that nothing else is left."""
    found, wanted = stored(folder), stored(undisturbed)
    assert found.keys() >= wanted.keys()
    for key, theirs in wanted.items():
        mine = found[key]
        assert len(mine.moments) == len(theirs.moments) > 0
        for one, other in zip(mine.moments, theirs.moments, strict=True):
            np.testing.assert_array_equal(one.spectrum, other.spectrum)
            for number, values in other.numbers.items():
                np.testing.assert_array_equal(one.numbers[number], values)
        assert mine.provenance.get("directions") == theirs.provenance.get("directions")
        if theirs.kept:
            own, others = (
                read_fields(fields_path(home, *key))[1] for home in (folder, undisturbed)
            )
            assert all((own[name] == values).all() for name, values in others.items())
    found, expected = (
        rs.open_run(home).estimate("flash_temperature") for home in (folder, undisturbed)
    )
    np.testing.assert_array_equal(found.mean, expected.mean)
    np.testing.assert_array_equal(found.total_error, expected.total_error)
    names = {"fields", "members", "members.h5", "run.json", "scene.toml"}
    assert {path.name for path in folder.iterdir()} <= names
    assert not list((folder / "members").iterdir())
    assert not list(folder.glob("**/.*"))


class Storm:
    """Kills at random moments, and the same command again after each."""

    def __init__(self, folder, verb, mode, seed=1):
        self.folder, self.verb, self.mode = folder, verb, mode
        self.random = random.Random(seed)
        self.commands, self.workers = COMMANDS[mode]
        self.scene = write_scene(folder, verb)
        self.tally = Tally()

    def start(self, home):
        """Start a process that computes a run; a fork has all compiled functions loaded."""
        process = get_context("fork").Process(
            target=compute, args=(self.verb, self.scene, home, self.workers)
        )
        process.start()
        return process

    def rage(self, kills):
        """Kill so many times, in as many runs as it takes; return the counts."""
        expected = self.folder / "undisturbed"
        compute(self.verb, self.scene, expected, 1)
        while self.tally.kills < kills:
            home = self.folder / f"run-{self.tally.runs}"
            self.one_run(home, kills)
            assert_same_bits(home, expected)
            self.tally.runs += 1
            self.tally.members += len(stored(expected))
        return self.tally

    def one_run(self, home, kills):
        """Kill and restart the commands of one run until it has ended."""
        processes = [self.start(home) for _ in range(self.commands)]
        try:
            self.disturb(home, kills, processes)
            for process in processes:
                process.join(600.0)
                assert process.exitcode == 0
        finally:
            for process in processes:
                process.kill()

    def disturb(self, home, kills, processes):
        """Kill processes at random moments, and start them again, while one of them works and kills are left."""
        before = {}
        while self.tally.kills < kills:
            after = self.wait_for_member(home, len(before), processes)
            if after is None:
                break
            time.sleep(self.random.uniform(0.0, PAUSE))
            victim = self.random.randrange(self.commands)
            pid = processes[victim].pid
            if self.workers > 1 and self.tally.kills % 2 == 0:
                pid = self.wait_for_worker(processes[victim])
            if not processes[victim].is_alive():
                break
            os.kill(pid, 9)
            self.tally.kills += 1
            if pid == processes[victim].pid:
                processes[victim].join()
                processes[victim] = self.start(home)
            else:
                self.tally.of_workers += 1
            now = stored(home)
            lost = [key for key in before if key not in now]
            assert not lost, lost
            if self.mode == "one writer":
                about = {key: member.provenance["written"] for key, member in now.items()}
                assert all(
                    about[key] == member.provenance["written"] for key, member in before.items()
                )
            self.tally.between.append(len(now) - len(before))
            before = now

    def wait_for_worker(self, process):
        """Wait until a process has a worker that takes tasks; None if the process has ended."""
        while process.is_alive():
            if workers := started_workers(process.pid):
                return self.random.choice(workers)
            time.sleep(0.005)
        return None

    def wait_for_member(self, home, number, processes):
        """Wait until more members than this number are stored; None if a process has ended."""
        patience = time.monotonic() + PATIENCE
        while (count := len(stored(home))) <= number and time.monotonic() < patience:
            if not all(process.is_alive() for process in processes):
                return None
            time.sleep(0.005)
        return count


def main():
    """Let all storms rage, and print their counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=60)
    parser.add_argument("--only", default="", help="part of the name of a storm")
    parser.add_argument("-o", "--output", type=Path, default=Path("runs/storms"))
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    for verb in SURFACE:
        for mode in COMMANDS:
            if options.only in f"{verb}, {mode}":
                began = time.monotonic()
                tally = Storm(options.output / f"{verb}-{mode.replace(' ', '-')}", verb, mode).rage(
                    options.kills
                )
                print(f"{verb}, {mode}: {tally}; {time.monotonic() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
