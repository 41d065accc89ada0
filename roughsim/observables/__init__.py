"""What is measured of a solved contact, and how each observable is stored, averaged and set beside the theory."""
