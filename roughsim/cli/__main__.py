"""``python -m roughsim.cli``."""

from roughsim.cli import main

main()
