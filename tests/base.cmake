# Lowest layer: hashing, sizes, log, progress, and output that is whole or absent.
raycube_test(base SOURCES unit/base_test.cpp LIBS raycube_base nlohmann_json::nlohmann_json LABELS fast)
raycube_test(attitude SOURCES unit/attitude_test.cpp LIBS raycube::lidar raycube::sensors raycube::scene_compiler LABELS
  fast)
raycube_test(output_file SOURCES unit/output_file_test.cpp LIBS raycube_base LABELS fast)
raycube_test(block_hashes SOURCES unit/block_hashes_test.cpp LIBS raycube_base LABELS fast)
raycube_test(json_text SOURCES unit/json_text_test.cpp LIBS raycube_base LABELS fast)
raycube_test(publication SOURCES unit/publication_test.cpp LIBS raycube_base LABELS fast ALONE)
raycube_test(publication_strangers SOURCES unit/publication_strangers_test.cpp LIBS raycube_base LABELS fast)
raycube_test(gdal_library SOURCES unit/gdal_library_test.cpp LIBS raycube::gdal LABELS fast)
raycube_test(limited_child SOURCES unit/limited_child_test.cpp LIBS raycube_base LABELS fast)
# Not with the test programs' main, which brings an abort() of its own.
add_executable(test_library_abort unit/library_abort_test.cpp $<TARGET_OBJECTS:raycube_library_abort>)
target_link_libraries(test_library_abort PRIVATE raycube_warnings raycube_base)
set_target_properties(test_library_abort PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
add_test(NAME library_abort COMMAND test_library_abort)
set_tests_properties(library_abort PROPERTIES LABELS fast)
raycube_test(house_map SOURCES unit/house_map_test.cpp LABELS fast)
if(NOT RAYCUBE_MUTATION)
  add_test(NAME compiled_once COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/unit/compiled_once_test.py
    ${CMAKE_BINARY_DIR}/compile_commands.json)
  set_tests_properties(compiled_once PROPERTIES LABELS fast)
endif()
raycube_test(crash_report SOURCES unit/crash_report_test.cpp LIBS raycube_base LABELS fast ALONE)
