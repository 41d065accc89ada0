"""Runs and studies for people and other programs: state, comparison, pictures, files and pages to send."""
