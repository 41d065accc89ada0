"""How warm a contact of finite size gets: discs at rest, sliding and on a ring track, beside endless planes.

    python experiments/finite_contact.py [--toy] [-o FOLDER] [--evidence]

Printed: the mean temperature U of a disc (`theory.background`) over time and speed; the steel scene with the rule
"total" by endless planes and by a disc; and what the model leaves out: temperatures that are equal at every point in
place of one share, and the pressure of Hertz in place of a uniform one. The first is solved on the free half-space, the
second by the exact Hertz source; neither passes through U. Last the radii above which planes are right within 5 %, and
the error of the lesser of both limits in place of U. Drawn: U over Pe, and the steel contact over the time of sliding.
"""

from __future__ import annotations

from math import inf, pi, sqrt

import figures
import numpy as np
from script import Command, write_evidence

import roughsim as rs
from roughsim.results.theories import theory_columns
from theory import background, hertz
from theory.roots import root

TIMES, PECLETS = (0.01, 0.1, 1.0, 10.0, inf), (0.1, 1.0, 10.0, 100.0, 1000.0)
SCENE, LAW = "steel-1.2GPa", "calibrated"
# radius, m, speed, m/s, duration, s
CASES = (1e-3, 1.0, 1.0), (3e-3, 1.0, 1.0), (3e-3, 1.0, 100.0), (3e-3, 35.0, 1e-3)
RADIUS, TRACK, SPEED, HOTTEST = 3e-3, 25e-3, 1.0, 1e4  # of the figure; K
RATIOS = 1.0, 5.0, 10.0, 20.0  # κ of the resting over that of the moving body


def rise(time=inf, peclet=0.0, track=None):
    """U: all of a, κ, D and q̇ are 1."""
    ring = {"track_radius": track} if track else {}
    units = {"heat_flux": 1.0, "conductivity": 1.0, "diffusivity": 1.0, "contact_radius": 1.0}
    return background.temperature(time, **units, speed=peclet, **ring)


def steel(duration, speed, **keys):
    """Share, T_flash and T₀ + T_flash of the steel scene by the law, rule "total"."""
    changes = {"heat_partition": "total", "duration": duration, "speed": [speed], **keys}
    scene = rs.load_scene(SCENE, changes={f"sliding.{key}": one for key, one in changes.items()})
    column = theory_columns(scene)[LAW]
    names = "heat_partition", "flash_temperature", "contact_temperature"
    return np.array([float(column(name).mean[0]) for name in names])


def table_of_steel():
    """Rows of the steel scene: share and T₀ + T_flash by planes, a disc, and a disc on its track."""
    rows = [["K", "planes", "disc", "track"]]
    for radius, speed, duration in CASES:
        disc = {"contact_radius": radius}
        ways = {}, disc, disc | {"track_radius": TRACK}
        found = [steel(duration, speed, **keys) for keys in ways]
        cells = (f"{share:.3f}, {total:.0f}" for share, _, total in found)
        rows.append([f"{1e3 * radius:g} mm, {speed:g} m/s, {duration:g} s", *cells])
    return rows


def equal_at_every_point(peclets, pixels):
    """Mean temperature under a uniform disc with equal temperatures at every point over that with one share."""
    count = 2 * pixels + 2
    x = (np.arange(count) - (count - 1) / 2) / pixels
    grid = rs.Grid((count, count), (count / pixels,) * 2)
    flux = (x[:, None] ** 2 + x**2 <= 1.0).astype(float)
    found = {}
    for ratio in RATIOS:
        resting = rs.Body(conductivity=ratio, diffusivity=ratio)
        for peclet in peclets:
            moving = rs.Body(conductivity=1.0, diffusivity=1.0, speed=peclet)
            point, one = (
                rs.partition_heat(flux, grid, moving=moving, resting=resting, pointwise=p)
                for p in (True, False)
            )
            found[ratio, peclet] = point.flash_temperature / one.flash_temperature - 1
    return found


