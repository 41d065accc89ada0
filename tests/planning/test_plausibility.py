"""Scenes with a slip of the unit or the key are told of; lawful ones are not."""

import json
import math
import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from soft_scene import RUBBER
from steel_text import STEEL, changed, with_counterface

import roughsim as rs
from roughsim.cli import main
from roughsim.comparison.tables import theory_dict
from roughsim.estimate.cell_size import choose_lengths
from roughsim.outputs.run_report import header, scene_section
from roughsim.planning.limits import judge
from roughsim.prediction import facts as sizes
from roughsim.scene import SceneError, bundled_scenes, parse_scene

ROOT = Path(__file__).parents[2]


def facts(scene):
    return sizes.facts_of(scene, choose_lengths(scene)[0])


def warned(text):
    return judge(parse_scene(text)).warnings


def even(text=STEEL):
    """The scene with the share that two equal faces have, so that nothing is said of it; its highest speed alone."""
    text = re.sub(r"speed = \[.*?\]", 'speed = ["100 m/s"]', text)
    return changed("heat_partition = 0.938", "heat_partition = 0.5", text)


SLIPS = {
    ('"90 MPa"', '"3 Pa"'): r"nominal_pressure = 3 Pa makes contact on 2.5e-09 of the area, 0.042 pixels of the finest",
    ('"0.90 um"', '"2 m"'): r"rms slope = 9.4.e\+05 of both faces together is above 0.5",
    ('"0.90 um"', '"0.90 mm"'): r"rms slope = 4.4 of both",
    ('"0.90 um"', '"0.90 pm"'): r"rms height of both faces together = 1.27e-12 m is below 1e-10 m, less than an atom",
    ('"4.15e7 1/m"', '"4.15e10 1/m"'): r"the shortest wave, 2π/q_max = 1.51e-10 m is below 3e-10 m",
    ('"200 GPa"', '"200 MPa"'):
     r"body.penetration_hardness/youngs_modulus = 6 is above 0.3, and no crystal is stronger",
    ('"200 GPa"', '"200 TPa"'): r"body.youngs_modulus = 2e\+14 Pa is not within 1000 to 2e\+12 Pa, the range of solids",
    ('"1.2 GPa"', '"120 MPa"'): r"nominal_pressure = 9e\+07 Pa is 0.75 of the hardness, above 0.33",
    ('"30 W/(m K)"', '"30 mW/(m K)"'): r"body.diffusivity = 7.59e-09 m²/s is not within 3e-08 to 0.002 m²/s",
    ('"30 W/(m K)"', '"30 kW/(m K)"'): r"body.conductivity = 3e\+04 W/\(m K\) is not within 0.01 to 3000",
    ('"7900 kg/m^3"', '"7.9 kg/m^3"'): r"body.density = 7.9 kg/m³ is not within 20 to 23000 kg/m³",
    ('"500 J/(kg K)"', '"500 kJ/(kg K)"'):
     r"body.heat_capacity = 5e\+05 J/\(kg K\) is not within 50 to 6000 J/\(kg K\)",
    ('penetration_hardness = "1.2 GPa"', ""):
     r"mean contact pressure, 2.9.e\+10 Pa, is 0.27 of E\*, above 0.1, and stiff",
    ('"90 MPa"', "9e3"): r"nominal_pressure = 9e\+03 Pa makes contact on 7.5e-06 of the area, 0.6 of one hot spot",
    ('"6350 1/m"', "6.35"): r"the longest wave, 2π/q_min = 0.989 m is above 0.1 m, .* q in rad/m \(1/µm is 1e6",
    ("= 0.11", "= 11"): r"friction_coefficient = 11 is not within 0.001 to 5",
    ('"100 m/s"', '"100 km/s"'): r"sliding.speed over the speed of shear waves in the body = 32 is above 0.5",
}  # fmt: skip


@pytest.mark.parametrize("slip", SLIPS, ids=lambda slip: slip[1])
def test_a_slip_of_a_unit_is_told_in_one_line_with_its_value_and_the_limit(slip):
    lines = warned(changed(*slip, even()))
    assert any(re.search(SLIPS[slip], line) for line in lines), lines
    assert all("check" in line and "\n" not in line and len(line) < 320 for line in lines)


