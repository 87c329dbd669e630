# SPDX-License-Identifier: Apache-2.0
"""The module that west loads. West imports this file by its path and puts its folder on the module path, so the
package beside it can be imported from here, but not from inside of itself."""

from lf_west.build_command import LfBuild
from lf_west.fed_build_command import LfFedBuild
from lf_west.fed_flash_command import LfFedFlash
from lf_west.fed_run_command import LfFedRun
from lf_west.run_command import LfRun

__all__ = ["LfBuild", "LfFedBuild", "LfFedFlash", "LfFedRun", "LfRun"]
