"""What the maps of a page hold."""

from roughsim.explore.content import as_bytes


def image(page, name="temperature"):
    return page.layout.maps[name].image.data


def pixels(field):
    """The image of a whole field; its limits are doubles, as those of the page: float32 rounds pixels differently."""
    return as_bytes(field, (float(field.min()), float(field.max())))


def temperature(run, speed, direction=0.0):
    return next(run.fields("temperature", speed=speed, direction=direction))[1]
