# SPDX-License-Identifier: Apache-2.0
target_sources(${LF_MAIN_TARGET} PRIVATE driver.c)
