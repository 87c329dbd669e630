# SPDX-License-Identifier: Apache-2.0
"""`python3 -m lf_west`: see main.py."""

import sys

from lf_west.main import main

sys.exit(main(sys.argv[1:]))
