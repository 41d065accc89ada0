"""``python -m roughsim``."""

from roughsim.cli import main

main()