def test_diffusivity_is_told_only_if_its_parts_are_usual():
    lines = warned(changed('"30 W/(m K)"', '"30 kW/(m K)"', even()))
    assert not any("diffusivity" in line for line in lines)


def test_waves_and_C_in_micrometres_without_their_unit_are_told():
    # heights of 1 m in waves of 600 m and less: the slope is that of the same numbers in µm, and raises no doubt
    rows = 'psd = [[0.01, 3e3], [0.1, 0.7], [1.0, 1e-4]]\npsd_convention = "persson"\n'
    text = even()
    lines = warned(text[: text.index("rms_height")] + rows + text[text.index("[body]") :])
    assert any(
        line.startswith("the longest wave, 2π/q_min = 628 m is above 0.1 m") for line in lines
    )
    assert not any(line.startswith("rms slope") for line in lines)


@pytest.mark.parametrize(
    ("kelvin", "told"), [(25.0, True), (199.0, True), (201.0, False), (298.15, False)]
)
def test_a_temperature_in_celsius_is_told(kelvin, told):
    text = changed("heat_capacity =", "melting_temperature = 1700\nheat_capacity =", even())
    text = changed(
        "friction_coefficient =", f"background_temperature = {kelvin}\nfriction_coefficient =", text
    )
    lines = [
        line for line in warned(text) if "background_temperature" in line and "below 200 K" in line
    ]
    assert len(lines) == told
    assert all(f'write "{kelvin:g} degC"' in line for line in lines)


@pytest.mark.parametrize("key", ["conductivity", "friction_coefficient"])
def test_a_table_over_degrees_celsius_is_told(key):
    text = re.sub(
        rf"(?m)^{key} = .*$", f"{key} = {{ temperature = [20, 5000], value = [0.5, 0.4] }}", even()
    )
    text = changed("nominal_pressure =", "background_temperature = 293\nnominal_pressure =", text)
    assert any(f"{key}.temperature = 20 K is below 200 K" in line for line in warned(text))


def test_pressures_in_megapascal_without_their_unit_are_told_though_their_ratios_are_right():
    text = changed(
        '"200 GPa"', "2e5", changed('"1.2 GPa"', "1200", changed('"90 MPa"', "90", even()))
    )
    text = re.sub(r"speed = \[.*?\]", "speed = 0.1", text)
    (line,) = warned(text)
    assert line.startswith(
        "body.penetration_hardness = 1.2e+03 Pa is below 100000 Pa, and no solid is so soft"
    )


def test_a_speed_of_zero_is_told_to_make_no_heat():
    text = changed('speed = ["100 m/s"]', "speed = [0, 100]", even())
    scene = parse_scene(text)
    (line,) = judge(scene).warnings
    assert line.startswith(
        "sliding.speed = 0 m/s: nothing slides, so that friction makes no heat and T_flash is 0"
    )
    assert theory_dict(scene)["flash_temperature"][0] == 0.0


@pytest.mark.slow
def test_bundled_scenes_say_no_more_than_what_is_so():
    told = {
        name: [line[:14] for line in judge(rs.load_scene(name)).warnings]
        for name in bundled_scenes()
    }
    share, steep = "the heat share", "rms slope = 0."
    assert told == {
        "demo": [],
        "granite": [steep, share],  # two equal faces and the rule "mean"; C(q) goes to 1 nm
        "steel-0.5GPa": [],
        "steel-1.2GPa": [],
        "steel-2.0GPa": [],
    }
    assert warned(even()) == []


def test_the_wavenumber_up_to_which_the_slope_is_small_is_where_it_is(steel):
    (line,) = [
        line for line in judge(rs.load_scene("granite")).warnings if line.startswith("rms slope")
    ]
    q_max = float(line.split("q_max to ")[1].split()[0])
    # 2π ∫ q³ C dq of both faces by hand: C₀ = h²/2π / (∫ q C/C₀ dq), a plateau to r, then (q/r)^(−3.6)
    low, r = 6e3, 2.4e4
    height = (r**2 - low**2) / 2 + r**3.6 * (r**-1.6 - (6e9) ** -1.6) / 1.6
    slope = (r**4 - low**4) / 4 + r**3.6 * (q_max**0.4 - r**0.4) / 0.4
    assert math.sqrt(2 * (1e-6) ** 2 * slope / height) == pytest.approx(
        0.5, rel=3e-3
    )  # three digits are printed


