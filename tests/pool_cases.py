"""Members to do, and pools for them that tests hand in."""

from concurrent.futures import Executor, Future

import roughsim as rs
from roughsim.ensemble import tasks, workforce
from roughsim.ensemble.run import aimed
from roughsim.store.claims import Claims


def to_do(scene, folder):
    run = rs.run(scene, folder, max_realizations=1)
    run.max_realizations = 2
    scene = aimed(scene, max_realizations=2)
    return tasks.Tasks([tasks.ActiveRun(scene, run.numerics, folder, run)], Claims(folder), lambda: None)


class Force(workforce.Workforce):
    """Pools that are handed in."""

    def __init__(self, *pools):
        super().__init__(2, None)
        self.pools, self.used = iter(pools), 0

    def pool(self):
        self.used += 1
        return next(self.pools)


class Forgetful(Executor):
    """A pool that never comes back with what it was handed."""

    def submit(self, *_):
        future = Future()
        future.set_running_or_notify_cancel()
        return future
