# SPDX-License-Identifier: Apache-2.0
# To be included before find_package(Zephyr) by the applications of this repository: adds the modules that they need
# to Zephyr's list, however the workspace is laid out, and a tool chain where the user has not chosen one.
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

# Sets `out` to a board's name as it is in the names of its files: without a revision, and `_` for `/`. Where nothing
# but a SoC follows, as twister writes a board's name, it is two names: most such boards have only one SoC.
function(_lf_board_file_names out board)
  string(REGEX REPLACE "@[^/]*" "" name "${board}")
  string(REPLACE "/" "_" names "${name}")
  if(name MATCHES "^([^/]+)/[^/]+$")
    list(PREPEND names ${CMAKE_MATCH_1})
  endif()
  set(${out} "${names}" PARENT_SCOPE)
endfunction()

# Sets `out` to whether Zephyr's board list has the board as one with an Arm processor.
function(_lf_is_arm out board)
  _lf_board_file_names(names "${board}")
  list(TRANSFORM names REPLACE "(.+)" "${ZEPHYR_BASE}/boards/*/*/\\1.yaml")
  file(GLOB descriptions ${names})
  set(${out} FALSE PARENT_SCOPE)
  foreach(description IN LISTS descriptions)
    file(STRINGS ${description} lines REGEX "^arch: arm$")
    if(lines)
      set(${out} TRUE PARENT_SCOPE)
    endif()
  endforeach()
endfunction()

# A user without a chosen tool chain and without the Zephyr SDK may have a compiler that does.
if(NOT DEFINED ZEPHYR_TOOLCHAIN_VARIANT AND NOT DEFINED ENV{ZEPHYR_TOOLCHAIN_VARIANT}
    AND NOT DEFINED ZEPHYR_SDK_INSTALL_DIR AND NOT DEFINED ENV{ZEPHYR_SDK_INSTALL_DIR})
  set(_lf_board "${BOARD}")
  if(NOT _lf_board)
    set(_lf_board "$ENV{BOARD}")
  endif()
  if(_lf_board MATCHES "^native_sim")
    # A program of the build computer, with its compiler, also where there is an SDK.
    set(ZEPHYR_TOOLCHAIN_VARIANT host)
  else()
    # There is no such version, but the search lists those that there are; Zephyr looks for them like this, too.
    find_package(Zephyr-sdk 0.0.0 EXACT QUIET CONFIG PATHS /usr /usr/local /opt
      $ENV{HOME} $ENV{HOME}/.local $ENV{HOME}/.local/opt $ENV{HOME}/bin
    )
    find_program(LF_ARM_COMPILER arm-none-eabi-gcc DOC "A compiler for boards with an Arm processor")
    _lf_is_arm(_lf_arm "${_lf_board}")
    if(LF_ARM_COMPILER AND _lf_arm AND NOT Zephyr-sdk_CONSIDERED_VERSIONS)
      set(ZEPHYR_TOOLCHAIN_VARIANT cross-compile)
      string(REGEX REPLACE "gcc$" "" CROSS_COMPILE ${LF_ARM_COMPILER})
    endif()
  endif()
endif()