def test_steep_waves_that_only_yield_are_told_to_change_little(steel):
    steep = replace(
        steel, surface=replace(steel.surface, rms_height=None, rms_slope=0.45)
    )  # of one face
    (line,) = judge(steep).warnings
    assert line.startswith("rms slope = 0.636 of both faces together is above 0.5")
    before = steep.spectrum.truncated(q_max=32 * facts(steep).yield_wavenumber).rms_slope
    assert f"up to 32 q_y it is {before:.3g}, and shorter waves" in line
    q_max = float(
        re.search(
            r"touch at the hardness alone; .* lower q_max to (\S+) rad/m, which changes", line
        )[1]
    )
    assert q_max > 32 * facts(steep).yield_wavenumber
    cut = steep.spectrum.truncated(q_max=q_max)
    rows = tuple((q, float(cut(q)) / 2) for q in np.geomspace(6350, q_max * (1 - 1e-9), 300))
    less = replace(steel, surface=type(steel.surface)(psd=rows, psd_convention="persson"))
    assert facts(less).rms_slope < 0.501
    assert facts(less).flash_temperature == pytest.approx(facts(steep).flash_temperature, rel=0.005)


def test_steep_waves_of_a_small_H_are_not_told_to_change_little(steel):
    surface = replace(steel.surface, hurst=0.3, rms_height=None, rms_slope=0.45)
    (line, *_) = judge(replace(steel, surface=surface)).warnings
    assert (
        "makes T_flash higher" in line
    )  # own runs with H = 0.3: 18 to 25 % above the limit at 32 q_y
    assert "changes little" not in line


def test_the_facts_are_those_of_the_scene(full_scene, capped_scene):
    found = facts(capped_scene)
    assert found.pressure_over_hardness == pytest.approx(0.09)
    assert found.hot_spots == pytest.approx(
        found.contact_fraction * (2e-3 / found.hot_spot_radius) ** 2 / math.pi
    )
    assert found.peclet_number == pytest.approx(
        np.array([0, 0.1, 35]) * found.hot_spot_radius * 7900 * 500 / 30
    )
    assert found.flash_temperature.tolist() == pytest.approx(
        theory_dict(capped_scene)["flash_temperature"]
    )
    elastic = facts(full_scene)  # E* of 100 MPa on a rigid face is E/(1 − ν²)
    assert elastic.pressure_over_modulus == pytest.approx(2e6 * 0.91 / 1e8)
    assert (elastic.pressure_over_hardness, elastic.yield_wavenumber) == (0.0, math.inf)
    assert elastic.contact_fraction == pytest.approx(1.0)
    assert elastic.longest_wave == pytest.approx(1e-3)
    assert any(line.startswith("contact on 1 of the area") for line in judge(full_scene).warnings)


def test_the_facts_for_people_are_in_the_units_that_they_say(steel):
    rows = {
        name: f"{value} {meaning}"
        for name, value, meaning in (remark.row for remark in facts(steel).rows())
    }
    # two faces of 0.9 µm; 2π/6350 1/m to 2π/4.15e7 1/m; the cell has four of the longest waves
    assert rows["rms height"] == "1.27 µm of both faces together, in waves of 0.989 mm to 0.151 µm"
    assert rows["hot spots"].endswith(" µm in a cell of 3.96 mm × 3.96 mm")
    radius = float(re.search(r"of radius (\S+) µm", rows["hot spots"])[1]) * 1e-6
    slow, fast = (float(f"{v * radius / (30 / (7900 * 500)):.2g}") for v in (1e-3, 100))
    low, high = map(
        float,
        re.match(r"(\S+) … (\S+) vr/D .*, at 0.001 … 100 m/s$", rows["Péclet number"]).groups(),
    )
    assert (low, high) == pytest.approx((slow, fast), rel=0.02)
    shortest = facts(steel).to_dict()["shortest_wave"]
    assert shortest == pytest.approx(2 * math.pi / 4.15e7)


