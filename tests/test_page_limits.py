"""Limits and constants that the pages state are those of the code."""

import re
from importlib import import_module
from pathlib import Path

import pytest

from roughsim.observables.catalogue import OBSERVABLES

DOCS = Path(__file__).parents[1] / "docs"
# page, its words with {} for each number, and where the code has these: module:NAME, one place or key in brackets,
# and the factor from its unit to the page's
STATED = [
    ("clusters", "is taken over after {} s", ["roughsim.store.claims:LEASE"]),
    (
        "clusters",
        "once more than {} s of computing are left",
        ["roughsim.ensemble.executors:_WORTH_PROCESSES"],
    ),
    (
        "clusters",
        "with {} GB for each process, take {} % of the memory",
        ["roughsim.machine:PROCESS * 1e-9", "roughsim.machine:SHARE * 100"],
    ),
    ("clusters", "at {} bytes per point", ["roughsim.machine:BYTES_PER_POINT"]),
    ("errors", "with {} pixels per shortest wave", ["roughsim.planning.levels:PIXELS"]),
    (
        "errors",
        "has about {} points per side (within √2) for 1 %, fewer for a looser target: 266 for 3 %. The largest has {},",
        ["roughsim.planning.levels:BASE_SIDE", "roughsim.planning.levels:SIDE"],
    ),
    (
        "errors",
        "has {} realizations of the lowest level of each column, and {} of",
        ["roughsim.estimate.rounds:FIRST", "roughsim.estimate.rounds:FIRST_STEP"],
    ),
    ("errors", "It begins with {} realizations.", ["roughsim.estimate.rounds:FIRST_ADDED"]),
    (
        "errors",
        "the usual value: 1, and {} + {} H below H = 2/3",
        ["roughsim.prediction.cut_offs:_FALL[0]", "roughsim.prediction.cut_offs:_FALL[1]"],
    ),
    ("errors", "| the law | {0} % | {0} % | {0} % |", ["roughsim.estimate.limit:_OF_LAW * 100"]),
    ("errors", "with {} % of T_flash:", ["roughsim.estimate.limit:_OF_ELASTIC * 100"]),
    ("errors", "| 50 % | {0} % | {0} % |", ["roughsim.estimate.limit:OF_SHAPE * 100"]),
    ("errors", "| 100 % | 50 % | {} % | Areas", ["roughsim.estimate.limit:_OF_STEPS * 100"]),
    ("errors", "drawn to 1, and known to {}", ["roughsim.estimate.limit:_USUAL_SCATTER"]),
    (
        "errors",
        "the exponent of C(q) grows by more than {} further on",
        ["roughsim.prediction.cut_offs:_ALIKE"],
    ),
    (
        "errors",
        "taken to fall as q_c^(−{}), in elastic contact as q_c^(−{})",
        [
            "roughsim.estimate.levels:PIXEL_FALL[capped]",
            "roughsim.estimate.levels:PIXEL_FALL[elastic]",
        ],
    ),
    (
        "errors",
        "and {} times the last change counts as error",
        ["roughsim.estimate.telescoping:_TURNING"],
    ),
    (
        "errors",
        "e = ({}/A + {})/N",
        [
            "roughsim.estimate.cell_size:_FEW_ASPERITIES",
            "roughsim.estimate.cell_size:_ALL_ASPERITIES",
        ],
    ),
    (
        "errors",
        "where less than {} % of the contact yields",
        ["roughsim.prediction.cut_offs:_ELASTIC * 100"],
    ),
    (
        "errors",
        "where {} % has yielded at the last two",
        ["roughsim.prediction.cut_offs:_YIELDED * 100"],
    ),
    ("errors", "({} times it in elastic contact", ["roughsim.estimate.cell_size:_ELASTIC"]),
    (
        "errors",
        "of {} to {} longest waves",
        ["roughsim.estimate.cell_size:_WAVES[0]", "roughsim.estimate.cell_size:_WAVES[-1]"],
    ),
    ("errors", "all other realizations, from {} on", ["roughsim.estimate.regression:LEAST_FITTED"]),
    ("explore", "at most {} × {} pixels", ["roughsim.explore.content:PIXELS"] * 2),
    ("explore", "at up to {} positions", ["roughsim.sliding.member:FRAMES"]),
    ("files", "than version {} are refused", ["roughsim.store.member_files:FORMAT"]),
    ("files", "in {} bins per decade", ["roughsim.surface.topography.measured:BINS_PER_DECADE"]),
    (
        "how-to/topography",
        "Up to {} % are filled",
        ["roughsim.surface.topography.reading:_MOST_UNDEFINED * 100"],
    ),
    (
        "how-to/topography",
        "more than {} % of the load is on overshoot",
        ["roughsim.results.pressed:SOME_LOAD * 100"],
    ),
    (
        "how-to/topography",
        "in cells above {} points per side",
        ["roughsim.ensemble.press:MOST_SIDE"],
    ),
    (
        "how-to/topography",
        "{} times the scatter of the four quadrants",
        ["roughsim.results.pressed:SHARED"],
    ),
    ("limits", "rms slope of both faces above {};", ["roughsim.prediction.facts:STEEP"]),
    ("limits", "above {} E*;", ["roughsim.planning.limits:_STRAIN"]),
    ("limits", "stiffer than {} GPa", ["roughsim.planning.limits:_STIFF * 1e-9"]),
    (
        "limits",
        "fewer than {} pixels of the finest grid, on less than one hot spot, or, in theory, on more than {} of",
        ["roughsim.planning.limits:_LEAST_PIXELS", "roughsim.planning.limits:_COMPLETE"],
    ),
    ("limits", "or above {} K", ["roughsim.planning.limits:_HOTTEST"]),
    ("limits", "enters a spot by less than {} nm", ["roughsim.planning.limits:_FREE_PATH * 1e9"]),
    ("limits", "({} K if left out)", ["roughsim.prediction.facts:_ROOM"]),
    (
        "reactions",
        "and {} % of T more",
        ["roughsim.estimate.sliding:UNCERTAINTY_OF_DISTRIBUTION * 100"],
    ),
    (
        "sliding",
        "The cut-off counts {} %",
        ["roughsim.estimate.sliding:_UNCERTAINTY_OF_CUT_OFF * 100"],
    ),
    ("sliding", "{} % counts as error", ["roughsim.prediction.sliding:CONTINUED * 100"]),
    ("stability", "the number of its format, {},", ["roughsim.store.member_files:FORMAT"]),
    (
        "yielding",
        "ANSWER = {}, EDGE = {}, ONSET = {} and RIM = {},",
        [
            "theory.scattering:ANSWER",
            "theory.yielding:EDGE",
            "theory.yielding:ONSET",
            "theory.yielding:RIM",
        ],
    ),
    (
        "yielding",
        "more than {} octaves of weak waves are refused ({} in elastic contact)",
        ["theory.validity:GAPS[1]", "theory.validity:_ELASTIC_GAPS[1]"],
    ),
    (
        "yielding",
        "σ₀/σ_P from {} to {}, q_r/q_min from {} to {}, H from {} to {}, q_max/q_min from {}, and",
        [
            *(
                f"theory.validity:{name}[{k}]"
                for name in ("_SHARE", "_PLATEAU", "_HURST")
                for k in (0, 1)
            ),
            "theory.validity:_BAND[0]",
        ],
    ),
    (
        "yielding",
        "q_y/q_r from {} to {} where all has yielded, else q_max/q_r from {} to {}.",
        [f"theory.validity:{name}[{k}]" for name in ("_YIELDED", "_YIELDING") for k in (0, 1)],
    ),
    (
        "yielding",
        "σ₀/(E*h′) from {}, H to 1, q_max/q_min from {}, q_max/q_r up to {}.",
        [
            "theory.validity:_ELASTIC_LOAD[0]",
            "theory.validity:_ELASTIC_BAND[0]",
            "theory.validity:_ELASTIC_END[1]",
        ],
    ),
]


