"""Estimates over named axes, taken apart."""


def by_label(estimates):
    """Estimates over the speed by observable, energy and temperature."""
    return {
        (name, *((label, None) if one.dims[0] == "energy" else (None, label))): one.sel(
            **{one.dims[0]: label}
        )
        for name, one in estimates.items()
        for label in one.coords[one.dims[0]].tolist()
    }
