"""What a finite cell changes, over scenes drawn at random: means in cells of 2, 4, 8 and 16 waves, pixel and cut-off kept.
"""
from __future__ import annotations

import argparse, json, sys, time, warnings
from dataclasses import dataclass
from functools import cache
from math import pi, sqrt
from pathlib import Path

import numpy as np
import scipy.optimize
import scipy.special

import roughsim as rs
from roughsim import prediction

PIXELS = 4
NAMES = ("slow", "middle", "fast", "area", "variance", "r_50")
DIFF = 30.0 / (7900.0 * 500.0)
QX = 6350.0  # 2π over the wave that counts


@dataclass(frozen=True)
class Case:
    name: str
    kind: str      # plain, flat, roll, elastic, elastic flat
    share: float   # σ₀/σ_P or σ₀/(E* h')
    ratio: float   # q_y, or q_max, over the wavenumber of the wave that counts
    hurst: float
    flat: float = 1.0  # q_roll_off/q_min
    exponent: float = 0.0


def drawn(number: int) -> Case:
    draw = np.random.default_rng(4000 + number)
    kind = ("plain", "flat", "plain", "roll", "elastic")[number % 5]
    share = float(np.exp(draw.uniform(np.log(0.001), np.log(0.5))))
    ratio = float(np.exp(draw.uniform(np.log(1.5), np.log(30.0))))
    hurst = float(draw.uniform(0.4, 0.9))
    flat, exponent = 1.0, 0.0
    if kind == "flat" or (kind == "elastic" and number % 10 == 9):
        flat = float(np.exp(draw.uniform(np.log(2.0), np.log(32.0))))
    if kind == "roll":
        flat, exponent = float(np.exp(draw.uniform(np.log(2.0), np.log(8.0)))), float(draw.uniform(1.0, 2.0))
    if kind == "elastic":
        share, ratio = float(np.exp(draw.uniform(np.log(0.003), np.log(0.3)))), float(np.exp(draw.uniform(np.log(4.0), np.log(24.0))))
    return Case(f"{kind} {number}", kind, share, ratio, hurst, flat, exponent)


def by_hand() -> list[Case]:
    return [
        Case("light", "plain", 0.003, 3.0, 0.8),
        Case("light .01", "plain", 0.01, 3.0, 0.8),
        Case("steel", "roll", 0.075, 8.0, 0.8, 14.8, 1.5),
        Case("light r8", "plain", 0.003, 8.0, 0.8),
        Case("light H.5", "plain", 0.003, 3.0, 0.5),
        Case("mid r3", "plain", 0.05, 3.0, 0.8),
        Case("heavy r3", "plain", 0.3, 3.0, 0.8),
        Case("heavy r15", "plain", 0.4, 15.0, 0.6),
        Case("flat light", "flat", 0.003, 3.0, 0.8, 16.0),
        Case("flat heavy", "flat", 0.2, 6.0, 0.8, 16.0),
        Case("tiny r1.5", "plain", 0.001, 1.5, 0.8),
        Case("tiny r20", "plain", 0.001, 20.0, 0.8),
        Case("elastic light", "elastic", 0.005, 12.0, 0.8),
        Case("elastic mid", "elastic", 0.1, 12.0, 0.7),
    ]


@cache
def scene_of(case: Case) -> rs.Scene:
    q_min = QX / case.flat if case.exponent < 1.0 else QX
    roll = {} if case.flat == 1.0 else {"q_roll_off": q_min * case.flat, "roll_off_exponent": case.exponent}
    elastic = case.kind == "elastic"
    end = case.ratio * QX * (1.0 if elastic else 64.0)

    def scene(height: float, pressure: float) -> rs.Scene:
        body = {"youngs_modulus": "200 GPa", "poisson_ratio": 0.3, "conductivity": 30.0, "density": 7900, "heat_capacity": 500}
        if not elastic:
            body["penetration_hardness"] = "2 GPa"
        scale = DIFF * case.ratio * QX
        sections = {
            "surface": {"rms_height": height, "hurst": case.hurst, "q_min": q_min, "q_max": end} | roll,
            "body": body,
            "sliding": {"friction_coefficient": 0.1, "speed": [0.01 * scale, 3 * scale, 300 * scale], "nominal_pressure": pressure},
        }
        return rs.load_scene(sections)

    if elastic:
        trial = scene(1e-6, 1e6)
        return scene(1e-6, case.share * trial.effective_modulus * trial.spectrum.rms_slope)
    pressure = case.share * 2e9
    goal = case.ratio * QX

    def excess(log_height: float) -> float:
        q = prediction.yield_wavenumber(scene(float(np.exp(log_height)), pressure))
        return np.log(min(q, 60 * goal) / goal)
    height = scipy.optimize.brentq(excess, np.log(1e-9), np.log(1e-3), xtol=1e-4)
    return scene(float(np.exp(height)), pressure)