def number(place):
    """A constant of the code as a page writes it."""
    module, name, index, factor = re.fullmatch(
        r"([\w.]+):(\w+)(?:\[(-?\d|\w+)\])?(?: \* ([\de.-]+))?", place
    ).groups()
    value = getattr(import_module(module), name)
    if index is not None:
        value = value[index if isinstance(value, dict) else int(index)]
    return f"{value * float(factor or 1):.10g}"


@pytest.mark.parametrize(
    ("page", "words", "places"), STATED, ids=[f"{page}: {words}" for page, words, _ in STATED]
)
def test_a_page_states_the_number_of_the_code(page, words, places):
    text = " ".join((DOCS / f"{page}.md").read_text(encoding="utf-8").split())
    assert words.format(*map(number, places)) in text


def test_the_page_of_errors_states_the_shares_of_the_tolerance():
    text = " ".join((DOCS / "errors.md").read_text(encoding="utf-8").split())
    shares = {name: f"{one.solver_share:g}" for name, one in OBSERVABLES.items()}
    names = "flash_temperature", "flash_laplacian", "flash_gradient", "contact_fraction"
    words = (
        "at most {} of the tolerance for T_flash and heat shares, {} for ∇²T_flash, {} for T′_flash, d_flash, g_σ(0) "
        "and the radii, {} for areas and D_flash"
    )
    assert words.format(*(shares[name] for name in names)) in text
    same = [
        ("flash_temperature", "heat_partition"),
        ("flash_gradient", "slope_length"),
        ("contact_fraction", "flash_width"),
    ]
    assert [pair for pair in same if len({shares[name] for name in pair}) > 1] == []


def test_the_page_of_errors_states_the_orders_of_convergence():
    text = " ".join((DOCS / "errors.md").read_text(encoding="utf-8").split())
    elastic, capped = OBSERVABLES["flash_temperature"].pixel_orders
    areas = OBSERVABLES["contact_fraction"].pixel_orders
    words = f"{capped:g} for T_flash of capped contact, {areas[1]:g} for its areas, {elastic:g} for both in elastic contact"
    assert areas[0] == elastic
    assert words in text
