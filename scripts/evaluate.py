#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs measurements; `cargo xtask evaluate` builds what they need and calls this."""

import sys

from lf_evaluate.main import main

sys.exit(main(sys.argv[1:]))
