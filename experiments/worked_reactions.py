"""What T_flash misses of reactions with barriers of the literature: oxidation of iron, a film from an additive.

    python experiments/worked_reactions.py [--toy] [-o FOLDER] [--evidence]

The scene steel-1.2GPa at 35 m/s, with all the heat in the moving body. Barriers: oxidation of iron at 96 kJ/mol above
and 208 kJ/mol below 450 °C (Quinn), the additive ZDDP at 0.8 eV with an activation volume of 3.8 Å³ (Gosvami et al.,
Science 348, 102, 2015). Above 1170 K contacts lose their strength in the model of flash weakening by Rice (J. Geophys.
Res. 111, B05311, 2006). None of these numbers is checked here.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from script import Command, write_evidence

import roughsim as rs
from roughsim.show.table import Number

SPEED, PREFACTOR, WEAK = 35.0, 1e13, 1170.0  # m/s, 1/s, K
MOLE = 96.485  # kJ/mol in an eV
BOLTZMANN, ELECTRONVOLT = 8.617333262e-5, 1.602176634e-19  # eV/K, J
OXIDATION, ADDITIVE = ("oxidation, hot", "oxidation, cold"), ("ZDDP",)
ENERGIES = {"oxidation, hot": 96 / MOLE, "oxidation, cold": 208 / MOLE, "ZDDP": 0.8}  # eV
HEADS = [
    "reaction",
    "E, eV",
    "T₀, K",
    "T₀ + T_flash, K",
    "T_act, K",
    "rate over the rate at T₀ + T_flash",
]


def computed(
    folder: Path, names: tuple[str, ...], background: float, *, toy: bool, **reaction: Any
) -> rs.Run:
    """Return the run of reactions at a background, K."""
    changes: dict[str, Any] = {
        "sliding.speed": [SPEED],
        "sliding.heat_partition": "all",
        "sliding.background_temperature": background,
        "reaction.activation_energy": [f"{ENERGIES[name]:.6g} eV" for name in names],
        "reaction.prefactor": f"{PREFACTOR:g} 1/s",
        "observables.heat_above": [WEAK],
    } | {f"reaction.{key}": value for key, value in reaction.items()}
    return rs.run(rs.load_scene("steel-1.2GPa", changes), folder, target_error=0.1 if toy else 0.02)


def rows_of(run: rs.Run, names: tuple[str, ...]) -> list[list[str]]:
    """Return a row of the table for each reaction; rates at T₀ + T_flash are at the hardness."""
    background = run.scene.sliding.background_temperature or 0.0
    warm = background + float(run.estimate("flash_temperature").mean[0])
    asked = run.reactions()
    eased = (
        (run.scene.reaction.activation_volume or 0.0)
        * run.scene.penetration_hardness
        / ELECTRONVOLT
    )
    energies = sorted(asked["reaction_rate"].coords["energy"].tolist())
    rows = []
    for name, energy in zip(sorted(names, key=ENERGIES.__getitem__), energies, strict=True):
        felt, rate = (
            asked[observable].sel(energy=energy)
            for observable in ("activation_temperature", "reaction_rate")
        )
        area = float(run.estimate("contact_fraction").mean[0])
        even = area * PREFACTOR * np.exp((eased - energy) / (BOLTZMANN * warm))
        cells = [
            Number(felt.mean[0], "K", felt.total_error[0]),
            Number(float(rate.mean[0]) / even, "1", digits=2),
        ]
        rows.append(
            [
                name,
                f"{energy:.2f}",
                f"{background:.0f}",
                f"{warm:.0f}",
                *(str(cell) for cell in cells),
            ]
        )
    return rows


def main() -> None:
    command = Command(__file__, __doc__, "to a total error of 10 %")
    options = command.parse()
    hot = computed(options.output / "oxidation", OXIDATION, 700.0, toy=options.toy)
    cold = computed(
        options.output / "additive",
        ADDITIVE,
        373.0,
        toy=options.toy,
        activation_volume="3.8 angstrom^3",
    )
    table = [HEADS, *rows_of(hot, OXIDATION), *rows_of(cold, ADDITIVE)]
    for row in table:
        print("  ".join(f"{cell:>16}" for cell in row))
    weak = hot.reactions()["heat_share_above"].sel(temperature=WEAK)
    print(f"share of the heat above {WEAK:g} K: {weak}")
    rs.plot(hot, "reaction", options.output / "worked_reactions.png")
    if options.evidence:
        numbers = {
            "weak": 100 * float(weak.mean[0]),
            "weak_error": 100 * float(weak.total_error[0]),
        }
        command_line = "python experiments/worked_reactions.py --evidence"
        write_evidence(
            "worked_reactions", command_line, tables={"reactions": table}, numbers=numbers
        )


if __name__ == "__main__":
    main()
