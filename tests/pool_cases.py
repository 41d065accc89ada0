"""Members to do, and pools for them that tests hand in."""

import roughsim as rs
from roughsim.ensemble import executors, tasks
from roughsim.store.claims import Claims


def to_do(scene, folder):
    run = rs.run(scene, folder, max_realizations=1)
    run.max_realizations = 2
    run.refresh()
    return tasks.Tasks([run], Claims(folder))


class GivenPools(executors.Workers):
    """Two workers of own pools that a test hands in, one after the other."""

    def __init__(self, *pools):
        super().__init__(2)
        self.pools, self.current, self.used = iter(pools), None, 0

    def executor(self, seconds_left):
        if self.current is None:
            self.used += 1
            self.current = next(self.pools)
        return self.current

    def replace_broken(self, error):
        self.current = None
        super().replace_broken(error)
