# SPDX-License-Identifier: Apache-2.0
# Runs cargo for one image and copies the library to the image's build folder. A script of lf_federate().
#
# With `LINT`, clippy reads a crate instead: the image's own, or `lf-zephyr`, with all its features. A warning is an
# error.
#
# All images call their library `librustapp.a`, and several of them may be built at once in one target folder. So the
# copy is made before another image's cargo can start; and only when it differs, so that an unchanged crate does not
# link the image anew.

cmake_minimum_required(VERSION 3.21)
include(${SETTINGS})

file(MAKE_DIRECTORY ${target_dir})
file(LOCK ${target_dir}/lf-image.lock GUARD PROCESS TIMEOUT 3600)

# The versions that this repository was tested with, unless the crate has a lock file of its own.
if(NOT EXISTS ${crate}/Cargo.lock)
  file(COPY_FILE ${lock} ${crate}/Cargo.lock)
endif()

set(arguments --target ${target} --target-dir ${target_dir})
set(folder debug)
if(profile STREQUAL release)
  list(APPEND arguments --release)
  set(folder release)
endif()
# SHA-256 without SIMD: targets such as native_sim's have no registers for it, and the small form saves flash.
set(flags [=['--cfg', 'sha2_backend="soft"', '--cfg', 'sha2_backend_soft="compact"']=])
if(LINT OR features MATCHES "lf/security")
  foreach(backend chacha20_backend="soft" poly1305_backend="soft" curve25519_dalek_backend="serial")
    string(APPEND flags ", '--cfg', '${backend}'")
  endforeach()
endif()
if(profile STREQUAL release)
  # A panic says where it happened: the image carries that text, so it had better be short, and the same everywhere.
  string(APPEND flags ", '--remap-path-prefix=${repository}/='")
  foreach(option IN LISTS llvm_options)
    string(APPEND flags ", '-Cllvm-args=${option}'")
  endforeach()
endif()
list(APPEND arguments --config "build.rustflags=[${flags}]")
set(redirection)
if(LINT)
  if(LINT STREQUAL lf-zephyr)
    set(crate ${repository}/rust/zephyr)
    set(features peers,datagrams,ipv6,security,texts,traces,transients,postcard,c)
  endif()
  set(arguments clippy --no-deps ${arguments} --features ${features} -- -D warnings)
  # Cargo would look for clippy where rustup is before it looks beside itself.
  list(APPEND environment CARGO=${cargo})
  cmake_path(REPLACE_FILENAME cargo cargo-clippy)
else()
  # Features that Kconfig leaves out are not even compiled, nor messages of more detail than it lets through.
  set(arguments build ${arguments} --features ${features})
endif()
if(messages AND NOT LINT)
  list(APPEND arguments --message-format=json)
  set(redirection OUTPUT_FILE ${messages})
endif()

# Lists go through the environment with spaces; no path of a Zephyr build may contain one.
string(REPLACE ";" " " include_dirs "${include_dirs}")
string(REPLACE ";" " " include_defines "${include_defines}")

execute_process(
  COMMAND ${CMAKE_COMMAND} -E env ${environment} "INCLUDE_DIRS=${include_dirs}" "INCLUDE_DEFINES=${include_defines}"
    ${cargo} ${arguments}
  WORKING_DIRECTORY ${crate}
  RESULT_VARIABLE result
  ${redirection}
)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "cargo could not build ${crate}")
endif()
if(LINT)
  return()
endif()

cmake_path(GET target STEM target)
file(COPY_FILE ${target_dir}/${target}/${folder}/librustapp.a ${library} ONLY_IF_DIFFERENT)
