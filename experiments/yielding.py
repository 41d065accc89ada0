"""Set the calibrated law beside contacts: those on a grid, and points drawn before the law was final.

    python experiments/yielding.py [--toy] [-o FOLDER] [--evidence]

Prints measured against predicted T_flash at the Péclet numbers .001, 1 and 1000, the variance g_σ(0), the curve g_σ(r)
down to a tenth of it, and the areas in contact and yielded; for elastic contacts T′, D_flash and d_flash too. Draws
measured/theory for the paper's form, the law and its two limits, and the errors of the law at the fresh points.

The contacts on a grid are in reference/contacts.json. C(q) has H = "hurst", q_r/q_min = "plateau" and C ~
q^-"low_exponent" below q_r. Of elastic contacts h′ = 1, q_max = "bandwidth" and σ₀ = "load". Of contacts that yield
C(1) = "level", q_y = "yields", q_max = "depth" q_y, without end where it is null, σ₀/σ_P = "share", σ_P = "hardness".
Units are those of `Case`; every quantity has its value and its relative error, 95 %.

The limits: "walls", where finer roughness does not yield (c = 0, so |σ_q|² = (E*q/2)² C A_el with Persson's diffusion
between both walls), and "bearing", where it alone yields (E* → ∞, so that the pressure is σ_P on the highest points).
The points of yielding_points.py come in two groups. The form of the law and its four constants were final when SEEN
had been looked at. The others had been compared with nothing by then, and only they are a test.

Of roughness without end, kind A, the curve g_σ(r) is compared where the finest grid ends, with the law of the same
C(q): continued to finer ones, at distances that only the last two grids resolve, it is not known to its stated error.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yielding_points
from contacts.members import spectrum_of
from matplotlib.figure import Figure
from script import EVIDENCE, Command, write_evidence

from theory import flash, persson, plasticity
from theory.walls import between
from theory.yielding import ERROR_BANDS, STEP, YieldingSpectrum

ON_GRID = Path(__file__).parent / "reference" / "contacts.json"
SEEN = {"A": 22, "B": 16, "C": 28}  # numbers up to these
CERTAIN = 0.03  # the largest relative error of g_σ(r), measured, at which it is compared
SHOWN = (0.001, 1.0, 1000.0)  # Péclet numbers
PER_SPEED = ("flash_temperature", "flash_gradient", "flash_width", "slope_length")
STIFF = 1e5  # times E*: the bearing limit
FAR = 1e5  # q_max/q_r that stands for roughness without end
BAND = ERROR_BANDS["flash_temperature"]


@dataclass(frozen=True)
class Case:
    """A measured contact in units of E* = 1 and q_r = 1, with μ = κ = D = 1."""

    name: str
    group: str
    spectrum: Any
    load: float
    hardness: float
    temperature: Any  # ⟨Tσ⟩ at SHOWN
    error: Any  # relative, 95 %, total
    record: dict[str, Any]  # of the point, empty for those on the grid

    @property
    def solid(self) -> dict[str, float]:
        """What theory.plasticity asks for."""
        return {
            "effective_modulus": 1.0,
            "nominal_pressure": self.load,
            "penetration_hardness": self.hardness,
        }


def of_grid(every: int = 1) -> list[Case]:
    """Return the contacts on the grid that yield."""
    cases = []
    for row in json.loads(ON_GRID.read_text())["yielding"][::every]:
        endless = row["depth"] is None
        end = FAR if endless else row["depth"] * row["yields"]
        whole = spectrum_of(row["hurst"], row["plateau"], end, row["low_exponent"])
        spectrum = whole.scaled(row["level"] / float(whole(np.array(1.0))))
        measured = row["flash_temperature"]
        value, error = np.array(measured["value"]), np.array(measured["error"])
        group = "grid, q_max → ∞" if endless else "grid, q_max finite"
        name = f"{row['share']:g} {row['yields']:.2g} {row['hurst']:g}"
        cases.append(
            Case(
                name,
                group,
                spectrum,
                row["share"] * row["hardness"],
                row["hardness"],
                value,
                error,
                {},
            )
        )
    return cases


def elastic_report(every: int = 1) -> str:
    """Return mean, rms and largest departure of the law from elastic contacts, by quantity."""
    departures: dict[str, list[Any]] = {}
    for row in json.loads(ON_GRID.read_text())["elastic"][::every]:
        spectrum = spectrum_of(row["hurst"], row["plateau"], row["bandwidth"], row["low_exponent"])
        stress = persson.calibrated_spectrum(
            spectrum, effective_modulus=1.0, nominal_pressure=row["load"]
        )
        predicted = {name: heat(row["load"], name, stress_spectrum=stress) for name in PER_SPEED}
        predicted["pressure_variance"] = persson.pressure_correlation(0.0, stress_spectrum=stress)
        predicted["correlation_radius_50"] = persson.correlation_radius(0.5, stress_spectrum=stress)
        predicted["contact_fraction"] = stress.contact_fraction
        for name, value in predicted.items():
            departures.setdefault(name, []).append(np.log(np.abs(value) / row[name]["value"]))
    lines = ["law over measured in elastic contacts, ln, %: mean, rms, largest"]
    for name, values in departures.items():
        percent = 100 * np.array(values)
        rms = np.sqrt((percent**2).mean())
        lines.append(f"{name:24}{percent.mean():8.1f}{rms:8.1f}{np.abs(percent).max():8.1f}")
    return "\n".join(lines)


def seen(name: str) -> bool:
    """Return whether a point had been looked at when the law was final."""
    return int(name[1:]) <= SEEN[name[0]]


def of_points() -> list[Case]:
    """Return the fresh points that have been solved."""
    contacts, cases = {contact.name: contact for contact in yielding_points.points()}, []
    for name, record in yielding_points.measured().items():
        contact, measured = contacts[name], record["flash_temperature"]
        at = [int(np.argmin(np.abs(np.log(np.array(measured["peclet"]) / pe)))) for pe in SHOWN]
        value, error = (np.array(measured[key])[at] for key in ("value", "error"))
        group = "points seen before the law was final" if seen(name) else "points not seen before"
        spectrum = contact.spectrum(FAR if contact.kind == "A" else contact.q_max)
        cases.append(
            Case(name, group, spectrum, contact.load, contact.hardness, value, error, record)
        )
    return cases


def heat(load: float, name: str = "flash_temperature", **spectrum: Any) -> Any:
    """Return ⟨Tσ⟩, or another quantity of `theory.flash`, at SHOWN."""
    unit = {
        "conductivity": 1.0,
        "diffusivity": 1.0,
        "friction_coefficient": load,
        "nominal_pressure": load,
    }
    return getattr(flash, name)(np.array(SHOWN), **unit, **spectrum)


@dataclass(frozen=True)
class Walls:
    """|σ_q|² where finer roughness does not yield: Persson's own diffusion, absorbed at 0 and at σ_P."""

    case: Case

    @property
    def breaks(self) -> tuple[float, ...]:
        """Those of C_sm, which tell where the contact yields."""
        return plasticity.smoothed_spectrum(self.case.spectrum, **self.case.solid).breaks

    def __call__(self, q: Any) -> Any:
        """Return |σ_q|² at wavenumbers q."""
        share = self.case.load / self.case.hardness
        half = (
            persson.half_variance(q, self.case.spectrum, effective_modulus=1.0)
            / self.case.hardness**2
        )
        elastic = between(min(share, 1 - share), np.ravel(half)).reshape(np.shape(half))
        return (np.asarray(q) / 2) ** 2 * self.case.spectrum(q) * elastic


