# SPDX-License-Identifier: Apache-2.0
# To be included before find_package(Zephyr) by the applications of this repository: adds the modules that they need
# to Zephyr's list, however the workspace is laid out, and the toolchain for native_sim.
#
#   - This repository, which is a module and the home of the applications at once.
#   - zephyr-lang-rust. Zephyr's own manifest has it only in its group "optional"; in a workspace of that manifest it
#     may therefore lie at its place without west naming it.
#
# A module that west names already is found twice then, which does no harm: Zephyr knows modules by their names.

# With a component, the package only says where Zephyr is.
find_package(Zephyr QUIET REQUIRED HINTS $ENV{ZEPHYR_BASE} COMPONENTS extensions)

foreach(module ${CMAKE_CURRENT_LIST_DIR}/../.. ${ZEPHYR_BASE}/../modules/lang/rust)
  get_filename_component(module ${module} ABSOLUTE)
  if(EXISTS ${module}/zephyr/module.yml)
    list(APPEND ZEPHYR_EXTRA_MODULES ${module})
  endif()
endforeach()

# native_sim is a program of the build computer and uses its compiler: a Zephyr SDK is not needed then.
if(BOARD MATCHES "^native_sim" AND NOT DEFINED ZEPHYR_TOOLCHAIN_VARIANT
    AND NOT DEFINED ENV{ZEPHYR_TOOLCHAIN_VARIANT} AND NOT DEFINED ENV{ZEPHYR_SDK_INSTALL_DIR})
  set(ZEPHYR_TOOLCHAIN_VARIANT host)
endif()
