"""Two rough bodies that slide over one another: contact and temperatures of both, step by step."""
