"""Claims of processes that are not there."""

import json

ONE, TWO = "L0-000000", "L0-000001"


def silent(folder, name="elsewhere-1-ab", **told):
    """A process that has left its file and a claim, and gives no sign of life."""
    (folder / "claims").mkdir(parents=True, exist_ok=True)
    told = {"host": "elsewhere", "pid": 1, "space": None} | told
    (folder / "claims" / f"process-{name}").write_text(f"{7:020d}\n{json.dumps(told)}\n")
    (folder / "claims" / ONE).write_text(name)
