# SPDX-License-Identifier: Apache-2.0
find_package(ALSA REQUIRED)
find_package(Threads REQUIRED)
target_sources(${LF_MAIN_TARGET} PRIVATE ${CMAKE_CURRENT_LIST_DIR}/audio_loop.c)
target_include_directories(${LF_MAIN_TARGET} PRIVATE ${CMAKE_CURRENT_LIST_DIR} ${ALSA_INCLUDE_DIRS})
set_property(TARGET ${LF_MAIN_TARGET} APPEND PROPERTY LINK_LIBRARIES ${ALSA_LIBRARIES} Threads::Threads)
