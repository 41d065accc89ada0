"""T_flash of steel over the nominal pressure: the study of docs/how-to/study.md, with its table and figure.

    python experiments/loads.py [--toy] [-o FOLDER] [--evidence]

A study of 20 loads of steel-1.2GPa to a total error of 2 %; --toy has two loads of the demo, to 20 %. The same command
goes on after a stop.
"""

import numpy as np
from script import EVIDENCE, Command, write_evidence

import roughsim as rs
from roughsim.studies.tables import study_table

LOAD = "sliding.nominal_pressure"
SHOWN = 0, 8, 16, 19  # rows of the table on the page


def tenfold(study):
    """Growth of T_flash at the highest speed from the lowest load to ten times that, per cent."""
    fastest = max(row["speed"] for row in study.rows() if row["speed"] is not None)
    rows = [
        row
        for row in study.rows()
        if row["observable"] == "flash_temperature" and row["speed"] == fastest
    ]
    rows = [row for row in rows if row["column"] == study.column]
    loads, means = (np.array([row[key] for row in rows]) for key in ("nominal_pressure", "value"))
    at_ten = np.interp(np.log(10 * loads[0]), np.log(loads), means)
    return 100 * (at_ten / means[0] - 1)


def main() -> None:
    options = Command(__file__, __doc__, "two loads of the demo, to 20 %").parse()
    loads = ["12 MPa", "360 MPa"] if options.toy else {"logspace": ["12 MPa", "360 MPa", 20]}
    study = rs.study(
        "demo" if options.toy else "steel-1.2GPa",
        vary={LOAD: loads},
        folder=options.output / "study",
        target_error=0.2 if options.toy else 0.02,
    )
    print(study)
    study.chart(options.output / "study.png", "flash_temperature")
    if options.evidence:
        table = study_table(study)
        cells = [table.cells(k) for k in range(len(table.columns))]
        rows = [
            [column.title for column in table.columns],
            *([column[k] for column in cells] for k in SHOWN),
        ]
        command = "python experiments/loads.py --evidence"
        write_evidence(
            "loads", command, tables={"flash": rows}, numbers={"tenfold": tenfold(study)}
        )
        study.chart(EVIDENCE.parent / "figures" / "study.png", "flash_temperature")


if __name__ == "__main__":
    main()
