"""Files from elsewhere are not trusted: what an HDF5 file could reach or claim is looked at before anything is read."""

from roughsim.untrusted.checks import check_hdf5, check_measured_file, machine_memory, regular_file
from roughsim.untrusted.child_process import ChildEndedError, call_in_child

__all__ = ["ChildEndedError", "call_in_child", "check_hdf5", "check_measured_file", "machine_memory", "regular_file"]
