"""The sizes that follow from a scene, and a warning for each number that is beyond the model.

A warning has the value, the limit, and what to check. The table at the end of docs/limits.md has the same limits.
"""

from collections.abc import Iterator
from functools import lru_cache
from math import exp, inf, isfinite, isinf, isnan, log, nan, pi, prod, sqrt
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from roughsim import prediction
from roughsim.estimate.cell_size import choose_lengths
from roughsim.planning.levels import CAPPED_SIDE, ELASTIC_SIDE
from roughsim.prediction.scans import scan_of_hottest
from roughsim.prediction.statements import Statement, cautions, statements, textures
from roughsim.scene import Scene
from roughsim.scene.numerics import Numerics
from roughsim.scene.sections import BodySection, CounterfaceSection
from roughsim.scene.slips import slips
from roughsim.show.table import Column, Table, json_value

Lines = Iterator[str]
ROOM = 293.0  # K, the background temperature where none is given
STEEP = 0.5  # rms slope: the model is for small slopes
YIELDED = 32.0  # q_y: shorter waves touch at the hardness alone, and their slope changes nothing
ATOM = 0.3e-9  # m: shorter waves are no continuum
FLAT = 0.1e-9  # m, rms height: a layer of atoms alone is rougher
YIELDS = 1 / 3  # of the hardness, about the yield stress: above it bodies yield beneath their whole face
STRAIN = 0.1  # pressure over E*: linear elasticity
STIFF = 1e9  # Pa, E*: stiffer solids than rubber yield before such a strain
STRONGEST = 0.3  # hardness over Young's modulus: three times the strength of a perfect crystal
COMPLETE = 0.9  # contact area over nominal area: such faces adhere
LEAST_PIXELS = 16.0  # of contact in a cell
HOTTEST = 4200.0  # K: no material is solid above it
FAST = 0.5  # of the speed of shear waves: in the model contact forms at once
FREE_PATH = 10e-9  # m, free path of electrons and phonons: Fourier's law holds for longer distances
SLOWLY = 0.85  # exponent of T_flash over q_max: H = 0.52
UNEVEN = 0.02  # distance of the heat share from 1/2
LIKE = 2.0  # ratio of the rms heights of two faces that count as equally rough
FRICTION = 1e-3, 5.0  # of dry solids
# the range of solids, SI, from gels and aerogel to diamond, osmium and lithium
USUAL = {
    "youngs_modulus": (1e3, 2e12, "Pa"),
    "density": (20.0, 2.3e4, "kg/m³"),
    "heat_capacity": (50.0, 6e3, "J/(kg K)"),
    "conductivity": (0.01, 3e3, "W/(m K)"),
    "diffusivity": (3e-8, 2e-3, "m²/s"),
}