FORMS: dict[str, Callable[[Case], Any]] = {
    "paper": lambda case: heat(
        case.load,
        spectrum=plasticity.smoothed_spectrum(case.spectrum, **case.solid),
        effective_modulus=1.0,
    ),
    "walls": lambda case: heat(case.load, stress_spectrum=Walls(case)),
    "bearing": lambda case: heat(
        case.load, stress_spectrum=YieldingSpectrum(case.spectrum, STIFF, case.load, case.hardness)
    ),
    "law": lambda case: heat(case.load, stress_spectrum=law(case)),
}


def law(case: Case) -> YieldingSpectrum:
    """Return the law's stress spectrum."""
    return YieldingSpectrum(case.spectrum, 1.0, case.load, case.hardness)


def departures(cases: list[Case]) -> dict[str, Any]:
    """Return ln(predicted/measured) of T_flash by form, shape (cases, SHOWN)."""
    return {
        name: np.log([form(case) / case.temperature for case in cases])
        for name, form in FORMS.items()
    }


SERIES = {
    "points seen before the law was final": "seen",
    "points not seen before": "**unseen**",
}  # on the page


def rms(values: Any) -> Any:
    """Return the root mean square over the first axis."""
    return np.sqrt((np.array(values) ** 2).mean(axis=0))


