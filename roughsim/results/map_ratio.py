"""map.json of a run: T_flash of the measured map itself over that of maps with its waves and random phases."""

import json
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from roughsim.errors import RecordError
from roughsim.grid import Array
from roughsim.show.remarks import Remark
from roughsim.store.disk import checksum, place_bytes, read_bytes

TWINS = 4
_MOST_BYTES = 1 << 16
_MORE = "`roughsim press` has its T_flash, with all errors"


class MapRatio(NamedTuple):
    """The ratio and its 95 % error at each speed, (speeds,); both empty if there is a `reason` that it is unknown."""

    ratio: Array
    error: Array
    points: tuple[int, int]  # of the grid
    reason: str = ""

    @property
    def statement(self) -> Remark:
        """The ratio, or why it is unknown, in words."""
        points = f"{self.points[0]} × {self.points[1]} points"
        if self.reason:
            return Remark("assumption", "map", f"{self.reason}; {_MORE}", f"not solved on {points}")
        low, high = (f"{x:.2f}" for x in (self.ratio.min(), self.ratio.max()))
        value = low if low == high else f"{low} … {high}"
        because = f"the map itself on {points}, over {TWINS} maps with its waves and random phases; {_MORE}"
        return Remark(
            "assumption",
            "map",
            because,
            f"{value} ± {self.error.max():.2f} times T_flash of drawn surfaces",
        )

    def write(self, folder: Path) -> None:
        """Write map.json into the folder of a run."""
        values = {
            name: each.tolist() if isinstance(each, np.ndarray) else each
            for name, each in self._asdict().items()
        }
        text = json.dumps(values | {"checksum": checksum(values)}, indent=1)
        place_bytes(folder / "map.json", f"{text}\n".encode())

    @classmethod
    def read(cls, folder: Path, speeds: int) -> Self | None:
        """Return the ratio of a run with so many speeds; None without one. RecordError if map.json was changed."""
        path = folder / "map.json"
        if not path.exists():
            return None
        try:
            stored: dict[str, Any] = json.loads(read_bytes(path, _MOST_BYTES))
            if stored.pop("checksum") != checksum(stored):
                raise ValueError("its checksum is wrong")
            ratio, error = (np.array(stored.pop(name), float) for name in ("ratio", "error"))
            x, y = stored.pop("points")
            found = cls(ratio, error, (int(x), int(y)), str(stored["reason"]))
            if {ratio.shape, error.shape} != {(0 if found.reason else speeds,)}:
                raise ValueError("its speeds are not those of the run")
        except (ValueError, LookupError, TypeError, AttributeError) as fault:
            raise RecordError(
                f"{path} is damaged ({fault}); delete it, and repeat the run"
            ) from fault
        return found
