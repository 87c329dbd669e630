# SPDX-License-Identifier: Apache-2.0
# Finds a Rust toolchain that can build for a bare-metal target.
#
# Two kinds serve:
#   1. one that has the target's standard library installed (`rustup target add TARGET`);
#   2. one that has the sources of the standard library (rustup's rust-src, or a distribution's rustc with its
#      rust-src package); `core` is then compiled with the program. Cargo counts this as unstable, so it has to be
#      told to act like a nightly one.
# The first kind wins over the whole PATH, because it builds faster, unless the second kind is preferred.
#
# As a module:  lf_find_rust_toolchain(TARGET [PREFER_SOURCES]) sets in the caller's scope
#   LF_CARGO                the cargo program
#   LF_RUSTC                the rustc program beside it
#   LF_CARGO_ENVIRONMENT    VARIABLE=VALUE entries to run it with
#   LF_RUST_TOOLCHAIN       one line that describes the choice
#   LF_RUST_SOURCES         the version of the toolchain if it compiles `core` with the program, else nothing
#              lf_rust_target_without_frame_pointers(FILE TARGET) writes the description of a target to FILE
#              lf_rust_llvm_options(OUT OPTION...) sets OUT to the options that its LLVM knows
# As a script:  cmake -DLF_RUST_TARGET=thumbv7m-none-eabi -P lf_rust_toolchain.cmake
#   prints the choice, or fails with what to install.

include_guard(GLOBAL)

# Must be the rust-version of the workspace's Cargo.toml.
set(LF_RUST_VERSION_MIN 1.88)

# Sets `out` to the folders that may hold a toolchain: those of PATH, then where distributions install.
function(_lf_rust_folders out)
  string(REPLACE ":" ";" folders "$ENV{PATH}")
  list(APPEND folders /usr/local/bin /usr/bin)
  list(REMOVE_DUPLICATES folders)
  set(found)
  foreach(folder IN LISTS folders)
    if(EXISTS "${folder}/rustc" AND EXISTS "${folder}/cargo")
      list(APPEND found "${folder}")
    endif()
  endforeach()
  set(${out} "${found}" PARENT_SCOPE)
endfunction()

# Runs `folder`/rustc with the arguments; sets `out` to what it prints, or to nothing when it fails.
function(_lf_rustc out folder)
  execute_process(
    COMMAND "${folder}/rustc" ${ARGN}
    OUTPUT_VARIABLE text ERROR_QUIET RESULT_VARIABLE result OUTPUT_STRIP_TRAILING_WHITESPACE
  )
  if(NOT result EQUAL 0)
    set(text "")
  endif()
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

# Sets `out` to the version of `folder`/rustc if it is recent enough, else to nothing.
function(_lf_rust_version out folder)
  _lf_rustc(text "${folder}" --version)
  if(text MATCHES "^rustc ([0-9.]+)" AND NOT CMAKE_MATCH_1 VERSION_LESS LF_RUST_VERSION_MIN)
    set(${out} "${CMAKE_MATCH_1}" PARENT_SCOPE)
  else()
    set(${out} "" PARENT_SCOPE)
  endif()
endfunction()

