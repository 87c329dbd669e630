# SPDX-License-Identifier: Apache-2.0
# Links a generated Rust crate into a Zephyr application.
#
# zephyr-lang-rust's rust_cargo_application() is not used, for three reasons: its main.c defines main(), which belongs
# to this repository's src/; its crate `zephyr` brings a panic handler of its own and asks for `alloc`; and it gives
# each image a cargo target folder of its own, so that each federate would compile everything anew. What is used of
# that module is CONFIG_RUST and its knowledge of which Rust target belongs to which CPU; the crate that is linked is
# called as there, `rustapp`, and the build scripts see the same variables.

include_guard(GLOBAL)
include(${CMAKE_CURRENT_LIST_DIR}/lf_rust_toolchain.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/../../rust/c-build/cmake/lf_program_files.cmake)

set(LF_ZEPHYR_CMAKE_DIR ${CMAKE_CURRENT_LIST_DIR} CACHE INTERNAL "")
cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH _lf_module)
cmake_path(GET _lf_module PARENT_PATH _lf_repository)
set(LF_REPOSITORY ${_lf_repository} CACHE INTERNAL "")

# lf_application(CRATE)
#
# lf_federate(CRATE), with the sources that start the crate's federate or RTI when the network is there.
function(lf_application crate)
  target_sources(app PRIVATE ${LF_REPOSITORY}/src/main.c)
  if(CONFIG_LF_NETWORK)
    target_sources(app PRIVATE ${LF_REPOSITORY}/src/network.c)
  endif()
  # Whether the ends of connections were acknowledged is in no public header.
  target_include_directories(app PRIVATE ${ZEPHYR_BASE}/subsys/net/ip)
  lf_federate(${crate})
endfunction()

