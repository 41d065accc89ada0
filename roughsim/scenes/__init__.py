"""Bundled scenes: TOML files that every command takes by name."""