class Facts:
    """Sizes that follow from a scene, in SI; arrays run over its speeds. They are not changed later.

    ValueError, ArithmeticError or RuntimeError where the theory of the scene has no value.
    """

    def __init__(self, scene: Scene):
        theory, spectrum, load = prediction.predictions(scene), scene.spectrum, scene.sliding.nominal_pressure
        self.rms_height = spectrum.rms_height  # of both faces together, as all of the roughness
        self.rms_slope = spectrum.rms_slope
        yields = inf if scene.elastic else prediction.yield_wavenumber(scene)
        gentle = spectrum if YIELDED * yields >= spectrum.breaks[-1] else spectrum.truncated(q_max=YIELDED * yields)
        self.textures = {face: [texture._asdict() for texture in maps] for face, maps in textures(scene).items()}
        self.rms_slope_before_yield = gentle.rms_slope  # of the waves up to 32 q_y; of all where q_y is inf
        self.longest_wave = 2 * pi / spectrum.breaks[0]
        self.shortest_wave = 2 * pi / spectrum.breaks[-1]
        self.pressure_over_hardness = load / scene.penetration_hardness  # σ₀/σ_P; 0 of elastic contact
        self.pressure_over_modulus = load / scene.effective_modulus  # σ₀/E*
        self.contact_fraction = contact = float(theory["contact_fraction"][0])  # A/A₀ of the theory
        self.contact_pressure = load / contact if contact > 0.0 else inf  # its mean, σ₀A₀/A
        self.yield_wavenumber = yields  # q_y; inf of elastic contact, or where C(q) ends before
        # the distance over which the correlation of the pressure falls to a half, in theory
        self.hot_spot_radius = radius = float(theory["correlation_radius_50"][0])
        lengths = choose_lengths(scene)[0]
        self.hot_spots = contact * lengths[0] * lengths[1] / (pi * radius**2)  # contact area of a cell over πr²
        self.cell = lengths  # its sides
        self.speed = np.array(scene.speeds)
        self.peclet_number = self.speed * radius / prediction.conduction(scene).diffusivity  # vr/D
        self.heat_partition = prediction.heat_partition(scene)  # share used
        # of the theory with that share, K above the background
        self.flash_temperature = self.heat_partition * theory["flash_temperature"]
        self.background_temperature = scene.sliding.background_temperature or ROOM  # absolute
        self.melting_temperature = scene.melting_temperature  # absolute; inf if the scene gives none

    def to_dict(self) -> dict[str, Any]:
        """Return JSON values in SI; NaN and inf as None."""
        return {name: json_value(value) for name, value in vars(self).items()}

    def rows(self) -> list[Statement]:
        """Return name, value and meaning of each for people."""
        elastic = self.pressure_over_hardness == 0.0
        ratio = ("σ₀/σ_P", f"{self.pressure_over_hardness:.3g}", "nominal pressure over penetration hardness")
        if elastic:
            ratio = ("σ₀/E*", f"{self.pressure_over_modulus:.3g}", "nominal pressure over effective modulus")
        yields = "no q_y: elastic" if elastic else "no q_y: less than 99 % yields"
        if not isinf(self.yield_wavenumber):
            yields = f"q_y = {self.yield_wavenumber:.3g} rad/m"
        gentle = f", {self.rms_slope_before_yield:.3g} up to {YIELDED:g} q_y"
        gentle *= self.rms_slope_before_yield < self.rms_slope
        slope = f"of both faces together{gentle}; the model has less than {STEEP:g}"
        waves = f"in waves of {1e3 * self.longest_wave:.3g} mm to {1e6 * self.shortest_wave:.3g} µm"
        area = f"of the nominal area in theory, at {self.contact_pressure:.3g} Pa; {yields}"
        size = f"{1e3 * self.cell[0]:.3g} mm × {1e3 * self.cell[1]:.3g} mm"
        spots = f"of radius {1e6 * self.hot_spot_radius:.3g} µm in a cell of {size}"
        speeds = f"at {range_text(self.speed)} m/s"
        melting = "" if isinf(self.melting_temperature) else f", melts at {self.melting_temperature:g} K"
        background = f"above a background of {self.background_temperature:g} K{melting}"
        rows = [
            ("rms height", f"{1e6 * self.rms_height:.3g} µm", f"of both faces together, {waves}"),
            ("rms slope", f"{self.rms_slope:.3g}", slope),
            ratio,
            ("contact area", f"{self.contact_fraction:.3g}", area),
            ("hot spots", f"{self.hot_spots:.3g}", spots),
            ("Péclet number", range_text(self.peclet_number), f"vr/D with that radius, {speeds}"),
            ("T_flash", f"{range_text(self.flash_temperature)} K", f"in theory, {speeds}, {background}"),
        ]
        return [Statement(*row) for row in rows]


facts = lru_cache(maxsize=8)(Facts)


def range_text(values: NDArray[np.float64]) -> str:
    """Return the least and the largest of some numbers, as "0.1 … 35"."""
    return " … ".join(dict.fromkeys(f"{value:.3g}" for value in (float(values.min()), float(values.max()))))


