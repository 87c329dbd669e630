# SPDX-License-Identifier: Apache-2.0
find_package(Curses REQUIRED)
find_package(Threads REQUIRED)
target_sources(${LF_MAIN_TARGET} PRIVATE ${CMAKE_CURRENT_LIST_DIR}/sensor_simulator.c)
target_include_directories(${LF_MAIN_TARGET} PRIVATE ${CMAKE_CURRENT_LIST_DIR} ${CURSES_INCLUDE_DIRS})
set_property(TARGET ${LF_MAIN_TARGET} APPEND PROPERTY LINK_LIBRARIES ${CURSES_LIBRARIES} Threads::Threads)