# lf_federate(CRATE)
#
# Builds the crate in the folder CRATE as a static library and links it with the target `app`. The crate's package is
# named `rustapp`, its crate type is `staticlib`, and it depends on lf-zephyr by the name `lf`. The header of the C API
# that the crate offers, <lf/lf.h>, can be included by the sources of `app`.
#
# Cache variables:
#   LF_CARGO_TARGET_DIR   cargo's target folder; images that share it compile what they have in common once. Default:
#                         the environment's CARGO_TARGET_DIR, else a folder of the image's own.
#   LF_CARGO_MESSAGES     a file to which cargo's messages are written in its JSON format, for tools that show rustc's
#                         errors in their own way. Default: none, cargo prints them.
function(lf_federate crate)
  if(NOT CONFIG_LF)
    message(FATAL_ERROR "lf_federate() needs CONFIG_LF=y")
  endif()
  cmake_path(ABSOLUTE_PATH crate BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
  if(NOT EXISTS ${crate}/Cargo.toml)
    message(FATAL_ERROR "There is no Cargo.toml in ${crate}: name the folder of a crate that `lfz build` generated")
  endif()

  _rust_map_target()
  set(preference)
  if(NOT CONFIG_LF_PANIC_TEXTS)
    set(preference PREFER_SOURCES)
  endif()
  lf_find_rust_toolchain(${RUST_TARGET} ${preference})
  message(STATUS "Rust: ${LF_RUST_TOOLCHAIN}")

  set(default_target_dir ${CMAKE_BINARY_DIR}/lf/cargo)
  if(DEFINED ENV{CARGO_TARGET_DIR})
    set(default_target_dir $ENV{CARGO_TARGET_DIR})
  endif()
  set(LF_CARGO_TARGET_DIR ${default_target_dir} CACHE PATH "Cargo's target folder, which several images can share")
  set(LF_CARGO_MESSAGES "" CACHE FILEPATH "File for cargo's messages in JSON; empty: they are printed")

  set(output ${CMAKE_BINARY_DIR}/lf)
  set(library ${output}/librustapp.a)
  set(wrapper ${output}/bindgen_wrapper.c)
  set(devices ${output}/devices.c)
  set(header ${output}/include/lf/lf.h)
  file(MAKE_DIRECTORY ${output}/include/lf)
  set(sizes "")
  if(EXISTS ${crate}/c)
    _lf_add_bodies_in_c()
  endif()
  set(c_flags "")
  set(c_wrapper "")
  file(GLOB beside CONFIGURE_DEPENDS ${crate}/c.cmake)
  if(beside)
    _lf_add_c_beside()
  endif()
  _lf_write_settings(${output}/cargo_settings.cmake)

  # Cargo itself knows best whether something has changed, so it always runs: the output that this command names is
  # never made.
  add_custom_command(
    OUTPUT ${output}/always
    BYPRODUCTS ${library} ${wrapper} ${devices} ${header} ${c_wrapper}
    COMMAND ${CMAKE_COMMAND} -DSETTINGS=${output}/cargo_settings.cmake -P ${LF_ZEPHYR_CMAKE_DIR}/lf_cargo_build.cmake
    COMMENT "Building the federate's crate ${crate}"
    USES_TERMINAL
  )
  add_custom_target(lf_crate DEPENDS ${output}/always)
  # The bindings are made from Zephyr's headers, some of which are generated.
  add_dependencies(lf_crate zephyr_generated_headers)
  if(sizes)
    add_dependencies(lf_crate lf_sizes)
  endif()
  add_dependencies(app lf_crate)

  target_sources(app PRIVATE ${wrapper} ${devices} ${c_wrapper})
  target_include_directories(app PRIVATE ${output}/include)
  if(CONFIG_ARM)
    # Compilers for Arm call these; without them Rust's compiler_builtins would bring a second memcpy().
    foreach(function memcpy memmove)
      foreach(alignment "" 4 8)
        target_link_libraries(app PUBLIC -Wl,--defsym=__aeabi_${function}${alignment}=${function})
      endforeach()
    endforeach()
    # Rust says of its objects that they need no executable stack, and gcc's for boards say nothing, of which the linker
    # warns.
    target_link_libraries(app PUBLIC -Wl,-z,noexecstack)
  endif()
  # Rust's compiler_builtins offers some of the functions that the C compiler's run-time library does; the latter is
  # named first, and the linker takes the first definition.
  target_link_libraries(app PUBLIC $<TARGET_PROPERTY:linker,rt_library> -Wl,--allow-multiple-definition ${library})
  _lf_name_lines(${crate})
endfunction()

# Leads debuggers from the image to the lines of the LF program, by the compiler that generated the crate.
function(_lf_name_lines crate)
  include(${crate}/compiler.cmake OPTIONAL)
  if(NOT EXISTS "${LF_COMPILER}")
    return()
  endif()
  set(image ${BYPRODUCT_KERNEL_ELF_NAME})
  set(maker zephyr_final)
  if(TARGET native_runner_executable)
    set(image ${BYPRODUCT_KERNEL_EXE_NAME})
    set(maker native_runner_executable)
  endif()
  add_custom_target(lf_lines ALL COMMAND ${LF_COMPILER} name-lines ${image} ${crate})
  add_dependencies(lf_lines ${maker})
endfunction()

# Adds the C part of a program to `app`: what was generated for it, and what bodies in C call. The crate learns the
# sizes of types from an object that is not linked; `sizes` is set to it. What the program asks for beyond that is in
# c/program.cmake of the crate. Uses the caller's variables.
macro(_lf_add_bodies_in_c)
  file(GLOB bodies CONFIGURE_DEPENDS ${crate}/c/*.c ${crate}/c/*.cpp ${LF_REPOSITORY}/rust/c/src/*.c)
  list(FILTER bodies EXCLUDE REGEX "/c/(sizes[.](c|cpp)|src/linux[.]c)$")
  target_sources(app PRIVATE ${bodies})
  target_include_directories(app PRIVATE ${LF_REPOSITORY}/rust/c/include ${crate}/c)
  # LF's `string` is a `char *`, and ports have values of types of which the standard does not promise that offsetof()
  # works.
  target_compile_options(app PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Wno-write-strings>)
  target_compile_options(app PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Wno-invalid-offsetof>)
  _lf_refuse_mistakes()
  include(${crate}/c/program.cmake OPTIONAL)
  file(GLOB types ${crate}/c/sizes.c ${crate}/c/sizes.cpp)
  if(types)
    add_library(lf_sizes OBJECT ${types})
    target_link_libraries(lf_sizes PRIVATE zephyr_interface)
    foreach(property INCLUDE_DIRECTORIES COMPILE_DEFINITIONS COMPILE_OPTIONS)
      set_property(TARGET lf_sizes PROPERTY ${property} $<TARGET_PROPERTY:app,${property}>)
    endforeach()
    # The sizes of symbols have to be in the object.
    target_compile_options(lf_sizes PRIVATE -fno-lto)
    add_dependencies(lf_sizes zephyr_generated_headers)
    set(sizes $<TARGET_OBJECTS:lf_sizes>)
  endif()
endmacro()

# Adds to `app` the C that a program has beside bodies in Rust. Where headers are bound, the crate is told by a file
# which folders and macros the C of `app` has, and writes another one of C. Uses the caller's variables.
macro(_lf_add_c_beside)
  set(bindings FALSE)
  _lf_refuse_mistakes()
  include(${beside})
  if(bindings)
    set(c_flags ${output}/c_flags.txt)
    set(c_wrapper ${output}/c_wrapper.c)
    file(GENERATE OUTPUT ${c_flags} CONTENT "-I$<JOIN:$<TARGET_PROPERTY:app,INCLUDE_DIRECTORIES>,\n-I>
-D$<JOIN:$<TARGET_PROPERTY:app,COMPILE_DEFINITIONS>,\n-D>
")
  endif()
endmacro()

# Has the compiler refuse in the C of `app` what newer compilers refuse, and show a mistake in what is given to a macro
# where the macro is used. The crate lf-c-build has the same for programs of this computer.
function(_lf_refuse_mistakes)
  foreach(mistake implicit-function-declaration implicit-int incompatible-pointer-types int-conversion return-mismatch)
    # The result is kept by its name.
    string(MAKE_C_IDENTIFIER lf_refuses_${mistake} is_known)
    zephyr_check_compiler_flag(C -Werror=${mistake} ${is_known})
    if(${is_known})
      target_compile_options(app PRIVATE $<$<COMPILE_LANGUAGE:C>:-Werror=${mistake}>)
    endif()
  endforeach()
  zephyr_check_compiler_flag(C -ftrack-macro-expansion=0 lf_shows_uses_of_macros)
  if(lf_shows_uses_of_macros)
    target_compile_options(app PRIVATE -ftrack-macro-expansion=0)
  endif()
endfunction()

# Sets `out` to 1 where the compiler of the image makes enumerations as small as their values allow, else to 0.
function(_lf_has_short_enums out)
  file(WRITE ${CMAKE_BINARY_DIR}/lf/empty.c "")
  execute_process(
    COMMAND ${CMAKE_C_COMPILER} -dM -E ${CMAKE_BINARY_DIR}/lf/empty.c
    OUTPUT_VARIABLE macros ERROR_QUIET
  )
  string(REGEX MATCH "__ARM_SIZEOF_MINIMAL_ENUM 1" match "${macros}")
  set(${out} 0 PARENT_SCOPE)
  if(match)
    set(${out} 1 PARENT_SCOPE)
  endif()
endfunction()

# Writes what lf_cargo_build.cmake needs, once CMake knows the include folders. Uses the caller's variables.
macro(_lf_write_settings file)
  # The profiles are set here and not in the crates, so that images that share a target folder agree on them: else
  # cargo compiles everything anew for each.
  set(profile release)
  if(CONFIG_DEBUG)
    set(profile dev)
  endif()
  set(optimization z)
  if(CONFIG_SPEED_OPTIMIZATIONS)
    set(optimization 3)
  endif()
  # Flash is scarce on a board; a program of the build computer had better be built fast.
  set(link_time_optimization fat)
  if(CONFIG_ARCH_POSIX)
    set(link_time_optimization false)
  endif()
  # A panic without texts is an instruction that the processor does not have, in `core` too.
  set(panic abort)
  if(NOT CONFIG_LF_PANIC_TEXTS AND profile STREQUAL release)
    if(LF_RUST_SOURCES VERSION_LESS 1.91)
      message(WARNING
        "CONFIG_LF_PANIC_TEXTS=n needs Rust 1.91 or later with the sources of its standard library (`rustup component "
        "add rust-src`, or the package rust-src of your distribution's rustc): the texts of panics stay in the image"
      )
    else()
      set(panic immediate-abort)
      list(APPEND LF_CARGO_ENVIRONMENT CARGO_UNSTABLE_PANIC_IMMEDIATE_ABORT=true)
    endif()
  endif()
  # Frame pointers take 5 % of the flash. Cargo has taken descriptions of targets in this way since about this version.
  set(target ${RUST_TARGET})
  if(CONFIG_ARM AND profile STREQUAL release AND LF_RUST_SOURCES VERSION_GREATER_EQUAL 1.95)
    set(description ${LF_CARGO_TARGET_DIR}/targets/${RUST_TARGET}.json)
    lf_rust_target_without_frame_pointers(${description} ${RUST_TARGET})
    if(EXISTS ${description})
      set(target ${description})
      list(APPEND LF_CARGO_ENVIRONMENT CARGO_UNSTABLE_JSON_TARGET_SPEC=true)
    endif()
  endif()
  # The first one turns common code of functions into one function. The others omit work: constants and values which
  # a loop computes anew keep no register then, and instructions stay in the shortest order.
  set(llvm_options)
  if(RUST_TARGET MATCHES "thumb")
    list(APPEND llvm_options --enable-machine-outliner=always)
    if(optimization STREQUAL z)
      list(APPEND llvm_options --opt-disable=licm --disable-constant-hoisting --disable-post-ra)
    endif()
    lf_rust_llvm_options(llvm_options ${llvm_options})
  endif()
  set(features)
  if(CONFIG_LF_TEXTS)
    set(features ,lf/texts)
  endif()
  if(CONFIG_LF_TRACE)
    string(APPEND features ,lf/traces)
  endif()
  if(CONFIG_NET_UDP)
    string(APPEND features ,lf/datagrams)
  endif()
  if(CONFIG_NET_IPV6)
    string(APPEND features ,lf/ipv6)
  endif()
  if(CONFIG_LF_SECURITY)
    string(APPEND features ,lf/security)
  endif()
  if(CONFIG_LF_TRANSIENTS)
    string(APPEND features ,lf/transients)
  endif()
  # Names of the features of lf-zephyr; Zephyr has no level for traces, they go with its debug messages.
  set(log_levels off error warn info trace)
  set(log_level off)
  if(DEFINED CONFIG_LF_LOG_LEVEL)
    list(GET log_levels ${CONFIG_LF_LOG_LEVEL} log_level)
  endif()
  find_program(LF_CLANG NAMES clang DOC "clang, whose own headers bindgen uses")
  set(resources "")
  if(LF_CLANG)
    execute_process(COMMAND ${LF_CLANG} -print-resource-dir OUTPUT_VARIABLE resources OUTPUT_STRIP_TRAILING_WHITESPACE)
  endif()
  _lf_has_short_enums(short_enums)
  file(GENERATE OUTPUT ${file} CONTENT
"set(cargo [==[${LF_CARGO}]==])
set(environment [==[${LF_CARGO_ENVIRONMENT}]==])
set(crate [==[${crate}]==])
set(lock [==[${LF_REPOSITORY}/rust/zephyr/Cargo.lock]==])
set(target [==[${target}]==])
set(target_dir [==[${LF_CARGO_TARGET_DIR}]==])
set(profile ${profile})
set(llvm_options [==[${llvm_options}]==])
set(features lf/max_level_${log_level}${features})
set(repository [==[${LF_REPOSITORY}]==])
set(messages [==[${LF_CARGO_MESSAGES}]==])
set(library [==[${library}]==])
list(APPEND environment
  [==[ZEPHYR_BASE=${ZEPHYR_BASE}]==]
  [==[BUILD_DIR=${CMAKE_BINARY_DIR}]==]
  [==[DOTCONFIG=${DOTCONFIG}]==]
  [==[BINARY_DIR_INCLUDE_GENERATED=${BINARY_DIR_INCLUDE_GENERATED}]==]
  [==[WRAPPER_FILE=${wrapper}]==]
  [==[LF_DEVICES_FILE=${devices}]==]
  [==[LF_HEADER_FILE=${header}]==]
  [==[LF_C_SIZES=${sizes}]==]
  [==[LF_CLANG_RESOURCE_DIR=${resources}]==]
  LF_C_SHORT_ENUMS=${short_enums}
  [==[LF_C_FLAGS_FILE=${c_flags}]==]
  [==[LF_C_WRAPPER_FILE=${c_wrapper}]==]
  CARGO_PROFILE_DEV_OPT_LEVEL=1
  CARGO_PROFILE_DEV_PANIC=abort
  CARGO_PROFILE_RELEASE_OPT_LEVEL=${optimization}
  CARGO_PROFILE_RELEASE_LTO=${link_time_optimization}
  CARGO_PROFILE_RELEASE_CODEGEN_UNITS=1
  CARGO_PROFILE_RELEASE_DEBUG=line-tables-only
  CARGO_PROFILE_RELEASE_PANIC=${panic}
)
set(include_dirs [==[$<TARGET_PROPERTY:zephyr_interface,INTERFACE_INCLUDE_DIRECTORIES>]==])
set(include_defines [==[$<TARGET_PROPERTY:zephyr_interface,INTERFACE_COMPILE_DEFINITIONS>]==])
")
endmacro()
