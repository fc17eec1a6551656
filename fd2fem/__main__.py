"""Run the command line as ``python -m fd2fem``."""

import sys

from fd2fem.cli import main

sys.exit(main())