@pytest.mark.parametrize(("target", "waves"), [(0.03, 12), (0.3, 4)])
def test_hot_spots_are_counted_in_the_planned_cell(target, waves):
    # gold: in a cell of four waves there is .88 of one hot spot, in the planned one of twelve there are 7.9
    gold = {
        "surface": {"rms_height": 5e-7, "hurst": 0.8, "q_min": 1e4, "q_max": 4.8e5},
        "body": {
            "youngs_modulus": 79e9,
            "poisson_ratio": 0.42,
            "penetration_hardness": 6e8,
            "conductivity": 315,
            "density": 19300,
            "heat_capacity": 129,
        },
        "sliding": {"nominal_pressure": 1.2e6, "friction_coefficient": 0.5, "speed": 300},
        "ensemble": {"until": {"flash_temperature": target}},
    }
    scene = rs.load_scene(gold)
    side = waves * 2 * math.pi / 1e4
    numerics = rs.plan(scene)
    assert numerics.lengths == pytest.approx((side, side))
    for found in (judge(scene), judge(scene, numerics), judge(scene, rs.plan(scene, target))):
        assert found.facts.cell == pytest.approx((side, side))
        assert found.facts.hot_spots == pytest.approx(0.876 * (waves / 4) ** 2, rel=0.01)
        spots = [line for line in found.warnings if "hot spot" in line]
        assert len(spots) == (waves == 4)
        assert all("in a cell of 2.51 mm" in line for line in spots)
    narrower = replace(numerics, lengths=(0.75 * side, 0.75 * side))  # as given to a run
    assert judge(scene, narrower).facts.hot_spots == pytest.approx(
        0.75**2 * judge(scene).facts.hot_spots
    )


def test_contact_of_less_than_a_spot_or_a_pixel_is_told_for_the_grid_in_use(steel):
    light = replace(steel, sliding=replace(steel.sliding, nominal_pressure=5e5, heat_partition=0.5))
    light = replace(light, numerics=replace(light.numerics, lengths=(4e-3, 4e-3)))
    (line,) = judge(light).warnings
    assert "of one hot spot of the theory in a cell of 4 mm" in line
    assert facts(light).hot_spots < 1.0
    levels = (rs.Level("capped", (128, 128), 5e4), rs.Level("capped", (64, 64), 5e4))
    (line,) = judge(light, rs.Numerics(levels, (4e-3, 4e-3))).warnings  # 5e5/1.2e9 of 128² pixels
    assert "makes contact on 0.00042 of the area, 6.8 pixels of the finest grid, 128 × 128" in line


def test_a_nominal_pressure_of_the_size_of_the_modulus_is_told():
    rubber = rs.load_scene(RUBBER)
    pressed = replace(
        rubber, sliding=replace(rubber.sliding, nominal_pressure=4e6)
    )  # E* = 10 MPa/(1 − 0.5²)
    assert (
        "nominal_pressure = 4e+06 Pa is 0.3 of E* = 1.33e+07 Pa, above 0.1"
        in judge(pressed).warnings[1]
    )


def test_the_hot_spot_radius_is_where_the_pressure_has_lost_half_its_correlation(steel):
    from theory import persson, plasticity

    given = {"effective_modulus": 2e11 / 0.91 / 2, "nominal_pressure": 9e7}
    smooth = plasticity.smoothed_spectrum(steel.spectrum, **given, penetration_hardness=1.2e9)
    radii = np.array([0.0, facts(steel).hot_spot_radius])
    peak, half = persson.pressure_correlation(radii, smooth, **given, gamma=0.294)
    assert half / peak == pytest.approx(0.5, rel=1e-6)


@pytest.mark.slow
def test_heat_that_gets_in_less_than_its_carriers_go_is_told():
    rubber = rs.load_scene(RUBBER)
    radius, diffusivity = facts(rubber).hot_spot_radius, 0.23 / (1200 * 1650)
    limit = 2 * radius * diffusivity / (10e-9) ** 2  # √(2rD/v) = 10 nm
    found = [
        judge(replace(rubber, sliding=replace(rubber.sliding, speed=(limit * factor,)))).warnings
        for factor in (0.98, 1.02)
    ]
    assert ["Péclet" in " ".join(lines) for lines in found] == [False, True]
    # spots that are small by themselves are no matter of Péclet
    fine = replace(rubber, surface=replace(rubber.surface, q_max=1e10))
    slow = replace(
        fine,
        sliding=replace(fine.sliding, speed=(0.95 * diffusivity / facts(fine).hot_spot_radius,)),
    )
    assert facts(slow).hot_spot_radius < 6e-9
    assert not any("Péclet" in line for line in judge(slow).warnings)


