"""The real area of contact, and the part of it that has yielded."""

from __future__ import annotations

from roughsim.observables.record import Number, Observable

NUMBERS = (
    Number("contact_fraction", "1", "A/A0", lambda one: one.contact.contact_fraction),
    Number(
        "plastic_fraction",
        "1",
        "share of the cell at the penetration hardness",
        lambda one: one.contact.plastic_fraction,
    ),
    Number(
        "contact_fraction_corrected",
        "1",
        "A/A0 less what the pixels add along the edge of the contact",
        lambda one: one.observables.contact_fraction_corrected,
    ),
    Number(
        "plastic_fraction_corrected",
        "1",
        "plastic_fraction with what the pixels take along its edge",
        lambda one: one.observables.plastic_fraction_corrected,
    ),
)

OBSERVABLES = (
    Observable(
        "contact_fraction",
        "1",
        theory=lambda theory: theory.area_fractions["contact_fraction"],
        pixel_orders=(1.0, 1.0),
        by_force_balance=True,
    ),
    Observable(
        "plastic_fraction",
        "1",
        theory=lambda theory: theory.area_fractions["plastic_fraction"],
        pixel_orders=(2.0, 1.0),
        by_force_balance=True,
    ),
)
