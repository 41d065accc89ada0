"""Theory of a scene: the only room that calls the package `theory`.

It is integrated over C(q), over all of it or up to a cut-off, or summed over the modes of a cell. Both give the same
record (`TheoryOfScene`), from which an observable takes its value. Temperatures are with all the heat in one body.
"""

from roughsim.prediction.areas import area_fractions, computed, yield_wavenumber
from roughsim.prediction.asperities import asperities
from roughsim.prediction.balance import backgrounds, balanced
from roughsim.prediction.bodies import (
    background,
    conduction,
    friction_coefficient,
    heat_partition,
    heat_per_pressure,
    heat_source,
    turned,
)
from roughsim.prediction.camera import (
    beyond_cell,
    camera_of,
    error_of_law,
    of_level,
    slid_distances,
)
from roughsim.prediction.cut_offs import (
    calibrated_flash,
    continuation,
    follows_power,
    follows_theory,
    in_motion,
    slow,
    usual_exponent,
)
from roughsim.prediction.fields import drawn_pictures, frozen_fields, slid_fields
from roughsim.prediction.law import calibrated
from roughsim.prediction.modes import mode_sums
from roughsim.prediction.sliding import (
    check_continuation,
    sliding_continuation,
    sliding_error,
    sliding_prediction,
)
from roughsim.prediction.stress import headings_of_fields, smoothed_spectrum
from roughsim.prediction.theories import (
    calibrated_correlation,
    calibrated_over_speed,
    calibrated_predictions,
    calibrated_share,
    correlation,
    over_speed,
    predictions,
    stress_spectrum,
)

__all__ = [
    "area_fractions",
    "asperities",
    "background",
    "backgrounds",
    "balanced",
    "beyond_cell",
    "calibrated",
    "calibrated_correlation",
    "calibrated_flash",
    "calibrated_over_speed",
    "calibrated_predictions",
    "calibrated_share",
    "camera_of",
    "check_continuation",
    "computed",
    "conduction",
    "continuation",
    "correlation",
    "drawn_pictures",
    "error_of_law",
    "follows_power",
    "follows_theory",
    "friction_coefficient",
    "frozen_fields",
    "headings_of_fields",
    "heat_partition",
    "heat_per_pressure",
    "heat_source",
    "in_motion",
    "mode_sums",
    "of_level",
    "over_speed",
    "predictions",
    "slid_distances",
    "slid_fields",
    "sliding_continuation",
    "sliding_error",
    "sliding_prediction",
    "slow",
    "smoothed_spectrum",
    "stress_spectrum",
    "turned",
    "usual_exponent",
    "yield_wavenumber",
]
