"""``python -m spheremap``."""

from .cli import main

main()