class Plausibility(NamedTuple):
    """What follows from a scene: sizes (None where its theory has no value), assumptions, and warnings."""

    facts: Facts | None
    warnings: list[str]
    statements: list[Statement]

    def table(self) -> Table:
        """Return sizes and assumptions for people: name, value, and meaning or reason."""
        rows = [*(self.facts.rows() if self.facts else []), *self.statements]
        return Table([Column("", name=True), Column("", name=True), Column("")], rows)

    def to_dict(self) -> dict[str, Any]:
        """Return "scene_facts", "scene_statements" and "scene_warnings" as JSON values."""
        told = [statement._asdict() for statement in self.statements]
        sizes = self.facts and self.facts.to_dict()
        return {"scene_facts": sizes, "scene_statements": told, "scene_warnings": self.warnings}


def judge(scene: Scene, numerics: Numerics | None = None) -> Plausibility:
    """Return the sizes that follow from a scene, and a warning for each number that the model is not meant for.

    Contact is counted in pixels of the finest grid of `numerics`, or, without `numerics`, of the largest planned one.
    """
    bodies, stated = [*roughness_lines(scene), *body_lines(scene), *slips(scene), *cautions(scene)], statements(scene)
    try:
        known = facts(scene)
    except (ValueError, ArithmeticError, RuntimeError) as error:
        line = f"the theory of this scene cannot be evaluated ({error}); contact area and temperature are not checked"
        lines = [*slope_lines(scene, scene.spectrum.rms_slope), *bodies, " ".join(line.split())]
        return Plausibility(None, lines, stated)
    lines = [*slope_lines(scene, known.rms_slope_before_yield), *bodies, *load_lines(scene, known, numerics)]
    return Plausibility(known, [*lines, *heat_lines(scene, known), *share_lines(scene, known)], stated)


def slope_lines(scene: Scene, before_yield: float) -> Lines:
    """Warn of steep slopes; `before_yield` is the rms slope of the waves up to 32 q_y."""
    slope = scene.spectrum.rms_slope
    if slope <= STEEP:
        return
    end = gentle_end(scene)
    if before_yield <= STEEP:  # at 32 q_y T_flash is 10 to 40 % above its limit with H = 0.3, 2 to 9 % with 0.55
        rough = prediction.usual_exponent(scene, end) < SLOWLY
        changes = "makes T_flash higher: with so small an H it falls slowly" if rough else "changes little"
        advice = (
            f"up to {YIELDED:g} q_y it is {before_yield:.3g}, and shorter waves touch at the hardness alone; check the "
            f"units of the roughness, or lower q_max to {end:.3g} rad/m, which {changes}"
        )
    else:
        until = f", or lower q_max to {end:.3g} rad/m, up to which it is less" if isfinite(end) else ""
        advice = f"check the units of the roughness{until}"
    yield f"rms slope = {slope:.3g} of both faces together is above {STEEP:g}: the model is for small slopes; {advice}"


def gentle_end(scene: Scene) -> float:
    """The wavenumber up to which the rms slope stays below `STEEP`, rad/m; NaN if the first waves are steep."""

    def excess(log_q: float) -> float:
        return scene.spectrum.truncated(q_max=exp(log_q)).rms_slope - STEEP

    first, last = log(1.01 * scene.spectrum.breaks[0]), log(scene.spectrum.breaks[-1])
    return nan if excess(first) > 0.0 else exp(scipy.optimize.brentq(excess, first, last))


def roughness_lines(scene: Scene) -> Lines:
    """Warn of roughness and waves below the size of atoms, and of a C(q) from scans."""
    height, shortest = scene.spectrum.rms_height, 2 * pi / scene.spectrum.breaks[-1]
    if height < FLAT:
        yield (
            f"rms height = {height:.3g} m of both faces together is below {FLAT:g} m, less than an atom; "
            "check the units of the roughness"
        )
    if shortest < ATOM:
        yield (
            f"the shortest wave, 2π/q_max = {shortest:.3g} m, is below {ATOM:g} m, the distance of atoms, "
            "and the model is for continuous solids; check the unit of q_max, or lower it"
        )
    scan, target = scan_of_hottest(scene), dict(scene.ensemble.until).get("flash_temperature", inf)
    if scan is not None and isnan(scan):
        yield (
            "C(q) was measured on a scan, and its error is unknown: psd_error is missing, the map is not isotropic or "
            "not Gaussian, or C(q) may rise without limit to the longest waves; press the map, or take a larger scan"
        )
    elif scan is not None and scan > target:
        yield (
            f"C(q) was measured on a scan, which by itself leaves {100 * scan:.2g} % of error in the highest T_flash, "
            f"above the target of {100 * target:g} %; take a larger scan, or more of them"
        )