def melting(kelvin, more=""):
    return warned(
        changed("heat_capacity =", f"melting_temperature = {kelvin}\n{more}heat_capacity =", even())
    )


def test_contact_above_the_melting_temperature_is_told_with_the_background():
    hottest = max(theory_dict(parse_scene(even()))["flash_temperature"])
    (line,) = melting(hottest + 292.9)
    assert "at 100 m/s in theory, over an assumed background of 293 K" in line
    assert "above the melting_temperature" in line
    assert melting(hottest + 293.1) == []
    text = changed(
        "heat_capacity =", f"melting_temperature = {hottest + 293.1}\nheat_capacity =", even()
    )
    (line,) = warned(
        changed(
            "friction_coefficient =", "background_temperature = 400\nfriction_coefficient =", text
        )
    )
    assert "over a background of 400 K" in line
    other = "conductivity = 30\ndensity = 7900\nheat_capacity = 500\nmelting_temperature = 300"
    text = changed(
        "poisson_ratio =", "melting_temperature = 900\npoisson_ratio =", with_counterface(other)
    )
    assert any(
        "above the melting_temperature of 300 K" in line for line in warned(text)
    )  # the lower one counts


def test_what_no_solid_is_hot_enough_for_needs_no_melting_temperature():
    hottest = max(theory_dict(parse_scene(even()))["flash_temperature"])
    limit = 0.11 * (4200 - 293) / hottest  # T_flash is proportional to the friction
    assert warned(changed("= 0.11", f"= {0.999 * limit}", even())) == []
    (line,) = warned(changed("= 0.11", f"= {1.001 * limit}", even()))
    assert "above 4200 K: no material is solid there" in line


def stated_heat(text):
    """What the statements of a scene say of a stated heat share."""
    (heat,) = (
        remark.text for remark in judge(parse_scene(text)).sizes if remark.quantity == "heat"
    )
    return heat


def test_a_share_between_two_equally_rough_faces_of_one_material_is_told_unless_it_is_a_half():
    (line,) = warned(changed("0.938", '"all"'))
    assert "0.5 between equal faces, 1 for all" in line
    (line,) = warned(changed("0.938", '"mean"'))
    share, times = map(
        float,
        re.search(r"heat share (\S+) at .* 0.5 makes temperatures (\S+) times", line).groups(),
    )
    assert times == pytest.approx(0.5 / share, rel=0.005)
    assert warned(STEEL) == []  # a number is the user's own choice, and stated with what it does
    assert stated_heat(STEEL).endswith(f"0.5 makes temperatures {0.5 / 0.938:.3g} times as high")
    assert stated_heat(changed("0.938", "0.5")) == "heat_partition states it"
    body = 'youngs_modulus = "200 GPa"\npoisson_ratio = 0.3\nconductivity = 30\ndensity = 7900\nheat_capacity = 500\n'
    band = (
        "hurst = 0.8\nq_min = 6350\nq_roll_off = 9.4e4\nroll_off_exponent = 1.5\nq_max = 4.15e7\n"
    )
    for other, count in (
        (f'rms_height = "0.9 um"\n{band}{body}', 1),
        (f'rms_height = "0.2 um"\n{band}{body}', 0),
    ):
        text = with_counterface(other)
        assert stated_heat(text).count("equal faces share evenly") == count
        assert (
            sum("heat share" in line for line in warned(text.replace("0.938", '"mean"'))) == count
        )
    other = f'rms_height = "0.9 um"\n{band}{body.replace("= 30", "= 60")}'
    for text in (with_counterface(other), with_counterface(body)):
        assert warned(text) == []
        assert stated_heat(text) == "heat_partition states it"


def test_share_under_a_round_contact_is_uneven_by_itself():
    text = changed("speed =", 'contact_radius = "3 mm"\nspeed =', STEEL)
    (line,) = (each for each in warned(text.replace("0.938", '"total"')) if "heat share" in each)
    assert "hot spots rest on neither, so that T_flash is an upper bound" in line
    assert "heat_partition = 0.5" not in line


