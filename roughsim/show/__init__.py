"""How things are shown: numbers with their units and errors, tables, and the terminal."""
