"""The theory and the calibrated law beside all measured contacts: the numbers of docs/validity.md.

    python experiments/validity.py [--toy] [-o FOLDER] [--evidence]

The contacts are in reference/contacts.json, in the units that `yielding.py` describes; all values are measured at the
Péclet numbers .001, 1 and 1000. "Off" is theory over measured less 1, in per cent. Draws T_flash of both over the load.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from contacts.members import spectrum_of
from figures.style import LOOKS, legend_below, new_figure
from script import Command, write_evidence
from yielding import heat

from theory import persson, plasticity
from theory.yielding import ELASTIC_BANDS, ERROR_BANDS

CONTACTS = json.loads((Path(__file__).parent / "reference" / "contacts.json").read_text())
PLATEAU = 2.0  # q_r/q_min of the contacts on the grid; others are counted apart
ENDLESS = 512.0  # q_max/q_y that stands for C(q) without end
QUANTITIES = {
    "T_flash": "flash_temperature",
    "T′_flash": "flash_gradient",
    "D_flash": "flash_width",
    "d_flash": "slope_length",
    "g_σ(0)": "pressure_variance",
    "contact area": "contact_fraction",
}
PER_SPEED = ("flash_temperature", "flash_gradient", "flash_width", "slope_length")
Contact = dict[str, Any]


def elastic_spectrum(contact: Contact) -> Any:
    """Return C(q) of a contact that does not yield."""
    return spectrum_of(
        contact["hurst"], contact["plateau"], contact["bandwidth"], contact["low_exponent"]
    )


def by_theory(contact: Contact) -> dict[str, Any]:
    """Return the quantities of an elastic contact by the theory, γ = 0.45: (Péclet numbers,) or one number."""
    psd = elastic_spectrum(contact)
    solid = {"effective_modulus": 1.0, "nominal_pressure": contact["load"]}
    found = {
        name: heat(contact["load"], name, spectrum=psd, effective_modulus=1.0) for name in PER_SPEED
    }
    found["pressure_variance"] = persson.pressure_correlation(0.0, psd, **solid)
    found["contact_fraction"] = persson.contact_probability(contact["bandwidth"], psd, **solid)
    return found


def by_law(contact: Contact) -> dict[str, Any]:
    """Return the same by the calibrated law."""
    law = persson.calibrated_spectrum(
        elastic_spectrum(contact), effective_modulus=1.0, nominal_pressure=contact["load"]
    )
    found = {name: heat(contact["load"], name, stress_spectrum=law) for name in PER_SPEED}
    found["pressure_variance"] = persson.pressure_correlation(0.0, stress_spectrum=law)
    found["contact_fraction"] = law.contact_fraction
    return found


def over_measured(contacts: list[Contact], formula: Any) -> dict[str, Any]:
    """Return a formula over measured by quantity, (contacts, Péclet numbers) or (contacts,)."""
    rows = [
        {name: np.abs(value) / contact[name]["value"] for name, value in formula(contact).items()}
        for contact in contacts
    ]
    return {name: np.array([row[name] for row in rows]) for name in QUANTITIES.values()}


def capped_over_theory(contacts: list[Contact]) -> Any:
    """Return T_flash of capped contact without an end of C(q) over the theory on C_sm, (contacts, Péclet numbers)."""
    ratios = []
    for contact in contacts:
        far = spectrum_of(
            contact["hurst"],
            contact["plateau"],
            ENDLESS * contact["yields"],
            contact["low_exponent"],
        )
        psd = far.scaled(contact["level"] / float(far(np.array(1.0))))
        load = contact["share"] * contact["hardness"]
        solid = {
            "nominal_pressure": load,
            "penetration_hardness": contact["hardness"],
            "effective_modulus": 1.0,
        }
        smoothed = plasticity.smoothed_spectrum(psd, **solid)
        theory = heat(load, spectrum=smoothed, effective_modulus=1.0)
        ratios.append(np.array(contact["flash_temperature"]["value"]) / theory)
    return np.array(ratios)


def limits(name: str, values: Any) -> dict[str, float]:
    """Return the least and the largest of some values as numbers of these names."""
    return {f"{name}_least": float(np.min(values)), f"{name}_most": float(np.max(values))}


def elastic_numbers(grid: list[Contact], theory: dict[str, Any]) -> dict[str, float]:
    """Return how far the theory is off in elastic contact; `theory` is over measured."""
    loads = np.array([contact["load"] for contact in grid])
    slow, _, fast = 100 * (theory["flash_temperature"].T - 1)
    heavy, light = loads == loads.max(), loads == loads.min()
    area, variance = (
        100 * (1 / theory[name] - 1) for name in ("contact_fraction", "pressure_variance")
    )
    return {
        **limits("slow_heavy", slow[heavy]),
        **limits("slow_light", slow[light]),
        "fast_cool": -fast.min(),
        "fast_heavy": np.abs(fast[heavy]).max(),
        "fast_light_cool": -fast[light].min(),
        "fast_light_hot": fast[light].max(),
        "widths": max(theory["flash_width"].max(), theory["slope_length"].max()),
        **limits("area", area),
        "variance": variance.max(),
        "error": 100 * max(max(contact["flash_temperature"]["error"]) for contact in grid),
        **limits("load", loads),
        **limits("hurst", [contact["hurst"] for contact in grid]),
        **limits("bandwidth", [contact["bandwidth"] for contact in grid]),
    }


def capped_numbers(capped: list[Contact]) -> dict[str, float]:
    """Return the range of capped contacts, and T_flash without an end of C(q) over the theory."""
    slow, _, fast = capped_over_theory(
        [contact for contact in capped if contact["depth"] is None]
    ).T
    found = {**limits("capped_slow", slow), **limits("capped_fast", fast)}
    found |= limits("share", [contact["share"] for contact in capped])
    return found | limits("depth", [contact["depth"] for contact in capped if contact["depth"]])


def law_table(law: dict[str, Any]) -> list[list[str]]:
    """Return the table of the law over measured in elastic contact, %, and the bands that the program states."""
    rows = [["", "mean", "rms", "worst", "band"]]
    for words, name in QUANTITIES.items():
        logs = 100 * np.log(law[name])
        cells = logs.mean(), np.sqrt((logs**2).mean()), np.abs(logs).max()
        numbers = (f"{cell:.1f}".replace("-", "−") for cell in cells)
        rows.append([words, *numbers, f"{100 * ELASTIC_BANDS[name]:.0f}"])
    return rows


def end_table(capped: list[Contact]) -> list[list[str]]:
    """Return the table of the excess of T_flash where C(q) ends over its limit without end, %."""
    endless = {
        place(contact): np.array(contact["flash_temperature"]["value"])
        for contact in capped
        if at_no_end(contact)
    }
    grid = [
        contact for contact in capped if contact["plateau"] == PLATEAU and not at_no_end(contact)
    ]
    depths = sorted({contact["depth"] for contact in grid})
    rows = [["q_max/q_y", *(f"{depth:g}" for depth in depths)]]
    for hurst in sorted({contact["hurst"] for contact in grid}):
        row = [f"H = {hurst:g}"]
        for depth in depths:
            there = (
                contact
                for contact in grid
                if (contact["hurst"], contact["depth"]) == (hurst, depth)
            )
            row.append(
                span(
                    contact["flash_temperature"]["value"] / endless[place(contact)]
                    for contact in there
                )
            )
        rows.append(row)
    return rows


def at_no_end(contact: Contact) -> bool:
    return contact["depth"] is None


def place(contact: Contact) -> tuple[float, ...]:
    """Return what a contact has in common with its limit without an end of C(q)."""
    return tuple(contact[name] for name in ("share", "yields", "hurst", "plateau"))


def span(ratios: Iterable[Any]) -> str:
    """Return the least and the largest excess of ratios over 1, %."""
    excess = 100 * (np.array(list(ratios)) - 1)
    return f"{excess.min():.0f} … {excess.max():.0f}"


def compared(every: int = 1) -> tuple[dict[str, float], dict[str, list[list[str]]], dict[str, Any]]:
    """Return numbers and tables of the page, and T_flash by theory and law over measured, by formula."""
    elastic, capped = CONTACTS["elastic"], CONTACTS["yielding"]
    grid = [contact for contact in elastic if contact["plateau"] == PLATEAU][::every]
    others = [contact for contact in elastic if contact["plateau"] != PLATEAU]
    theory, law = over_measured(grid, by_theory), over_measured(grid, by_law)
    other = 100 * np.log(over_measured(others, by_law)["flash_temperature"])
    numbers = {
        "grid": len(grid),
        "others": len(others),
        "capped": len(capped),
        "others_off": np.abs(other).max(),
    }
    numbers |= elastic_numbers(grid, theory) | capped_numbers(capped)
    numbers |= {f"{name}_band": 100 * band for name, band in ERROR_BANDS.items()}
    flash = {
        "load": [contact["load"] for contact in grid],
        "paper's theory": theory["flash_temperature"],
        "calibrated law": law["flash_temperature"],
    }
    return numbers, {"law": law_table(law), "ends": end_table(capped)}, flash


def draw(flash: dict[str, Any], path: Path) -> None:
    """Draw T_flash by theory and law over measured, at the lowest and at the highest Péclet number, over the load."""
    with new_figure(path, 2.8) as figure:
        panels = figure.subplots(1, 2, sharey=True)
        for axes, k, words in zip(panels, (0, -1), ("slow", "fast"), strict=True):
            for name in ("paper's theory", "calibrated law"):
                axes.semilogx(
                    flash["load"], flash[name][:, k], label=name, **(LOOKS[name] | {"ls": ""})
                )
            axes.set(title=words, xlabel="load, p/(E*h′)")
        panels[0].set_ylabel(r"$T_\mathrm{flash}$ over measured")
        legend_below(figure, list(panels), 2)


def main() -> None:
    options = Command(__file__, __doc__, "every tenth elastic contact").parse()
    numbers, tables, flash = compared(10 if options.toy else 1)
    print("\n".join(f"{name:24}{value:10.4g}" for name, value in numbers.items()))
    print(
        "\n".join(
            "  ".join(f"{cell:>12}" for cell in row) for rows in tables.values() for row in rows
        )
    )
    draw(flash, options.output / "validity.png")
    if options.evidence:
        write_evidence(
            "validity", "python experiments/validity.py --evidence", numbers=numbers, tables=tables
        )


if __name__ == "__main__":
    main()
