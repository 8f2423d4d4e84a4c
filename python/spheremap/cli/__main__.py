"""``python -m spheremap.cli``."""

from . import main

main()