def test_the_figures_of_a_resting_spot_are_those_of_docs_partition(steel):
    from theory import flash, hertz, plasticity

    given = {"effective_modulus": 2e11 / 0.91 / 2, "nominal_pressure": 9e7}
    smooth = plasticity.smoothed_spectrum(steel.spectrum, **given, penetration_hardness=1.2e9)
    diffusivity = 30 / (7900 * 500)
    heat = {
        "friction_coefficient": 0.11,
        "conductivity": 30.0,
        "diffusivity": diffusivity,
        "gamma": 0.294,
    }
    width = float(flash.flash_width(100.0, smooth, **given, **heat))
    radius = width / hertz.FAST.flash_width
    warm, lives = radius**2 / diffusivity, 2 * radius / 35.0
    rows = dict(
        re.findall(r"(?m)^\| (\D[^|]*?) \| ([^|]*) \|$", (ROOT / "docs/partition.md").read_text())
    )
    told = {key: float(value.split()[0]) for key, value in rows.items() if value[:1].isdigit()}
    assert told["radius of a hot spot, R"] == pytest.approx(1e6 * radius, rel=0.005)
    assert told["time to warm up at rest, R²/D"] == pytest.approx(1e3 * warm, rel=0.05)
    assert told["lifetime of a spot, 2R/v"] == pytest.approx(1e6 * lives, rel=0.01)
    assert told["ratio of the two times, Pe/2"] == pytest.approx(warm / lives, rel=0.01)


@pytest.mark.slow
def test_a_scan_is_said_to_have_an_unknown_error_before_anything_is_computed():
    rows = 'psd = [[1e4, 3e-23], [1e5, 7e-27]]\npsd_convention = "persson"\n'
    text = even()
    text = text[: text.index("rms_height")] + rows + text[text.index("[body]") :]
    assert warned(text) == []  # a table of one's own is taken as stated
    (line,) = warned(text.replace("psd_convention", 'psd_source = "scan"\npsd_convention'))
    assert line.startswith(
        "C(q) was measured on a scan, and its error is unknown: psd_error is missing"
    )
    flatter = text.replace("psd = [[1e4", "psd = [[3e3, 4e-23], [1e4")
    error = 'psd_source = "scan"\npsd_error = [[{0}], [{0}], [{0}]]\npsd_convention'
    (line,) = warned(flatter.replace("psd_convention", error.format(0.3)))
    assert re.search(r"leaves .* % of error in the highest T_flash, above the target of 1 %", line)
    rising = flatter.replace(
        "4e-23", "6e-21"
    )  # as q^(−4.4): longer waves have ever more of the heights
    (line,) = warned(rising.replace("psd_convention", error.format(0.01)))
    assert line.endswith(
        "unknown: C(q) may rise without limit to waves longer than the scan; take a larger scan"
    )  # no map to press
    flat = flatter.replace("4e-23", "1e-27")  # no wave longer than the scan
    assert warned(flat.replace("psd_convention", error.format(1e-3))) == []
    for scanned in (False, True):
        scene = parse_scene(
            text.replace("psd_convention", 'psd_source = "scan"\npsd_convention')
            if scanned
            else text
        )
        told = [reason.value for reason in rs.plan(scene).reasons if reason.quantity == "scan"]
        assert told == ["unknown"] * scanned


def test_waves_too_steep_are_left_out_of_a_table_or_a_scan_where_no_key_cuts_them():
    text = even()
    face = '[[1e4, 1e-19], [1e5, 7e-23], [4e7, 1e-32]]\npsd_convention = "persson"\n'
    table = text[: text.index("rms_height")] + f"psd = {face}" + text[text.index("[body]") :]
    assert "or end the table of C(q) at " in next(
        line for line in warned(table) if "rms slope" in line
    )
    scan = table.replace("psd_convention", 'psd_source = "scan"\npsd_convention')
    line = next(line for line in warned(scan) if "rms slope" in line)
    length, q = map(
        float,
        re.search(
            r"smooth waves shorter than (\S+) µm out of the scan: q above (\S+)", line
        ).groups(),
    )
    assert length * q == pytest.approx(2e6 * math.pi, rel=0.01)


def test_a_scan_of_metres_is_told_by_its_size():
    text = even()
    rows = 'psd = [[1, 3e-10], [100, 3e-14]]\npsd_source = "scan"\npsd_convention = "persson"\n'
    lines = warned(text[: text.index("rms_height")] + rows + text[text.index("[body]") :])
    assert any(line.endswith("not roughness; check topography_size and its unit") for line in lines)


