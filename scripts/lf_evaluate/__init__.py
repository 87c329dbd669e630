# SPDX-License-Identifier: Apache-2.0
"""Measures RTIs, applications and images, and makes tables and a page of what was measured."""
