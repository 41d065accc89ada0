"""What a kept benchmark says: the processor and the versions, not whose machine it is, and the commit it measured."""

import os


def pytest_benchmark_update_machine_info(config, machine_info):
    machine_info.pop("node", None)


def pytest_benchmark_generate_commit_info(config):
    return {"id": os.environ.get("MEASURED", "this tree")}
