"""The first micrometre on the page: controls of a skin, its thickness, and the depth in which heat is released."""

from dataclasses import replace
from math import inf, log10

from bokeh import models
from bokeh.layouts import row

from roughsim.prediction.bodies import heating
from roughsim.results.run import Run
from roughsim.scene import Scene
from roughsim.scene.skins import SkinSection

_THINNEST = 1e-8  # m, of the sliders: Fourier's law fails in thinner skins
_STEPS = 20  # of a slider in a decade
_UM = 1e6  # µm/m
_SCENE, _OXIDE, _WORKED = "scene", "oxide", "worked"


class SkinControls:
    """The controls of a skin and of the depth of the heat, and the scene of the run with the chosen ones.

    The first position of a slider is none; the others are log10 of a length in µm.
    """

    def __init__(self, run: Run):
        self.own = run.scene
        body = self.own.body
        kappa = heating(self.own, max(self.own.speeds)).bodies.conductivity
        # of an iron oxide, and of a worked layer; left out, density and heat capacity are those of the body
        self.skins = {
            _OXIDE: SkinSection(
                thickness=_THINNEST, conductivity=3.0, density=5200.0, heat_capacity=650.0
            ),
            _WORKED: SkinSection(thickness=_THINNEST, conductivity=0.5 * kappa),
        }
        names = {_SCENE: "of the scene", _OXIDE: "oxide", _WORKED: "half the κ"}
        if body.skin is not None:
            self.skins = {_SCENE: body.skin, **self.skins}
        options = [
            (key, f"{names[key]}, {skin.conductivity:.3g} W/(m K)")
            for key, skin in self.skins.items()
        ]
        self.material = models.Select(
            title="skin", options=options, value=options[0][0], width=180, name="skin"
        )
        thickness, depth = (body.skin.thickness if body.skin else 0.0), body.heat_depth or 0.0
        lowest = min(_THINNEST, thickness or inf, depth or inf)
        highest = max(0.1 * min(run.sides), thickness, depth, 10 * lowest)
        low, high = log10(lowest * _UM), log10(highest * _UM)
        label = f"return tick < {low - 0.5 / _STEPS} ? 'none' : Number(Math.pow(10, tick).toPrecision(3)) + ' µm'"
        lengths = {
            "skin_thickness": ("its thickness d", thickness),
            "heat_depth": ("depth of the heat h", depth),
        }
        start, step = low - 1 / _STEPS, 1 / _STEPS
        sliders = []
        for name, (title, length) in lengths.items():
            value = log10(length * _UM) if length else start
            slider = models.Slider(
                title=title, name=name, start=start, end=high, step=step, value=value
            )
            slider.update(width=230, format=models.CustomJSTickFormatter(code=label))
            sliders.append(slider)
        self.thickness, self.heat_depth = sliders
        self.camera = models.Checkbox(
            label="through the camera",
            active=True,
            name="camera",
            visible=self.own.camera is not None,
        )
        chosen = self.material, self.thickness, self.heat_depth, self.camera
        self.row = row(*chosen, styles={"flex-wrap": "wrap"})

    def scene(self) -> Scene:
        """Return the scene of the run with the chosen skin and depth, and without its camera if that is not chosen."""
        thickness, depth = _length(self.thickness), _length(self.heat_depth)
        skin = replace(self.skins[self.material.value], thickness=thickness) if thickness else None
        body = replace(self.own.body, skin=skin, heat_depth=depth)
        if self.own.camera is None or self.camera.active:
            return replace(self.own, body=body)
        aimless = replace(self.own.ensemble, until=())  # a target may be of the camera
        return replace(self.own, body=body, camera=None, ensemble=aimless)


def _length(slider: models.Slider) -> float | None:
    """Return the length of a slider, m, or None at its first position."""
    if slider.value < slider.start + 0.5 / _STEPS:
        return None
    return float(10.0**slider.value / _UM)


def layers_text(scene: Scene) -> str:
    """Return the skin and the depth of the heat of a scene in a few words."""
    skin, depth = scene.body.skin, scene.body.heat_depth
    words = "no skin"
    if skin:
        words = f"skin {skin.thickness * _UM:.3g} µm, {skin.conductivity:.3g} W/(m K)"
    return f"{words}, heat {depth * _UM:.3g} µm deep" if depth else words
