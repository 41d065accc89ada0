"""The numbers of docs/validity.md follow from the stored contacts, with the theory and the law as they are now."""

import json
from pathlib import Path

import law_cases  # noqa: F401  (finds the folder of the script)
import pytest
import validity

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def stored():
    return json.loads((ROOT / "docs" / "evidence" / "validity.json").read_text())


@pytest.mark.slow
def test_the_file_of_the_page_is_what_theory_and_law_give_today(stored):
    numbers, tables, _ = validity.compared()
    assert tables == stored["tables"]
    assert numbers == pytest.approx(stored["numbers"], rel=1e-6)


def test_each_cell_where_c_ends_has_ten_contacts():
    ended = [c for c in validity.CONTACTS["yielding"] if c["depth"] and c["plateau"] == 2.0]
    places = [(c["hurst"], c["depth"]) for c in ended]
    assert {place: places.count(place) for place in places} == dict.fromkeys(places, 10)


def test_a_theory_off_by_a_known_factor_is_told_with_its_sign():
    # a record that is the theory itself: off by nothing, and twice the theory by 100 %
    contact = dict(validity.CONTACTS["elastic"][0], load=0.6)
    exact = {
        name: {"value": value, "error": [0.01]}
        for name, value in validity.by_theory(contact).items()
    }
    ratios = validity.over_measured([contact | exact], validity.by_theory)
    numbers = validity.elastic_numbers([contact | exact], ratios)
    assert numbers["fast_heavy"] == numbers["variance"] == 0.0
    doubled = {name: 2.0 * ratio for name, ratio in ratios.items()}
    numbers = validity.elastic_numbers([contact | exact], doubled)
    assert (numbers["slow_heavy_most"], numbers["fast_cool"]) == (100.0, -100.0)
    assert numbers["area_most"] == numbers["variance"] == -50.0
