"""The keys of a scene file."""

from roughsim.scene.schema import SECTIONS

KEYS = {
    "title",
    *(key for section, record in SECTIONS.items() if section for key in record.known_keys()),
}
