"""Runs on disk: many small files that are whole or absent, and the reader that makes estimates of them.

A run folder holds ``scene.toml``, ``run.json`` and ``realizations/L{level}-{index}.h5``. Each file is written beside
its place, forced to disk and then moved into it, so a killed run is a shorter run. Readers never block the writer.
"""

from roughsim.record.disk import is_temporary, set_aside
from roughsim.record.export import export_run
from roughsim.record.files import Member, check_member, member_path, read_member, write_member
from roughsim.record.folder import describe, folder_state, open_run, read_description
from roughsim.record.run import Run
from roughsim.record.surfaces import export_surface

__all__ = [
    "Member",
    "Run",
    "check_member",
    "describe",
    "export_run",
    "export_surface",
    "folder_state",
    "is_temporary",
    "member_path",
    "open_run",
    "read_description",
    "read_member",
    "set_aside",
    "write_member",
]
