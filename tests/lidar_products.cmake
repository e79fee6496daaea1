# Files of a LIDAR run, read by code that owes the writers nothing.
raycube_test(lidar_las_unit SOURCES unit/lidar_las_test.cpp LIBS raycube_products LABELS fast)
add_executable(las_samples ${CMAKE_CURRENT_LIST_DIR}/support/las_samples.cpp)
raycube_test_code(las_samples)
target_link_libraries(las_samples PRIVATE raycube_products nlohmann_json::nlohmann_json)
add_test(NAME lidar_las COMMAND ${RAYCUBE_TEST_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/cli/lidar_las_test.py
  $<TARGET_FILE:las_samples> $<TARGET_FILE:raycube>)
set_tests_properties(lidar_las PROPERTIES LABELS fast)
# laspy and lazrs come from PyPI (ci/setup): where they are missing, this one says so and skips.
set(RAYCUBE_VENV ${PROJECT_SOURCE_DIR}/build/venv CACHE PATH "Virtual environment with laspy and lazrs (ci/setup)")
add_test(NAME lidar_laspy COMMAND sh -c
  "p='${RAYCUBE_VENV}/bin/python'; [ -x \"$p\" ] || p='${RAYCUBE_TEST_PYTHON}'; exec \"$p\" \"$@\""
  lidar_laspy ${CMAKE_CURRENT_LIST_DIR}/cli/lidar_laspy_test.py $<TARGET_FILE:las_samples>
  $<TARGET_FILE:lidar_run_samples> ${CMAKE_BINARY_DIR}/share/raycube)
set_tests_properties(lidar_laspy PROPERTIES LABELS fast SKIP_RETURN_CODE 77)
# What `render` leaves of a run, without a device.
add_executable(lidar_run_samples ${CMAKE_CURRENT_LIST_DIR}/support/lidar_run_samples.cpp)
raycube_test_code(lidar_run_samples)
target_link_libraries(lidar_run_samples PRIVATE raycube_lidar_support raycube::run fmt::fmt
  nlohmann_json::nlohmann_json)
add_test(NAME lidar_products COMMAND ${RAYCUBE_TEST_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/cli/lidar_products_test.py
  $<TARGET_FILE:lidar_run_samples> $<TARGET_FILE:raycube>)
set_tests_properties(lidar_products PROPERTIES LABELS fast ENVIRONMENT RAYCUBE_DATA=${CMAKE_BINARY_DIR}/share/raycube)
# Files cut by another program while pictures are drawn of them.
add_test(NAME cut_files COMMAND ${RAYCUBE_TEST_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/cli/cut_files_test.py
  ${PROJECT_SOURCE_DIR}/host/plots)
set_tests_properties(cut_files PROPERTIES LABELS fast)