def tables(
    cases: list[Case], errors: dict[str, Any], others: dict[str, list[float]]
) -> dict[str, list[list[str]]]:
    """Return the tables of docs/yielding.md: T_flash by series and form, and the other quantities by series."""
    flash = [["series", "paper, rms", "bearing limit, rms", "law, rms", "law, worst"]]
    rest = [["series", "g_σ(0)", "g_σ(r)", "contact area", "yielded area"]]
    for group in dict.fromkeys(case.group for case in cases):
        rows = [k for k, case in enumerate(cases) if case.group == group]
        paper, bearing, own = (errors[name][rows].ravel() for name in ("paper", "bearing", "law"))
        numbers = (
            f"{rms(paper):.2f}",
            f"{rms(bearing):.2f}",
            f"{rms(own):.3f}",
            f"{np.abs(own).max():.3f}",
        )
        flash.append([SERIES.get(group, group), *numbers])
        points = [others[cases[k].name] for k in rows if cases[k].name in others]
        if points:
            columns = np.array(points)[:, [0, 2, 3, 4]]
            pairs = zip(rms(columns), np.abs(columns).max(axis=0), strict=True)
            rest.append(
                [SERIES.get(group, group), *(f"{mean:.1f}, {worst:.2g}" for mean, worst in pairs)]
            )
    return {"flash": flash, "others": rest}


def report(cases: list[Case], errors: dict[str, Any], others: dict[str, list[float]]) -> str:
    """Return rms and largest departure by group and form, and a line for each point; `others` are by `besides`."""
    groups = list(dict.fromkeys(case.group for case in cases))
    lines = [
        f"{'ln of predicted over measured T_flash':40}" + "".join(f"{name:>16}" for name in FORMS)
    ]
    for group in groups:
        rows = [k for k, case in enumerate(cases) if case.group == group]
        pairs = [
            (float(rms(e[rows].ravel())), float(np.abs(e[rows]).max())) for e in errors.values()
        ]
        label = f"{group} ({len(rows)})"
        lines.append(f"{label:40}" + "".join(f"{rms:8.3f}{worst:8.3f}" for rms, worst in pairs))
    lines += ["", "rms and largest of all three Péclet numbers. In percent, by point:", POINT_HEAD]
    rest: dict[str, list[Any]] = {group: [] for group in groups}
    for k, case in enumerate(cases):
        if case.record:
            row = others[case.name]
            rest[case.group].append([row[0], row[2], *row[3:]])
            temperature = "/".join(f"{100 * x:+.1f}" for x in errors["law"][k])
            own = "/".join(f"{100 * x:.1f}" for x in case.error)
            new = "" if seen(case.name) else " new"
            lines.append(
                f"{case.name}{new:4} {temperature:>16} ± {own:13} {row[0]:+7.1f} ± {row[1]:.1f} {row[2]:7.1f} "
                f"{row[3]:+7.1f} {row[4]:+8.1f} {row[5]:9.2f}"
            )
    for group, rows in rest.items():
        if rows:
            mean = rms(rows)
            means = (
                f"g(0) {mean[0]:.1f}, g(r) {mean[1]:.1f}, area {mean[2]:.1f}, yielded {mean[3]:.1f}"
            )
            lines.append(f"rms, {group}: {means}")
    return "\n".join(lines)


POINT_HEAD = "point        T_flash         its error      g(0)         g(r)    area  yielded  A_pl/A measured"


def besides(case: Case) -> list[float]:
    """Return ln of g(0) and its error, the worst of g(r), ln of both areas, in percent; and the yielded share."""
    stress, record = law(case), case.record
    variance = record["pressure_variance"]
    ratio = float(persson.pressure_correlation(0.0, stress_spectrum=stress)) / variance["value"]
    contact, yielded = record["contact_fraction"]["value"], record["yielded_fraction"]["value"]
    areas = np.log([ratio, stress.contact_fraction / contact, stress.plastic_fraction / yielded])
    table = {key: np.array(column) for key, column in record["correlation"].items()}
    radius, curve, doubt = (table[key] for key in ("r", "value", "error"))
    if case.name[0] == "A":  # as far as the finest grid goes
        curve, doubt = (
            curve * (1 + table["bias"]),
            np.hypot(1.96 * table["standard_error"], table["size"]),
        )
        ended = case.spectrum.truncated(q_max=record["rungs"][-1]["q_max"])
        stress = YieldingSpectrum(ended, 1.0, case.load, case.hardness)
    kept = (curve >= 0.1 * variance["value"]) & (doubt < CERTAIN)
    mine = persson.pressure_correlation(radius, stress_spectrum=stress)
    worst = np.abs(mine - curve)[kept].max(initial=0.0) / variance["value"]
    in_percent = [areas[0], variance["error"], worst, areas[1], areas[2]]
    return [*(float(100 * x) for x in in_percent), min(yielded / contact, 1.0)]


