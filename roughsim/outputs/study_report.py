"""A study as one HTML page to send: its table, charts, and scene, all in one file."""

from functools import partial

from roughsim.estimate.asked import asked_names
from roughsim.outputs.run_report import assembled, picture
from roughsim.scene import with_short_tables
from roughsim.show.markup import Html, html_table, joined, tag
from roughsim.studies.study import Study
from roughsim.studies.tables import asked_table, study_table

_CAPTIONS = {
    "flash_temperature": "Flash temperature. Points and bands: simulated, with the total error, 95 %. Lines: theory; "
    "dashed: by the calibrated stress spectrum. Hollow: at q_c, or a part of the error is unknown.",
    "contact_fraction": "Contact area over nominal area. Hollow: at q_c, or a part of the error is unknown.",
    "activation_temperature": "Activation temperature, absolute: the uniform temperature with the same rate.",
    "reaction_rate": "Rate of reaction, mean over the nominal area.",
    "heat_share_above": "Share of the heat set free where the contact is hotter.",
}
_DRAWN = "flash_temperature", "contact_fraction"  # of every study


def page(study: Study) -> str:
    """Return the page of a study as HTML."""
    title = study.scene.title or study.folder.resolve().name
    keys = ", ".join(key for axis in study.axes for key in axis.keys)
    state = f"A study over {keys}: {study.finished} of {len(study.points)} points finished."
    asked = asked_table(study)
    drawn = (*_DRAWN, *asked_names(study.scene))
    parts = {
        "Result": joined(
            *(html_table(table) for table in (study_table(study), asked) if table is not None)
        ),
        "Charts": joined(*(chart(study, name) for name in drawn)),
        "Scene": tag("pre", with_short_tables(study.scene.to_toml())),
    }
    head = tag("header", tag("h1", title), tag("p", state, css="state"))
    return assembled(title, head, parts)


def chart(study: Study, observable: str) -> Html:
    """Return a chart, or the reason for its absence."""
    caption = _CAPTIONS.get(observable, observable.replace("_", " "))
    try:
        return picture(partial(study.chart, observable=observable), ".svg", caption)
    except ValueError as error:
        return tag("p", f"{observable} is not shown: {error}", css="warning")
