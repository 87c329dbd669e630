# SPDX-License-Identifier: Apache-2.0
# Makes an application of a program in Lingua Franca, for builds without the west commands: `west build`, and twister.
#
# The CMakeLists.txt of such an application:
#
#   include(…/zephyr/cmake/lf_program.cmake)
#   lf_program(src/Example.lf)
#   find_package(Zephyr REQUIRED HINTS $ENV{ZEPHYR_BASE})
#   project(example LANGUAGES C)
#   lf_application(${LF_FEDERATE_CRATE})

include_guard(GLOBAL)
include(${CMAKE_CURRENT_LIST_DIR}/lf_workspace.cmake)

cmake_path(SET _lf_program_repository NORMALIZE ${CMAKE_CURRENT_LIST_DIR}/../..)

# lf_program(FILE)
#
# Compiles the LF program in FILE for the board of this build, and adds what was generated to the application's
# settings: to be called before find_package(Zephyr). The folder's prj.conf and boards/BOARD.conf and .overlay count,
# too, and then prj_FEDERATE.conf and boards/BOARD_FEDERATE.*; the settings below them are those of the top of this
# repository. Zephyr itself reads the folder's Kconfig and its dts/bindings.
#
# Cache variables:
#   LF_PROGRAM      a program instead of FILE, by the application's folder.
#   LF_FEDERATE     the federate to be built, or the RTI where that is an image; none for a program without federates.
#   LF_DEPLOYMENT   where each federate runs, by the application's folder. Default: all on the board of this build.
#   LF_COMPILER     the program lfz. Default: the environment's LFZ, else that of this repository, built if need be;
#                   without cargo, or where lfz is installed, the one in PATH.
#
# Sets for the caller: LF_FEDERATE_CRATE, the folder of the generated crate; APPLICATION_CONFIG_DIR, EXTRA_CONF_FILE and
# EXTRA_DTC_OVERLAY_FILE, for Zephyr. What was generated is described in lf/federation.json of the build folder, which
# `west lf-fed-run --images` reads.
function(lf_program file)
  set(LF_PROGRAM "" CACHE STRING "The program in Lingua Franca, where it is not the application's own")
  if(LF_PROGRAM)
    set(file ${LF_PROGRAM})
  endif()
  set(LF_FEDERATE "" CACHE STRING "The federate of the program that is built")
  set(LF_DEPLOYMENT "" CACHE STRING "The file that says where each federate runs, by the application's folder")
  _lf_compiler(compiler)

  cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
  set(sources ${file})
  if(NOT BOARD AND DEFINED ENV{BOARD})
    set(BOARD $ENV{BOARD})
  endif()
  set(arguments --json --platform zephyr --out ${CMAKE_BINARY_DIR}/lf/generated)
  if(LF_DEPLOYMENT)
    cmake_path(ABSOLUTE_PATH LF_DEPLOYMENT BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
    list(APPEND sources ${LF_DEPLOYMENT})
    list(APPEND arguments --deployment ${LF_DEPLOYMENT})
  elseif(BOARD)
    list(APPEND arguments --board ${BOARD})
  endif()
  if(LF_FEDERATE)
    list(APPEND arguments --federate ${LF_FEDERATE})
  endif()
  execute_process(
    COMMAND ${compiler} build ${file} ${arguments}
    OUTPUT_VARIABLE description
    RESULT_VARIABLE result
  )
  if(NOT result EQUAL 0)
    message(FATAL_ERROR
      "lfz could not build ${file}: correct what is reported above, or choose another federate with -DLF_FEDERATE=NAME "
      "or another deployment with -DLF_DEPLOYMENT=FILE"
    )
  endif()

  string(JSON count LENGTH "${description}" participants)
  if(NOT count EQUAL 1)
    set(names)
    foreach(index RANGE 1 ${count})
      math(EXPR index "${index} - 1")
      string(JSON name GET "${description}" participants ${index} name)
      list(APPEND names ${name})
    endforeach()
    list(JOIN names ", " names)
    message(FATAL_ERROR
      "${file} has several federates, of which one is an image: choose it with -DLF_FEDERATE=NAME, among ${names}; "
      "or let `west lf-fed-build` build all of them"
    )
  endif()
  string(JSON crate GET "${description}" participants 0 crate)
  string(JSON kconfig GET "${description}" participants 0 kconfig)
  string(JSON overlay GET "${description}" participants 0 overlay)
  if(BOARD)
    # The board of the build counts, whatever the deployment says.
    string(JSON description SET "${description}" participants 0 board "\"${BOARD}\"")
  endif()
  file(WRITE ${CMAKE_BINARY_DIR}/lf/federation.json "${description}")
  # The imports of a program are beside it as a rule.
  cmake_path(GET file PARENT_PATH folder)
  file(GLOB imports CONFIGURE_DEPENDS ${folder}/*.lf ${folder}/*.ulf)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${sources} ${imports})

  # As `west lf-build` names them.
  _lf_board_file_names(boards "${BOARD}")
  set(confs)
  set(overlays)
  set(own)
  if(LF_FEDERATE)
    set(own _${LF_FEDERATE})
  endif()
  foreach(owner IN ITEMS "" ${own})
    list(TRANSFORM boards REPLACE "(.+)" "boards/\\1${owner}.conf" OUTPUT_VARIABLE board_confs)
    list(TRANSFORM boards REPLACE "(.+)" "boards/\\1${owner}.overlay" OUTPUT_VARIABLE board_overlays)
    list(APPEND confs prj${owner}.conf ${board_confs})
    list(APPEND overlays ${board_overlays})
  endforeach()
  _lf_existing(confs ${confs})
  _lf_existing(overlays ${overlays})
  set(LF_FEDERATE_CRATE ${crate} PARENT_SCOPE)
  set(APPLICATION_CONFIG_DIR ${_lf_program_repository} PARENT_SCOPE)
  set(EXTRA_CONF_FILE ${kconfig} ${confs} PARENT_SCOPE)
  set(EXTRA_DTC_OVERLAY_FILE ${overlay} ${overlays} PARENT_SCOPE)
endfunction()

# Sets `out` to the program lfz.
function(_lf_compiler out)
  set(LF_COMPILER "" CACHE FILEPATH "The program lfz, which compiles Lingua Franca")
  set(${out} ${LF_COMPILER})
  if(NOT LF_COMPILER AND DEFINED ENV{LFZ})
    set(${out} $ENV{LFZ})
  elseif(NOT LF_COMPILER)
    find_program(LF_HOST_CARGO cargo DOC "cargo, which builds lfz")
    # An installed lfz has no sources of itself.
    if(LF_HOST_CARGO AND EXISTS ${_lf_program_repository}/rust/cli)
      set(arguments --release --package lfz --bin lfz --message-format json-render-diagnostics)
      execute_process(
        COMMAND ${LF_HOST_CARGO} build --quiet ${arguments}
        WORKING_DIRECTORY ${_lf_program_repository}
        OUTPUT_VARIABLE messages
        RESULT_VARIABLE result
      )
      if(NOT result EQUAL 0)
        message(FATAL_ERROR "cargo could not build lfz: name one that is built already with -DLF_COMPILER=PATH")
      endif()
      string(REGEX MATCH "\"executable\":\"([^\"]*/lfz)\"" match "${messages}")
      set(${out} "${CMAKE_MATCH_1}")
    else()
      find_program(LF_INSTALLED_COMPILER lfz DOC "lfz in PATH")
      set(${out} "${LF_INSTALLED_COMPILER}")
    endif()
  endif()
  if(NOT EXISTS "${${out}}")
    message(FATAL_ERROR
      "There is no lfz \"${${out}}\", which compiles Lingua Franca: install Rust from https://rustup.rs, or name an lfz "
      "with -DLF_COMPILER=PATH"
    )
  endif()
  set(${out} ${${out}} PARENT_SCOPE)
endfunction()

# Sets `out` to those of the application's files that there are.
function(_lf_existing out)
  set(found)
  foreach(file IN LISTS ARGN)
    if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/${file})
      list(APPEND found ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    endif()
  endforeach()
  set(${out} ${found} PARENT_SCOPE)
endfunction()
