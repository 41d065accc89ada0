"""Every number of a run has every part of the error, known or unknown: no observable can leave one out."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from press_cases import drawn_map, write_scene
from slide_cases import SLIDING as TEXT

import roughsim as rs
from roughsim.estimate.errors import SOURCES
from roughsim.estimate.mean import Mean
from roughsim.results import means, surfaces
from roughsim.results.columns import columns_of, is_ratio
from roughsim.results.pressed import OVERSHOOT
from roughsim.scene import parse_scene
from roughsim.scene.numerics import SLIDING
from roughsim.studies.trends import paired_ratio

pytestmark = pytest.mark.usefixtures("few_fields")
OF_LEVELS = "bandwidth", "last step", "pixel"
SHOWN_BY_NO_LEVEL = "size", "solver", "scan"
OF_REACTIONS = "reaction_rate", "activation_temperature", "conversion", "heat_share_above"
# of the relative error of T_flash: T_act includes the background, and the last two may saturate
LEAST = {"activation_temperature": 0.1, "conversion": 0.0, "heat_share_above": 0.0}
BY_THE_SLIDE = OF_LEVELS  # of the share of a slide: its part "slide" has them
ASKS = """
[observables]
heat_above = ["300 K"]
[reaction]
activation_energy = ["0.3 eV"]
prefactor = "1e7 1/s"
contact_length = "1 mm"
"""


def asking(rule):
    history = 'history = "sliding"\nbackground_temperature = "250 K"\nduration = "0.5 ms"'
    text = TEXT.replace("heat_partition = 0.9", f"heat_partition = {rule}\n{history}").replace(
        "[1, 35]", "[1, 3]"
    )
    smoothed = '{ column = "smoothed", shape = [32, 32], q_max = 2.5e4 },\n'
    return parse_scene(text.replace("levels = [\n", f"levels = [\n{smoothed}") + ASKS)


@pytest.fixture(scope="module", params=["0.9", pytest.param('"mean"', marks=pytest.mark.slow)])
def slid(request, tmp_path_factory):
    return rs.run(asking(request.param), tmp_path_factory.mktemp("every") / "run", workers=1)


@pytest.fixture(scope="module")
def pressed(capped_scene, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pressed")
    path = write_scene(folder, drawn_map(), capped_scene)
    text = path.read_text().replace(
        "speed = [0.0, 0.1, 35.0]", "speed = [35.0]\nbackground_temperature = 250.0"
    )
    path.write_text(text[: text.index("[numerics]")] + ASKS)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return rs.press(path, folder / "run")


def along_labels(asked):
    """Return the estimates over speed of a reaction at each energy, or of hot heat at each temperature."""
    (axis, _) = asked.dims
    return [asked.sel(**{axis: label}) for label in asked.coords[axis]]


def numbers_of(run):
    """Yield each number that a run gives, with its name and column."""
    columns = [*run.numerics.columns, *([SLIDING] if run.numerics.slide is not None else [])]
    for column in columns:
        for name, found in run.estimates(column).items():
            yield name, column, found
        for name, asked in run.reactions(column).items():
            for one in along_labels(asked):
                yield name, column, one
        if run.scene.sliding.duration is not None:
            yield "contact_temperature", column, run.contact_temperature(column)
    functions = {name: of for name, of in columns_of(run).items() if is_ratio(name)}
    for name in run.observables:
        for ratio, found in functions.items():
            yield name, ratio, found(name)
        yield name, "paired", paired_ratio(run, run, name)


def inject(monkeypatch, part, relative):
    """Let a part of the error be so large, relative to each mean, where it arises; other parts stay."""
    genuine = means.values_of

    def values_of(*args, **kwargs):
        values = genuine(*args, **kwargs)
        return replace(values, errors={**values.errors, part: np.abs(values.value) * relative})

    if part in OF_LEVELS:
        monkeypatch.setattr(means, "values_of", values_of)
    elif part == "size":
        monkeypatch.setattr(surfaces, "size_error", lambda *args: relative)
    elif part == "scan":
        monkeypatch.setattr(
            means, "scan_error", lambda scene: dict.fromkeys(means.OBSERVABLES, relative)
        )
        monkeypatch.setattr(rs.Scene, "scanned", True)
    else:
        monkeypatch.setattr(Mean, "with_errors", with_solver(Mean.with_errors, relative))


def with_solver(genuine, relative):
    return lambda values, **parts: genuine(values, **parts | {"solver": relative})


def lacks(part, name, column):
    """Whether a number rightly has not this part."""
    if column.endswith("_over_theory") and part in ("bandwidth", "last step"):
        return True  # both at one cut-off
    return column == SLIDING and name == "heat_partition" and part in BY_THE_SLIDE


@pytest.mark.parametrize(
    ("part", "relative"),
    [
        *((part, 0.05) for part in (*OF_LEVELS, *SHOWN_BY_NO_LEVEL)),
        *((part, np.nan) for part in ("bandwidth", "size", "scan")),
        *(
            pytest.param(part, np.nan, marks=pytest.mark.slow)
            for part in ("last step", "pixel", "solver")
        ),
    ],
)
def test_every_number_has_every_part(slid, monkeypatch, part, relative):
    inject(monkeypatch, part, relative)
    seen = set()
    for name, column, found in numbers_of(rs.open_run(slid.folder)):
        seen.add((name, column))
        changes = np.isfinite(found.mean) & (found.mean != 0.0)
        if lacks(part, name, column) or not changes.any():
            continue
        assert part in found.budget, (name, column)
        error = found.budget[part][changes]
        cancels = part == "scan" and (
            "over" in column or column == "paired"
        )  # nothing shows whether it does
        # no level of this run shows what else the pixel changes of a reaction
        if (
            np.isnan(relative)
            or cancels
            or (part == "pixel" and name in OF_REACTIONS and column != SLIDING)
        ):
            assert np.isnan(error).all(), (name, column)
            assert all(part in found.unknown_at(k) for k in np.nonzero(changes)[0]), (name, column)
        else:
            least = LEAST.get(name, 0.2) * relative
            assert (error > least * np.abs(found.mean[changes])).all(), (name, column)
    columns = {column for _, column in seen}
    assert columns == {
        "smoothed",
        "capped",
        SLIDING,
        "smoothed_over_theory",
        "capped_over_smoothed",
        "paired",
    }
    of_capped = {name for name, column in seen if column == "capped"}
    assert of_capped == {*slid.observables, *OF_REACTIONS, "contact_temperature"}
    of_fields = {"form", "law"}  # of the theory
    assert {*OF_LEVELS, *SHOWN_BY_NO_LEVEL, "statistical", "tail", "slide"} == {
        *SOURCES
    } - of_fields


@pytest.mark.slow
@pytest.mark.parametrize("unknown", [True, False])
def test_a_pressed_map_has_every_part(pressed, monkeypatch, unknown):
    overshoot = {OVERSHOOT: 0.02 if unknown else 0.0}  # share of the load on spikes
    monkeypatch.setattr("roughsim.results.pressed._of_last_level", lambda *_: overshoot)
    run = rs.open_run(pressed.folder)
    numbers = [
        *run.estimates().items(),
        *((name, one) for name, asked in run.reactions().items() for one in along_labels(asked)),
    ]
    for name, found in numbers:
        assert {"statistical", "bandwidth", "pixel", "size", "solver"} <= {*found.budget}
        if found.mean.any() and np.isfinite(found.mean).all():
            assert ("bandwidth" in found.unknown) >= unknown, name
            assert found.budget["size"][-1] > 0.0 or np.isnan(found.budget["size"][-1]), name


@pytest.mark.parametrize("name", ["reaction_rate", "activation_temperature"])
@pytest.mark.parametrize("wrong", ["flash_temperature", "heat_partition", "contact_fraction"])
def test_reactions_follow_the_error_of_the_scan(slid, monkeypatch, name, wrong):
    # what changes if one of the three is 1 % higher is the part by 1 % of it; the share warms the background, too
    run = rs.open_run(slid.folder)

    def found():
        return along_labels(run.reactions("capped")[name])[0]

    before, genuine = found().mean, means.Means.values

    def higher(self, observable, *args, **kwargs):
        values = genuine(self, observable, *args, **kwargs)
        return replace(values, value=1.01 * values.value) if observable == wrong else values

    with monkeypatch.context() as patch:
        patch.setattr(means.Means, "values", higher)
        change = found().mean - before
    nothing = dict.fromkeys(("flash_temperature", "heat_partition", "contact_fraction"), 0.0)
    monkeypatch.setattr(means, "scan_error", lambda scene: nothing | {wrong: 0.01})
    monkeypatch.setattr(rs.Scene, "scanned", True)
    error = found().budget["scan"]
    if wrong != "heat_partition":
        np.testing.assert_allclose(error, change, rtol=0.1, atol=1e-9)
    else:  # the error of the background counts as one of T_flash, which is a little more
        assert (error >= 0.98 * change).all()
        assert (error <= 2.0 * change).all()