COUNTED = {
    "endless": "grid, q_max → ∞",
    "ended": "grid, q_max finite",
    "seen": "points seen before the law was final",
    "unseen": "points not seen before",
}


def counted(cases: list[Case]) -> dict[str, float]:
    """Return the number of contacts of each series, and the largest change of T_flash by half the steps, per cent."""
    groups = [case.group for case in cases]
    numbers: dict[str, float] = {name: groups.count(group) for name, group in COUNTED.items()}
    changes = []
    for case in cases:
        fine = YieldingSpectrum(case.spectrum, 1.0, case.load, case.hardness, step=STEP / 2)
        changes.append(
            heat(case.load, stress_spectrum=law(case)) / heat(case.load, stress_spectrum=fine) - 1
        )
    return numbers | {"half_step": 100 * np.abs(changes).max()}


MARKS = {"paper": ("C3", "^"), "walls": ("C1", "v"), "bearing": ("C2", "s"), "law": ("C0", "o")}


def draw(cases: list[Case], errors: dict[str, Any], folder: Path) -> None:
    """Draw predicted over measured for all forms, and the law at the fresh points."""
    figure = Figure(figsize=(13.0, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 2.8))
    order = np.argsort([case.load / case.hardness for case in cases])
    shares = np.array([cases[k].load / cases[k].hardness for k in order])
    for name, (color, mark) in MARKS.items():
        ratio = np.exp(errors[name][order, 1])
        left.plot(
            shares, ratio, mark, color=color, markersize=3.5, alpha=0.75, linewidth=0, label=name
        )
    left.axhline(1.0, color="0.4", linewidth=0.8)
    left.set(
        xscale="log",
        yscale="log",
        xlabel=r"$\sigma_0/\sigma_P$",
        ylabel=r"theory over measured $T_\mathrm{flash}$, Pe = 1",
    )
    left.set_yticks([0.5, 1, 2, 5], ["0.5", "1", "2", "5"])
    left.yaxis.minorticks_off()
    left.legend(frameon=False, fontsize=8)
    fresh = [k for k, case in enumerate(cases) if case.record]
    for j, (pe, color) in enumerate(zip(SHOWN, ("C0", "C4", "C5"), strict=True)):
        for row, k in enumerate(fresh):
            new = not seen(cases[k].name)
            right.errorbar(
                row + 0.22 * (j - 1),
                100 * errors["law"][k, j],
                100 * cases[k].error[j],
                fmt="o",
                color=color,
                markerfacecolor=color if new else "white",
                markersize=4,
                elinewidth=0.8,
                label=f"Pe = {pe:g}" if row == 0 else None,
            )
    right.axhline(0.0, color="0.4", linewidth=0.8)
    right.axhspan(-100 * BAND, 100 * BAND, color="0.92", zorder=0)
    right.set_xticks(range(len(fresh)), [cases[k].name for k in fresh], rotation=90, fontsize=5.5)
    right.set(ylabel=r"law less measured $T_\mathrm{flash}$, %", xlim=(-0.7, len(fresh) - 0.3))
    right.legend(
        frameon=False,
        fontsize=8,
        ncols=3,
        title="filled: not seen before the law was final",
        title_fontsize=8,
    )
    figure.savefig(folder / "yielding.png", dpi=150)


def main() -> None:
    command = Command(__file__, __doc__, "every 20th contact on the grid")
    options = command.parse()
    every = 20 if options.toy else 1
    cases = [*of_grid(every), *of_points()]
    if options.toy:
        cases = cases[::4]
    errors = departures(cases)
    others = {case.name: besides(case) for case in cases if case.record}
    text = report(cases, errors, others) + "\n\n" + elastic_report(every)
    print(text)
    (options.output / "yielding.txt").write_text(text + "\n")
    draw(cases, errors, options.output)
    if options.evidence:
        shown, numbers = tables(cases, errors, others), counted(cases)
        write_evidence(
            "yielding", "python experiments/yielding.py --evidence", tables=shown, numbers=numbers
        )
        (EVIDENCE.parent / "reference" / "yielding.txt").write_text(text + "\n")
    print(f"figure and text are in {options.output}")


if __name__ == "__main__":
    main()
