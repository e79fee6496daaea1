# Build step: writes version.cpp from version.cpp.in; the file is touched only when the commit has changed.
execute_process(COMMAND git -C "${SOURCE}" describe --always --dirty --abbrev=12
                OUTPUT_VARIABLE RAYCUBE_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE status)
if(NOT status EQUAL 0 OR RAYCUBE_COMMIT STREQUAL "")
  set(RAYCUBE_COMMIT unknown)
endif()
configure_file("${SOURCE}/host/base/version.cpp.in" "${OUTPUT}" @ONLY)
