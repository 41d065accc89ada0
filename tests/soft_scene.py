"""A soft elastic scene that is no bundled one: C(q) beyond any grid, and beyond what the model is right for."""

from pathlib import Path

RUBBER = Path(__file__).with_name("rubber.toml")