def body_lines(scene: Scene) -> Lines:
    """Warn of properties that no solid has, and of sliding as fast as sound, for each body that the scene states."""
    speed = max(scene.speeds)
    for name, body in (("body", scene.body), ("counterface", scene.counterface)):
        if body is None:
            continue
        for quantity, value in properties(body):
            low, high, unit = USUAL[quantity]
            if not low <= value <= high:
                units = "its unit" if quantity != "diffusivity" else "those of conductivity, density and heat_capacity"
                yield (
                    f"{name}.{quantity} = {value:.3g} {unit} is not within {low:g} to {high:g} {unit}, the range of "
                    f"solids; check {units}"
                )
        hardness, modulus = body.penetration_hardness, body.youngs_modulus
        if hardness is not None and modulus is not None and hardness > STRONGEST * modulus:
            yield (
                f"{name}.penetration_hardness = {hardness:.3g} Pa is above {STRONGEST:g} of youngs_modulus = "
                f"{modulus:.3g} Pa, and no crystal is stronger; check the units of both"
            )
        waves = inf  # speed of shear waves, √(G/ρ)
        if modulus is not None and body.poisson_ratio is not None and body.density is not None:
            waves = sqrt(modulus / (2.0 * (1.0 + body.poisson_ratio)) / body.density)
        if speed > FAST * waves:
            yield (
                f"sliding.speed = {speed:.3g} m/s is above {FAST:g} of the speed of shear waves in the {name}, "
                f"{waves:.3g} m/s: in the model contact forms at once; check the units of speed, youngs_modulus and "
                "density"
            )


def properties(body: BodySection | CounterfaceSection) -> Iterator[tuple[str, float]]:
    """Yield properties of a body, κ at each temperature of a table, and D = κ/(ρc) if all others are usual."""
    strange = False
    for name in ("youngs_modulus", "density", "heat_capacity", "conductivity"):
        stated = getattr(body, name)
        for value in [row[1] for row in stated] if isinstance(stated, tuple) else [stated] * (stated is not None):
            strange |= not USUAL[name][0] <= value <= USUAL[name][1]
            yield name, value
            if name == "conductivity" and not strange and body.density and body.heat_capacity:
                yield "diffusivity", value / (body.density * body.heat_capacity)


def load_lines(scene: Scene, known: Facts, numerics: Numerics | None) -> Lines:
    """Warn of a nominal pressure or contact area that is too large or too small."""
    pressure = f"sliding.nominal_pressure = {scene.sliding.nominal_pressure:.3g} Pa"
    if known.pressure_over_hardness > YIELDS:
        yield (
            f"{pressure} is {known.pressure_over_hardness:.2g} of the hardness, above {YIELDS:.2g}: bodies yield "
            "beneath their whole face, but in the model only at the contact; check the units of both"
        )
    if known.pressure_over_modulus > STRAIN:
        yield (
            f"{pressure} is {known.pressure_over_modulus:.2g} of E* = {scene.effective_modulus:.3g} Pa, above "
            f"{STRAIN:g}, and the model is for small strains; check the units of pressure and youngs_modulus"
        )
    strain = known.contact_pressure / scene.effective_modulus
    if scene.elastic and strain > STRAIN and scene.effective_modulus > STIFF:
        yield (
            f"the mean contact pressure, {known.contact_pressure:.3g} Pa, is {strain:.2g} of E*, above {STRAIN:g}, and "
            "stiff solids yield before that; give a penetration_hardness, or check the units of roughness and pressure"
        )
    side = ELASTIC_SIDE if scene.elastic else CAPPED_SIDE
    shapes = [level.shape for level in numerics.levels] if numerics else [(side, side)]
    (x, y), grid = max(shapes, key=prod), "the finest grid" + " of a plan" * (numerics is None)
    pixels = known.contact_fraction * (x * y)
    contact = f"{pressure} makes contact on {known.contact_fraction:.2g} of the area"
    if pixels < LEAST_PIXELS:
        yield f"{contact}, {pixels:.2g} pixels of {grid}, {x} × {y}, below {LEAST_PIXELS:g}; check its unit"
    elif known.hot_spots < 1.0:
        yield (
            f"{contact}, {known.hot_spots:.2g} of one hot spot of the theory in a cell of {1e3 * known.cell[0]:.3g} "
            "mm; check its unit, or raise numerics.lengths"
        )
    if known.contact_fraction > COMPLETE:
        yield (
            f"contact on {known.contact_fraction:.3g} of the area in theory is above {COMPLETE:g}: such faces adhere, "
            "but not in the model; check the units of roughness, pressure and youngs_modulus"
        )