function(lf_find_rust_toolchain target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "PREFER_SOURCES" "" "")
  _lf_rust_folders(folders)
  set(with_target)
  set(with_sources)
  set(seen)
  foreach(folder IN LISTS folders)
    _lf_rust_version(version "${folder}")
    list(APPEND seen "${folder}/rustc")
    if(NOT version)
      continue()
    endif()
    _lf_rustc(libraries "${folder}" --target ${target} --print target-libdir)
    file(GLOB core "${libraries}/libcore-*.rlib")
    _lf_rustc(sysroot "${folder}" --print sysroot)
    if(core AND NOT with_target)
      set(with_target "${folder}")
      set(description "${folder}/rustc ${version} with ${target} installed")
    endif()
    if(NOT with_sources AND EXISTS "${sysroot}/lib/rustlib/src/rust/library/core/Cargo.toml")
      set(with_sources "${folder}")
      set(version_sources "${version}")
      set(description_sources "${folder}/rustc ${version}, compiling core for ${target} from source")
    endif()
    if((with_target AND NOT arg_PREFER_SOURCES) OR (with_target AND with_sources))
      break()
    endif()
  endforeach()

  if(with_target AND NOT (with_sources AND arg_PREFER_SOURCES))
    set(LF_RUST_SOURCES "" PARENT_SCOPE)
    set(LF_CARGO "${with_target}/cargo" PARENT_SCOPE)
    set(LF_RUSTC "${with_target}/rustc" PARENT_SCOPE)
    set(LF_CARGO_ENVIRONMENT "RUSTC=${with_target}/rustc" PARENT_SCOPE)
    set(LF_RUST_TOOLCHAIN "${description}" PARENT_SCOPE)
  elseif(with_sources)
    set(LF_CARGO "${with_sources}/cargo" PARENT_SCOPE)
    set(LF_RUSTC "${with_sources}/rustc" PARENT_SCOPE)
    # Only `core` is built: a crate that needs `alloc` then does not compile, which is what is wanted.
    set(LF_CARGO_ENVIRONMENT
      "RUSTC=${with_sources}/rustc" "RUSTC_BOOTSTRAP=1" "CARGO_UNSTABLE_BUILD_STD=core"
      "CARGO_UNSTABLE_BUILD_STD_FEATURES=optimize_for_size"
      PARENT_SCOPE
    )
    set(LF_RUST_SOURCES "${version_sources}" PARENT_SCOPE)
    set(LF_RUST_TOOLCHAIN "${description_sources}" PARENT_SCOPE)
  else()
    list(JOIN seen "\n  " seen)
    message(FATAL_ERROR
      "No Rust toolchain (at least ${LF_RUST_VERSION_MIN}) can build for ${target}.\n"
      "Either run `rustup target add ${target}`, or install the sources of Rust's standard library "
      "(`rustup component add rust-src`, or the package rust-src of your distribution's rustc).\n"
      "Looked at:\n  ${seen}\n"
    )
  endif()
endfunction()

# Sets `out` to those of these options that the LLVM of the toolchain that was found knows: they come and go with its
# versions, and one that it does not know ends the compilation.
function(lf_rust_llvm_options out)
  set(known)
  foreach(option IN LISTS ARGN)
    execute_process(
      COMMAND ${CMAKE_COMMAND} -E env ${LF_CARGO_ENVIRONMENT} ${LF_RUSTC} -Cllvm-args=${option} --print sysroot
      OUTPUT_QUIET ERROR_QUIET RESULT_VARIABLE result
    )
    if(result EQUAL 0)
      list(APPEND known ${option})
    endif()
  endforeach()
  set(${out} "${known}" PARENT_SCOPE)
endfunction()

# Writes the description of `target` to `file`, but without frame pointers, which Rust keeps on Arm in each function and
# which no option takes away; or removes `file` where the toolchain that was found cannot be told such a target.
function(lf_rust_target_without_frame_pointers file target)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -E env ${LF_CARGO_ENVIRONMENT}
      ${LF_RUSTC} -Z unstable-options --print target-spec-json --target ${target}
    OUTPUT_VARIABLE description ERROR_QUIET RESULT_VARIABLE result
  )
  set(always "\"frame-pointer\": \"always\"")
  if(result EQUAL 0 AND description MATCHES "${always}")
    string(REPLACE "${always}" "\"frame-pointer\": \"may-omit\"" description "${description}")
    # Cargo compiles everything anew when the file is another one.
    file(CONFIGURE OUTPUT ${file} CONTENT "${description}" @ONLY)
  else()
    file(REMOVE ${file})
  endif()
endfunction()

if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  if(NOT LF_RUST_TARGET)
    message(FATAL_ERROR "usage: cmake -DLF_RUST_TARGET=TARGET -P lf_rust_toolchain.cmake")
  endif()
  lf_find_rust_toolchain(${LF_RUST_TARGET})
  message(STATUS "Rust: ${LF_RUST_TOOLCHAIN}")
endif()
