"""`python -m pipeline` is `bluekoi`."""

from .cli import main

main()
