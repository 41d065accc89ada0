"""Estimates on disk: what a run says when it ends, in estimates.json of its folder, for people, programs and `Run`.

They are read back where the run, the counts and the files of the members are those that they were made by.
"""

import json
from contextlib import suppress
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from roughsim.estimate.errors import SOURCES, Estimate
from roughsim.grid import Array
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.store.disk import checksum, place_bytes, read_bytes

ESTIMATES = "estimates.json"
MOST_BYTES = 16 << 20
ARRAYS = ("mean", "standard_error", "bias", "effective_n")
ABOUT = (
    "What this run says: means over its realizations with total errors (95 %) and their parts, in SI, over the speed. "
    "Temperatures are of the share heat_partition of the heat. It is made again if deleted."
)
Estimates = dict[str, dict[str, Estimate]]  # by column and observable


def save_estimates(folder: Path, made_by: dict[str, Any], about: dict[str, Any], estimates: Estimates) -> None:
    """Write estimates with what they were made by; a folder may take no files. `about` is for people alone."""
    columns = {column: {name: as_json(e) for name, e in by_name.items()} for column, by_name in estimates.items()}
    content = {**about, "made_by": made_by, "estimates": columns}
    content["checksum"] = checksum(content)
    with suppress(OSError):
        place_bytes(folder / ESTIMATES, (json.dumps(content, indent=1, allow_nan=False) + "\n").encode())


def load_estimates(folder: Path, made_by: dict[str, Any], speeds: int) -> Estimates:
    """Return the estimates in a folder; none if they are missing, damaged, or made by other members or code."""
    with suppress(OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError, MemoryError):
        content = json.loads(read_bytes(folder / ESTIMATES, MOST_BYTES))
        if content.pop("checksum") != checksum(content) or content["made_by"] != made_by:
            return {}
        return {
            str(column): {name: from_json(name, values, speeds) for name, values in by_name.items()}
            for column, by_name in content["estimates"].items()
        }
    return {}


def as_json(estimate: Estimate) -> dict[str, Any]:
    """Return an estimate as JSON values in SI: no number is null, an infinite one is text."""
    arrays = {name: plain_numbers(getattr(estimate, name)) for name in (*ARRAYS[:2], "total_error", *ARRAYS[2:])}
    budget = {name: plain_numbers(part) for name, part in estimate.budget.items()}
    return {"unit": estimate.unit, **arrays, "n": estimate.n, "budget": budget, "notes": list(estimate.notes)}


def from_json(name: str, values: dict[str, Any], speeds: int) -> Estimate:
    """Return the estimate that `as_json` described; ValueError, LookupError or TypeError if it is none."""
    record = OBSERVABLES[name]
    count = speeds if record.per_speed else 1
    if values["unit"] != record.unit or not {*values["budget"]} <= {*SOURCES}:
        raise ValueError(f"estimate of {name} has other units or parts of the error")
    arrays: Any = {key: array_of(values[key], count) for key in ARRAYS}
    budget = {part: array_of(numbers, count) for part, numbers in values["budget"].items()}
    notes = tuple(str(note) for note in values["notes"])
    return Estimate(budget=budget, observable=name, unit=record.unit, n=int(values["n"]), notes=notes, **arrays)


def plain_numbers(values: Array) -> list[float | str | None]:
    """Return numbers for JSON, which has no word for infinity."""
    return [None if np.isnan(x) else str(x) if np.isinf(x) else x for x in np.atleast_1d(values).tolist()]


def array_of(values: list[float | str | None], count: int) -> Array:
    """Return what `plain_numbers` described, `count` numbers; ValueError if it is something else."""
    numbers = np.array([nan if x is None else float(x) for x in values])
    if numbers.shape != (count,):
        raise ValueError(f"{numbers.shape} numbers in place of {count}")
    return numbers
