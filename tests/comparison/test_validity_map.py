"""The file of the map of validity: read back as written, refused when damaged, and what the shipped one holds."""

import numpy as np
import pytest
from validity_cases import simple_map
from validity_map import capped, elastic
from validity_map.file import write_validity

import roughsim as rs
from roughsim.comparison.trust import trust
from roughsim.comparison.validity_map import read_validity
from roughsim.errors import RecordError


def test_a_map_is_read_back_as_it_was_written(tmp_path):
    path = tmp_path / "map.h5"
    write_validity(path, simple_map(), {"program": "test"})
    (name, back), (_, given) = *read_validity(path).items(), *simple_map().items()
    assert name == "elastic"
    for field in ("coordinates", "labels"):
        assert getattr(back, field) == getattr(given, field)
    np.testing.assert_array_equal([pe for _, pe in back.quantities], [pe for _, pe in given.quantities])
    for field in ("place", "value", "error"):
        np.testing.assert_array_equal(getattr(back, field), getattr(given, field))


def test_a_damaged_map_is_refused(tmp_path):
    path = tmp_path / "map.h5"
    write_validity(path, simple_map(), {})
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 255
    path.write_bytes(content[: len(content) - 100])
    with pytest.raises(RecordError, match=r"map\.h5 is no readable map of validity"):
        read_validity(path)


def test_the_shipped_map_has_the_points_of_the_script():
    import validity

    shipped = read_validity()
    points = validity.whole_map()
    grid = {(p.load, p.hurst, p.bandwidth, p.plateau, p.low_exponent) for p in points if isinstance(p, elastic.Point)}
    assert set(map(tuple, shipped["elastic"].place.tolist())) == grid
    plastic = [p for p in points if isinstance(p, capped.CappedPoint)]
    expected = np.array([[p.share, p.yields, p.hurst, p.plateau, p.low_exponent] for p in plastic])
    for name in ("smoothed", "steps"):
        np.testing.assert_allclose(shipped[name].place, expected, rtol=1e-12)
    table = shipped["capped"]
    np.testing.assert_allclose(table.place[np.isinf(table.place[:, 5]), :5], expected, rtol=1e-12)
    finite = {d: (table.place[:, 5] == d).sum() for d in np.unique(table.place[:, 5])}
    assert finite[4.0] == finite[16.0] >= 30 + 3  # two q_y/q_roll_off, three H, five shares; the steels
    assert {label for label in table.labels if label} == {"steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa"}


@pytest.mark.parametrize("part", ["elastic", "smoothed", "steps", "capped"])
def test_the_shipped_map_knows_what_matters_to_three_percent(part):
    table = read_validity()[part]
    limits = np.isinf(table.place[:, -1]) | (part != "capped")
    for k, (name, _) in enumerate(table.quantities):
        if name in ("flash_temperature", "pressure_variance"):
            assert table.error[limits, k].max() <= 0.03, name
            assert table.error[:, k].max() <= 0.035, name


@pytest.mark.parametrize("name", ["steel-0.5GPa", "steel-1.2GPa", "steel-2.0GPa"])
def test_the_steel_scenes_are_points_of_the_capped_map(name):
    known = trust(rs.load_scene(name))
    assert known.source == "map"
    assert {j.observable for j in known.judgements} == {"flash_temperature", "pressure_variance"}
