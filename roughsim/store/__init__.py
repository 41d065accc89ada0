"""Files that are whole or absent: the disk, members, and claims. No physics."""
