"""The sections of a scene file on the distribution of the temperature: [observables] and [reaction]."""

from typing import Annotated

from pydantic import StrictBool

from roughsim.scene.schema import KELVIN, Quantity, Record, one_or_list, record

_TINY = 1e-40  # m³: volumes of atoms are 1e-29
_LARGEST_VOLUME = 1e-26  # m³: σV/k_B T of any solid stays within floats


@record("observables")
class ObservablesSection(Record):
    """Observables that are measured only if the scene asks for them."""

    temperature_distribution: StrictBool = False
    """Whether members store quantiles of the temperature over the contact."""
    heat_above: Annotated[tuple[Annotated[float, KELVIN], ...], one_or_list()] | None = None
    """Absolute temperatures, such as the weakening temperature of flash heating: the share of the heat that is set
    free where the contact is hotter."""


@record("reaction")
class ReactionSection(Record):
    """A thermally activated reaction of the surface of the moving body, with the rate ν exp(−(E − σV)/k_B T)."""

    activation_energy: Annotated[
        tuple[Annotated[float, Quantity("J", '"1 eV"', ge=0, le=1e-17)], ...],
        one_or_list(),
    ]
    """E of one molecule; several are computed side by side."""
    activation_volume: Annotated[
        float,
        Quantity(
            "m^3",
            '"10 angstrom^3"',
            ge=-_LARGEST_VOLUME,
            le=_LARGEST_VOLUME,
            smallest=_TINY,
        ),
    ] = 0.0
    """V, by which the pressure lowers the barrier."""
    prefactor: Annotated[float, Quantity("1/s", '"1e13 1/s"', gt=0)]
    """ν, attempts per second."""
    contact_length: Annotated[float, Quantity("m", '"1 cm"', gt=0)] | None = None
    """Of the nominal contact along sliding, for the conversion in one pass; None: no conversion."""
