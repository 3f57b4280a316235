"""`python -m pytest_hricdv.report merge|gate|export ...`: what can be done with reports that are written."""

import sys

from pytest_hricdv.commands import main

sys.exit(main(sys.argv[1:]))