def test_a_theory_that_cannot_be_evaluated_is_said_and_stops_nothing(quick, monkeypatch):
    def none(*_):
        raise RuntimeError("the integral\nis not reached")

    monkeypatch.setattr("roughsim.planning.limits.facts_of", none)
    assert (
        "rms slope" in warned(changed('"0.90 um"', '"2 m"'))[1]
    )  # what needs no theory is told all the same
    found = judge(quick)
    (line, _) = found.warnings  # and of the speed 0 among those of this scene
    assert line.startswith(
        "the theory of this scene cannot be evaluated (the integral is not reached); contact area"
    )
    assert found.to_dict()["scene_facts"] is None


@pytest.mark.slow
def test_theory_plan_run_and_report_all_say_it(quick, tmp_path, capsys):
    scene = replace(quick, body=replace(quick.body, melting_temperature=320.0))
    path = tmp_path / "s.toml"
    path.write_text(scene.to_toml())
    hot, share = (
        "above the melting_temperature of 320 K",
        "equal faces share evenly: 0.5 makes temperatures 0.556",
    )
    for verb in ("theory", "plan"):
        with pytest.raises(SystemExit):
            main([verb, str(path), "--all"])
        shown = capsys.readouterr()
        words = " ".join(shown.out.split())
        assert shown.err.count(hot) == words.count(share) == 1
        for word in (
            "rms slope",
            "σ₀/σ_P",
            "contact area",
            "q_y = ",
            "hot spots",
            "Péclet number",
            "T_flash",
        ):
            assert word in words
        with pytest.raises(SystemExit):
            main([verb, str(path), "--json"])
        shown = capsys.readouterr()
        told = json.loads(shown.out)
        assert shown.err == ""
        assert len(told["scene_warnings"]) == 2  # one of the speed 0 among those of this scene
        assert told["scene_facts"]["pressure_over_hardness"] == pytest.approx(0.09)
        assert told["scene_facts"]["melting_temperature"] == 320.0
    with pytest.raises(SystemExit):
        main(["run", str(path), "-o", str(tmp_path / "run"), "--max", "1", "--workers", "1"])
    shown = capsys.readouterr()
    assert shown.err.count(hot) == 1
    run = rs.open_run(tmp_path / "run")
    assert str(header(run, run.warnings)).count(hot) == 1
    assert str(scene_section(run.scene, run.judged)).count(share) == 1
    assert "hot spots" in str(scene_section(run.scene, run.judged))


@pytest.mark.slow
def test_every_slip_by_a_thousand_or_a_million_is_refused_told_or_lawful():
    lawful = {
        "poisson_ratio": "no unit, and 1 − ν² changes by 9 %",
        "gamma": "no unit, of the theory alone",
        "hurst": "no unit",
        "roll_off_exponent": "no unit",
        "tolerance": "no unit, and the budget has its error",
        "heat_partition": "no unit",
    }
    quiet = []
    for name in bundled_scenes():
        scene = rs.load_scene(name)
        usual = {line[:12] for line in judge(scene).warnings}
        for section in ("surface", "body", "counterface", "sliding"):
            record = getattr(scene, section)
            for key in (field.name for field in fields(record)) if record else ():
                value = getattr(record, key)
                if key in lawful or not isinstance(value, (float, tuple)):
                    continue
                for factor in (1e-6, 1e-3, 1e3, 1e6):
                    slipped = (
                        tuple(v * factor for v in value)
                        if isinstance(value, tuple)
                        else value * factor
                    )
                    try:
                        other = replace(scene, **{section: replace(record, **{key: slipped})})
                    except SceneError:
                        continue
                    if {line[:12] for line in judge(other).warnings} <= usual:
                        quiet.append((key, factor, name))
    # all of these there are: slow sliding, polished stone, diamond,
    # and steel under 90 to 500 kPa, which touches in some spots of the planned cell
    everywhere = {("speed", 1e-6), ("speed", 1e-3)}
    assert {entry for entry in quiet if entry[:2] not in everywhere} == {
        ("q_max", 1e-3, "granite"),
        ("rms_height", 1e-3, "granite"),
        ("conductivity", 1e3, "granite"),
        *(("nominal_pressure", 1e-3, name) for name in bundled_scenes() if name != "granite"),
    }