def numerics(case: Case, column: str, waves: float, cut: float) -> rs.Numerics:
    length = waves * 2 * pi / QX
    q_c = case.ratio * QX * cut
    n = 2 * round(PIXELS * q_c * length / (2 * pi) / 2)
    n = fast(n)
    q = min(q_c, n / PIXELS * 2 * pi / length * 1.05)
    return rs.Numerics((rs.Level(column, (n, n), q_c),), (length, length))


def fast(n):
    """even sizes 2^a 3^b 5^c near"""
    best = None
    for a in range(1, 13):
        for b in range(3):
            for c in range(2):
                m = 2**a * 3**b * 5**c
                if m >= 0.97 * n and (best is None or m < best):
                    best = m
    return best


def at_mean(rows, controls):
    x = controls - 0.0
    keep = x.std(axis=0) > 0
    x = x[:, keep]
    n = len(rows)
    design = np.c_[np.ones(n), x]
    coef, *_ = np.linalg.lstsq(design, rows, rcond=None)
    res = rows - design @ coef
    return coef[0], np.sqrt((res**2).sum(0) / (n - design.shape[1]) / n)


def measured(case, column, waves, cut, work, seed=11, most=20000):
    scene, num = scene_of(case), numerics(case, column, waves, cut)
    points = num.levels[0].shape[0] ** 2
    count = int(min(max(work / points, 24), most))
    rows, controls, spectra = [], [], []
    start = time.time()
    fails = 0
    for index in range(count):
        try:
            s = rs.realize(scene, num, seed=seed, level=0, index=index)
        except rs.errors.ConvergenceError:
            fails += 1; continue
        o = s.observables
        rows.append([*o.flash_temperature, o.contact_fraction_corrected, o.pressure_variance])
        controls.append(list(s.peak_volumes))
        spectra.append(o.stress_spectrum.variance)
    sp = o.stress_spectrum
    spectra = np.array(spectra)
    rows = np.array(rows)
    mean_sp = spectra.mean(0)
    from dataclasses import replace
    r = replace(sp, variance=mean_sp).correlation_radius(0.5)
    slope = -float((mean_sp * sp.wavenumber) @ scipy.special.j1(sp.wavenumber * r))
    infl = r - spectra @ (scipy.special.j0(sp.wavenumber * r) - 0.5) / slope
    rows = np.c_[rows, infl]
    mean, error = at_mean(rows, np.array(controls))
    return {"n": len(rows), "fails": fails, "shape": num.levels[0].shape[0], "mean": mean.tolist(), "error": (error / np.abs(mean)).tolist(),
            "plain": rows.mean(0).tolist(), "sd": (rows.std(0, ddof=1) / np.abs(mean)).tolist(), "seconds": time.time() - start}


def main():
    p = argparse.ArgumentParser()
    p.add_argument("file"); p.add_argument("--work", type=float, default=1.5e8)
    p.add_argument("--only", nargs="*"); p.add_argument("--numbers", type=int, nargs="*", default=[])
    p.add_argument("--cells", type=float, nargs="*", default=[2, 4, 8, 16]); p.add_argument("--cut", type=float, default=0)
    p.add_argument("--most-points", type=float, default=1.2e6); p.add_argument("--columns", nargs="*", default=["capped", "smoothed"])
    o = p.parse_args()
    warnings.simplefilter("ignore")
    path = Path(o.file)
    table = json.loads(path.read_text()) if path.exists() else {}
    cases = [c for c in by_hand() if o.only is None or c.name in o.only] if not o.numbers else [drawn(i) for i in o.numbers]
    for case in cases:
        for column in (["elastic"] if case.kind == "elastic" else o.columns):
            cut = o.cut or {"elastic": 1.0, "capped": 2.0, "smoothed": 1.5}[column]
            for waves in o.cells:
                num = numerics(case, column, waves, cut)
                points = num.levels[0].shape[0] ** 2
                if points > o.most_points:
                    continue
                key = f"{case.name}|{column}|{waves:g}|{cut:g}"
                if key in table and table[key]["n"] >= min(o.work / points, 20000) * 0.99 - 1:
                    continue
                found = measured(case, column, waves, cut, o.work)
                table[key] = found | {"case": vars(case) | {}}
                path.write_text(json.dumps(table))
                print(key, found["n"], found["shape"], f"{found['seconds']:.0f}s", "fails", found["fails"], np.array2string(np.array(found["mean"]), precision=5), np.round(100*np.array(found["error"]), 3), flush=True)

if __name__ == "__main__":
    main()
