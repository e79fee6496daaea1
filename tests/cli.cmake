# The command line: its frame, and the program itself driven as users drive it.
raycube_test(cli_frame SOURCES unit/cli_frame_test.cpp LIBS raycube_cli_frame nlohmann_json::nlohmann_json LABELS fast)
find_package(Python3 COMPONENTS Interpreter REQUIRED)
add_test(NAME cli COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/cli/cli_test.py $<TARGET_FILE:raycube>)
add_test(NAME install COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/cli/install_test.py ${CMAKE_BINARY_DIR} ${CMAKE_COMMAND}
                              ${CMAKE_CPACK_COMMAND})
set_tests_properties(cli install PROPERTIES LABELS fast)
