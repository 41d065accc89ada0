"""What a kept benchmark says of its machine: the processor and the versions, not its name."""


def pytest_benchmark_update_machine_info(config, machine_info):
    machine_info.pop("node", None)
