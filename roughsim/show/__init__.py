"""Output for people: numbers with their units and errors, tables, and the terminal."""
