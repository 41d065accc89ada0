"""Files that are whole or absent: the disk, members, claims, and the map of the theory's validity. No physics."""
