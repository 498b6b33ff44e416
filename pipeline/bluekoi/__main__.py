"""`python -m bluekoi` is `bluekoi`; a stage is run without the imports of other commands."""

import signal
import sys

if sys.argv[1:2] == ["stage"]:
    # A stage that is interrupted ends there and then; its run reports it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    from .workflow.forkserver_client import limit_blas_to_one_thread, request_stage

    code = request_stage(sys.argv[2:])
    if code is None:
        limit_blas_to_one_thread()
        from .workflow.stage_call import run_stage

        code = run_stage(sys.argv[2:])
    sys.exit(code)

from .cli import main

main()
