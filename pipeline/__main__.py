"""`python -m pipeline` is `bluekoi`."""

import signal
import sys

if "stage" in sys.argv[1:2]:
    # A stage that is interrupted ends there and then: its run tells of it, in words.
    signal.signal(signal.SIGINT, signal.SIG_DFL)

from .cli import main

main()
