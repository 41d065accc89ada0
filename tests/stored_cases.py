"""Members of runs on disk, one by one: to read, to change, to lose, and to damage."""

import json
from dataclasses import replace

from roughsim.store.member_files import fields_path, read_fields, write_fields
from roughsim.store.parts import of_run, read_part, write_part
from roughsim.store.saving import listed

OF_RUN = {"scene": {}, "numerics": {}}


def member_path(folder, level, index):
    """The place of a part with one member, as `split_members` leaves it."""
    return folder / "members" / f"L{level}-{index:06d}.h5"


def split_members(folder):
    """Give each member of a run a part of its own."""
    for path in listed(folder):
        header, members = read_part(path)
        for member in members:
            target = member_path(folder, member.level, member.index)
            write_part(target, of_run(header), [member])
        if path.name != f"L{members[0].level}-{members[0].index:06d}.h5":
            path.unlink()
    return folder


def read_file(path):
    """The only member of a part, with its kept fields."""
    (member,) = read_part(path).members
    return with_fields(path.parents[1], member)


def with_fields(folder, member):
    if not member.kept:
        return member
    path = fields_path(folder, member.level, member.index)
    return replace(member, fields=read_fields(path)[1])


def read_member(folder, level, index):
    """A member of a run, whatever file it is in, with its kept fields."""
    for path in listed(folder):
        for member in read_part(path).members:
            if (member.level, member.index) == (level, index):
                return with_fields(folder, member)
    raise LookupError(f"{folder} has no member {level}, {index}")


def members_of(folder):
    """All members of a run by level and index, without fields."""
    members = [member for path in listed(folder) for member in read_part(path).members]
    return {(member.level, member.index): member for member in members}


def count_members(folder):
    """The number of members of a run that other processes compute; 0 while they move a file."""
    try:
        return len(members_of(folder))
    except OSError:
        return 0


def write_member(folder, member, about=None):
    """Write a member into a part of its own, with its fields, as of the run in the folder."""
    if about is None:
        description = folder / "run.json"
        about = of_run(json.loads(description.read_text())) if description.exists() else OF_RUN
    if member.fields:
        shapes = {name: values.shape for name, values in member.fields.items()}
        write_fields(folder, about, member)
        member = replace(member, fields={}, kept=shapes)
    write_part(member_path(folder, member.level, member.index), about, [member])