def heat_lines(scene: Scene, known: Facts) -> Lines:
    """Warn of friction that no solid has, of contact that melts, and of heat that is not diffusive."""
    given = scene.sliding.friction_coefficient
    values = [row[1] for row in given] if isinstance(given, tuple) else [given]
    if friction := next((value for value in values if not FRICTION[0] < value <= FRICTION[1]), None):
        yield (
            f"sliding.friction_coefficient = {friction:.3g} is not within {FRICTION[0]:g} to {FRICTION[1]:g}, the "
            "range of dry solids; check it"
        )
    k = int(np.argmax(known.flash_temperature))
    hottest = known.background_temperature + float(known.flash_temperature[k])
    article = "a" if scene.sliding.background_temperature else "an assumed"
    reached = (
        f"T_flash = {known.flash_temperature[k]:.4g} K at {scene.speeds[k]:g} m/s in theory, over {article} background "
        f"of {known.background_temperature:g} K, makes {hottest:.4g} K"
    )
    if hottest > known.melting_temperature:
        yield (
            f"{reached}, above the melting_temperature of {known.melting_temperature:g} K: in the model bodies stay "
            "solid; check the units of heat, load and roughness, or lower the speed"
        )
    elif hottest > HOTTEST:
        yield f"{reached}, above {HOTTEST:g} K, where no material is solid; check the units of heat, load and roughness"
    fastest = float(known.peclet_number.max())
    if fastest > 1.0 and (depth := known.hot_spot_radius * sqrt(2.0 / fastest)) < FREE_PATH:
        yield (
            f"at the Péclet number vr/D = {fastest:.3g} the heat of a hot spot goes {depth:.2g} m deep, less than "
            f"{FREE_PATH:g} m, the free path of electrons and phonons; check the units of speed and conductivity"
        )


def share_lines(scene: Scene, known: Facts) -> Lines:
    """Warn of a heat share other than 1/2 between faces that conduct alike and are equally rough."""
    k = int(np.argmax(scene.speeds))
    share = float(known.heat_partition[k])
    if len(scene.faces) < 2 or not scene.counterface_conducts or abs(share - 0.5) <= UNEVEN:
        return
    bodies = prediction.conduction(scene)
    alike = np.array_equal(bodies.conductivity, bodies.counter_conductivity)
    alike = alike and np.array_equal(bodies.diffusivity, bodies.counter_diffusivity)
    first, second = (face.rms_height for face in scene.faces)
    if alike and 1 / LIKE <= first / second <= LIKE:
        about = "about " if scene.tables else ""  # a table over temperature has another value at another share
        yield (
            f"the heat share {share:.3g} at {scene.speeds[k]:g} m/s is that of hot spots that rest on the counterface, "
            "but two equally rough faces of one material share the heat evenly; heat_partition = 0.5 makes "
            f"temperatures {about}{0.5 / share:.3g} times as high; see docs/partition.md"
        )
