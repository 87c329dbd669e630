# SPDX-License-Identifier: Apache-2.0
#
# The files that a program names in its own files for CMake: in images, and in programs for this computer.

# lf_find_program_files(TARGET FOLDER...)
#
# Sources and folders for headers that have been given to the target by paths that do not exist, in the project's own
# folder or in one of these, are those in the first of the folders that has them. LF's compiler copies all of a
# program's files into one folder, and the sources of its runtime, so programs take them to be there.
function(lf_find_program_files target)
  set(folders ${ARGN} ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../../c/lib)
  foreach(property SOURCES INCLUDE_DIRECTORIES)
    get_target_property(paths ${target} ${property})
    if(NOT paths)
      continue()
    endif()
    set(found)
    foreach(path IN LISTS paths)
      set(absolute)
      if(NOT path MATCHES "[$]<")
        # CMake has made some of them absolute.
        cmake_path(ABSOLUTE_PATH path BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE OUTPUT_VARIABLE absolute)
      endif()
      if(absolute AND NOT EXISTS ${absolute})
        foreach(begin IN LISTS CMAKE_CURRENT_SOURCE_DIR ARGN)
          cmake_path(IS_PREFIX begin ${absolute} NORMALIZE here)
          if(NOT here)
            continue()
          endif()
          cmake_path(RELATIVE_PATH absolute BASE_DIRECTORY ${begin} OUTPUT_VARIABLE relative)
          cmake_path(GET absolute FILENAME name)
          foreach(folder IN LISTS folders)
            foreach(candidate IN ITEMS ${folder}/${relative} ${folder}/${name})
              if(EXISTS ${candidate})
                set(path ${candidate})
                break()
              endif()
            endforeach()
            if(EXISTS ${path})
              break()
            endif()
          endforeach()
        endforeach()
      endif()
      list(APPEND found "${path}")
    endforeach()
    set_property(TARGET ${target} PROPERTY ${property} "${found}")
  endforeach()
endfunction()
