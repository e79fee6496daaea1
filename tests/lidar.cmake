raycube_test(lidar_plan SOURCES unit/lidar_plan_test.cpp LIBS raycube::lidar raycube_lidar_support LABELS fast)
raycube_test(lidar_truth SOURCES unit/lidar_truth_test.cpp LIBS raycube_lidar_support LABELS fast)
add_test(NAME lidar_render COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/cli/lidar_render_test.py
  $<TARGET_FILE:raycube> ${PROJECT_SOURCE_DIR}/scenes)
set_tests_properties(lidar_render PROPERTIES LABELS device SKIP_RETURN_CODE 77)
