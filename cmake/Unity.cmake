# caltwin_unity(TARGET), called behind the target's other options: compiles its sources in
# a few groups (unity_groups.py says which go together), a build from nothing in half the
# time. For somebody who edits one file after another -DCALTWIN_UNITY=OFF is quicker. A file
# must not compile only because of what stands before it in its group: tools/lint.sh, which
# does without, sees to it.
option(CALTWIN_UNITY "Compile sources in groups" ON)
set(caltwin_unity_lines 4000)
set(caltwin_unity_root ${CMAKE_CURRENT_LIST_DIR}/..)
find_package(Python3 REQUIRED COMPONENTS Interpreter)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
  ${caltwin_unity_root}/cmake/unity_groups.py)

function(caltwin_unity target)
  if(NOT CALTWIN_UNITY)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  get_target_property(folder ${target} SOURCE_DIR)
  list(TRANSFORM sources PREPEND ${folder}/ REGEX "^[^/]")
  execute_process(
    COMMAND ${Python3_EXECUTABLE} ${caltwin_unity_root}/cmake/unity_groups.py
      ${caltwin_unity_root} ${caltwin_unity_lines} ${sources}
    OUTPUT_VARIABLE groups OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE "\n" ";" groups "${groups}")
  while(groups)
    list(POP_FRONT groups source group)
    set_source_files_properties(${source} TARGET_DIRECTORY ${target}
      PROPERTIES UNITY_GROUP ${target}_${group})
  endwhile()
  # A local name may be unnamed in a neighbour: tools/lint.sh sees what shadows. And g++
  # takes an included source for a header, where an unnamed member would be a mistake.
  target_compile_options(${target} PRIVATE
    -Wno-shadow $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
