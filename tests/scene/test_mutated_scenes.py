"""Scenes as people get them wrong: every one is refused in one line that names the key and says how to mend it."""

import random
import re

import pytest

from roughsim import cli
from roughsim.scene import bundled_scenes, scene_text

SEED, EACH = 10, 18  # × 12 kinds = 216
MENDS = re.compile(
    r"did you mean|write|for example|give |remove|add |change|lower|raise|must be|must lie|refine|check |sort|"
    r"needs quotes|is it the right file|it belongs in|keep exactly one|leave|is expected|the choice is|enough"
)
NEEDED = (
    *(
        "hurst",
        "q_min",
        "q_max",
        "youngs_modulus",
        "poisson_ratio",
        "conductivity",
        "density",
        "heat_capacity",
    ),
    *("nominal_pressure", "friction_coefficient", "speed"),
)
WITH_UNIT = {
    "rms_height": ("s", "kg"),
    "q_min": ("m", "1/s"),
    "q_max": ("um", "Pa"),
    "youngs_modulus": ("GPa/m", "N"),
    "conductivity": ("W/m", "W/(m^2 K)"),
    "density": ("kg", "g/m^2"),
    "heat_capacity": ("J/K", "J/kg"),
    "nominal_pressure": ("N", "m/s"),
    "speed": ("m", "MPa"),
}
POSITIVE = (
    *WITH_UNIT,
    "hurst",
    "friction_coefficient",
    "heat_partition",
    "gamma",
    "seed",
    "max_realizations",
)
NUMBERS = (*WITH_UNIT, "hurst", "poisson_ratio", "friction_coefficient", "heat_partition", "gamma")


def value_of(text, key):
    return re.search(rf"(?m)^{key} = ([^#\n]*?) *(?:#|$)", text)


def with_value(text, key, value):
    """The scene with another value of one of its keys."""
    found = value_of(text, key)
    return text[: found.start(1)] + value + text[found.end(1) :]


def having(text, keys, rng):
    return rng.choice([key for key in keys if value_of(text, key)])


def misspelt(text, rng):
    key = having(text, NEEDED, rng)
    place = rng.randrange(1, len(key))
    wrong = (
        key[:place]
        + rng.choice([key[place] * 2, "", "x", key[place].upper() + "z"])
        + key[place + 1 :]
    )
    return re.sub(rf"(?m)^{key} = ", f"{wrong} = ", text), wrong


def missing(text, rng):
    key = having(text, NEEDED, rng)
    return re.sub(rf"(?m)^{key} = .*\n", "", text), key


def wrong_unit(text, rng):
    key = having(text, WITH_UNIT, rng)
    return with_value(text, key, f'"3 {rng.choice(WITH_UNIT[key])}"'), key


def unknown_unit(text, rng):
    key = having(text, WITH_UNIT, rng)
    return with_value(
        text, key, f'"3 {rng.choice(["umm", "GigaPa", "1//m", "%%", "m/", "°K/"])}"'
    ), key


def unquoted_unit(text, rng):
    key = having(text, ("rms_height", "q_min", "nominal_pressure"), rng)
    return with_value(text, key, value_of(text, key)[1].strip('"')), key


def wrong_sign(text, rng):
    key = having(text, POSITIVE, rng)
    return with_value(text, key, f"-{rng.randint(1, 9)}"), key


def not_a_number(text, rng):
    key = having(text, NUMBERS, rng)
    return with_value(
        text, key, rng.choice(["nan", "-nan", "inf", '"nan"', '"NaN m"', "[nan, nan]"])
    ), key


def not_the_kind(text, rng):
    key = having(text, NEEDED[:-1], rng)
    return with_value(
        text, key, rng.choice(["true", "[]", "{}", '""', "[[1]]", "1979-05-27", '"many"'])
    ), key


def swapped(text, rng):
    low, high = rng.choice(
        [pair for pair in (("q_min", "q_max"), ("q_roll_off", "q_max")) if value_of(text, pair[0])]
    )
    first, second = value_of(text, low)[1], value_of(text, high)[1]
    return with_value(with_value(text, low, second), high, first), "q_"


def beyond_nyquist(text, rng):
    points = rng.choice([16, 64, 255])
    column = "smoothed" if value_of(text, "penetration_hardness") else "elastic"
    level = f'lengths = "4 mm"\nlevels = [{{ column = "{column}", shape = {points}, q_max = {points * 3142 / 4 * 1.1} }}]\n'
    return text.split("[numerics]")[0] + "[numerics]\n" + level, "levels[0].q_max"


def soft(text, rng):
    if not value_of(text, "penetration_hardness"):
        text = text.replace("[body]", '[body]\npenetration_hardness = "1 GPa"')
    return with_value(
        text, "penetration_hardness", f'"{rng.uniform(0.001, 0.099)} MPa"'
    ), "penetration_hardness"


def huge(text, rng):
    kind = rng.randrange(4)
    if kind == 0:
        return text + "#" * 65536, "64 KiB"
    if kind == 1:
        return with_value(text, "hurst", "9" * 20000), "hurst"
    if kind == 2:
        return text + "x = " + "[" * 3000, "nested too deeply"
    return text + "".join(f"key_{i} = {i}\n" for i in range(3000)), "key_"


KINDS = (
    *(misspelt, missing, wrong_unit, unknown_unit, unquoted_unit, wrong_sign),
    *(not_a_number, not_the_kind, swapped, beyond_nyquist, soft, huge),
)


def refusal(capsys, path):
    with pytest.raises(SystemExit) as ended:
        cli.main(["plan", str(path)])
    printed = capsys.readouterr()
    assert ended.value.code == 1
    assert printed.out == ""
    *before, refused = printed.err.splitlines()
    assert [line.partition(" ")[2].split()[0] for line in before] in ([], ["planning"])
    return f"{refused}\n"


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_each_mistake_is_refused_in_one_line_that_names_the_key_and_the_cure(
    kind, capsys, tmp_path
):
    rng = random.Random(f"{SEED} {kind.__name__}")
    for trial in range(EACH):
        text, named = kind(scene_text(rng.choice(bundled_scenes())), rng)
        path = tmp_path / f"{kind.__name__}-{trial}.toml"
        path.write_text(text)
        message = refusal(capsys, path)
        assert message.startswith("roughsim: "), message
        assert path.name in message or kind is beyond_nyquist, message
        assert named in message, (named, message)
        assert MENDS.search(message), message
        assert len(message) < 420, message