def pressure_of_hertz():
    """T₀ of a Hertz pressure, whose mean is 2/3 of its peak, over a uniform one of the same heat; at rest and fast."""
    return tuple(
        1.5 * hertz.flash_temperature(peclet) / hertz.disc_mean_temperature(peclet) - 1
        for peclet in (0.0, 1e8)
    )


def radii_of_planes():
    """Contact radius in √(Dt) at rest, and in vt when fast, at which a plane is 5 % too hot; and its error at both."""

    def excess(time, peclet):
        return 2 * sqrt(time / pi) / rise(time, peclet) - 1 / 0.95

    deep = root(lambda time: excess(time, 0.0), 1e-4, 0.1, accuracy=1e-9) ** -0.5
    slid = 1 / root(lambda way: excess(1e-9, way * 1e9), 0.01, 0.9, accuracy=1e-9)
    both = rise(12.0**-2, 12.0**2 / 5) / (2 * sqrt(12.0**-2 / pi)) - 1
    return deep, slid, both


def steady_or_brief():
    """The largest error of min(at rest for the time, steady) in place of U, and vt/a there."""
    errors = [
        (min(rise(way / peclet), rise(inf, peclet)) / rise(way / peclet, peclet) - 1, way)
        for peclet in (1e2, 1e4, 1e6)
        for way in np.geomspace(0.3, 3, 47)
    ]
    return max(errors)


def curves(count):
    """Rows of the figure."""
    rows = []
    for peclet in np.geomspace(0.01, 1e4, count):
        for name, time, track in (
            ("steady", inf, None),
            ("steady, on a track of 8 a", inf, 8.0),
            ("Dt = 0.1 a²", 0.1, None),
            ("Dt = 0.01 a²", 0.01, None),
        ):
            rows.append({"curve": name, "peclet": peclet, "rise": rise(time, peclet, track)})
    for time in np.geomspace(1e-5, 1e4, count):
        for name, keys in (
            ("endless planes", {}),
            ("disc of 3 mm", {"contact_radius": RADIUS}),
            ("on a track of 25 mm", {"contact_radius": RADIUS, "track_radius": TRACK}),
        ):
            share, _, total = steel(time, SPEED, **keys)
            rows.append({"curve": name, "time": time, "total": total, "share": share})
    return rows


def main():
    options = Command(__file__, __doc__, toy="few points on coarse grids").parse()
    rises = [
        ["Dt/a², at rest", *(f"{t:g}" for t in TIMES)],
        ["U", *(f"{rise(t):.5f}" for t in TIMES)],
        ["va/D, steady", *(f"{p:g}" for p in PECLETS)],
        ["U", *(f"{rise(inf, p):.5f}" for p in PECLETS)],
    ]
    of_steel = table_of_steel()
    print(*("  ".join(row) for row in (*rises, *of_steel)), sep="\n")
    peclets = (1.0, 10.0, 100.0) if options.toy else (0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
    points = equal_at_every_point(peclets, 16 if options.toy else 64)
    largest = {ratio: max(points[ratio, p] for p in peclets) for ratio in RATIOS}
    numbers = {
        "pointwise_like": 100 * largest[1.0],
        "pointwise_unlike": 100 * max(largest.values()),
        "hertz_rest": 100 * pressure_of_hertz()[0],
        "hertz_fast": 100 * pressure_of_hertz()[1],
    }
    deep, slid, both = radii_of_planes()
    error, way = steady_or_brief()
    numbers |= {"planes_deep": deep, "planes_slid": slid, "planes_both": 100 * both}
    numbers |= {"lesser_error": 100 * error, "lesser_way": way}
    print(*(f"{name}  {value:.3f}" for name, value in numbers.items()), sep="\n")
    rows = curves(4 if options.toy else 28)
    figures.finite_contact(rows, options.output / "finite_contact.png")
    if options.evidence:
        write_evidence(
            "finite_contact",
            "python experiments/finite_contact.py --evidence",
            rows=rows,
            numbers=numbers,
            tables={"steel": [of_steel[0], *of_steel[2:]]},
        )


if __name__ == "__main__":
    main()
