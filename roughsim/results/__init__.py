"""A run as it was stored: which members count, the estimates made of them, their fields, and exports."""
