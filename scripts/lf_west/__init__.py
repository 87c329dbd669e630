# SPDX-License-Identifier: Apache-2.0
"""The west commands of lf-zephyr-rs: building federates as Zephyr images and running federations."""
