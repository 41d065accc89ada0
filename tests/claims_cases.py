"""Claims of processes that are not there."""

ONE, TWO = "L0-000000", "L0-000001"


def silent(folder, name="elsewhere-1-ab", *, host="elsewhere", pid=1, space="unknown"):
    """A process that has left its file and a claim, and gives no sign of life."""
    (folder / "claims").mkdir(parents=True, exist_ok=True)
    (folder / "claims" / f"process-{name}").write_text(f"{7:020d}\n{host} {pid} {space}\n")
    (folder / "claims" / ONE).write_text(name)
