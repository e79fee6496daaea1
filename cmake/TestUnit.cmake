# Joins tests' sources to one C++ source, which is compiled at once. Each stands in a namespace of its own, so that
# their helpers may have the same names; the headers that they include come before, where no namespace is open.
# Script form:
#   cmake -DSOURCES=tests/unit/a_test.cpp|tests/unit/b_test.cpp -DOUTPUT=file.cpp -P TestUnit.cmake
cmake_minimum_required(VERSION 3.23)

string(REPLACE "|" ";" SOURCES "${SOURCES}")
set(headers "")
set(bodies "")
foreach(source IN LISTS SOURCES)
  file(STRINGS "${source}" lines REGEX "^#include ([<][^>]*[>]|\"[^\"]*\\.h\")")
  list(APPEND headers ${lines})
  get_filename_component(name "${source}" NAME_WE)
  string(APPEND bodies "namespace in_${name} {\n#include \"${source}\"\n}\n")
endforeach()
list(REMOVE_DUPLICATES headers)
list(JOIN headers "\n" headers)
file(WRITE "${OUTPUT}" "// Made by cmake/TestUnit.cmake.\n${headers}\n\n${bodies}")
