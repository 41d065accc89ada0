"""When a run may stop: the first realization with which the targets of its statistical errors are met."""

import numpy as np

from roughsim.estimate.errors import looks, relative_half_width
from roughsim.estimate.ladder import values_of
from roughsim.observables.catalogue import OBSERVABLES
from roughsim.results.reader import Reader
from roughsim.results.share import has_own_share, times_share
from roughsim.scene import Scene


def last_needed(reader: Reader, scene: Scene, column: str, until: dict[str, float]) -> int | None:
    """Return the index of the realization with which a column meets the targets; None if all are too few.

    Numbers of realizations known to be too few are not tried again.
    """
    counts = looks(reader.insufficient(until) + 1, reader.members.count_sound(reader.available))
    if not counts:
        return None
    rows, levels = reader.members.sound(reader.available), reader.numerics.of_column(column)
    indices = np.array(rows, np.int64)
    with_share = has_own_share(scene) and any(OBSERVABLES[name].heated for name in until)
    names = dict.fromkeys([*until, *(["heat_partition"] if with_share else [])])
    samples = {
        name: [reader.sample(level, indices, with_spectra=needs_spectra(scene, name)) for level in levels]
        for name in names
    }
    for count in counts:
        first = {name: [sample.first(count) for sample in of_levels] for name, of_levels in samples.items()}
        values = {name: values_of(scene, column, name, of_levels) for name, of_levels in first.items()}
        if with_share:
            share = values["heat_partition"]
            values = {name: times_share(x, share) if OBSERVABLES[name].heated else x for name, x in values.items()}
        if all(relative_half_width(values[name]) <= goal for name, goal in until.items()):
            return rows[count - 1]
        reader.remember_insufficient(count, until)
    reader.save_now_and_then()
    return None


def needs_spectra(scene: Scene, observable: str) -> bool:
    """Return whether an observable needs the stress spectra: the share of the heat does by the rule "total" alone."""
    by_moments = observable == "heat_partition" and scene.sliding.heat_partition != "total"
    return OBSERVABLES[observable].spectra and not by_moments
