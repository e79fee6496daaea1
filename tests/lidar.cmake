raycube_test(lidar_plan SOURCES unit/lidar_plan_test.cpp LIBS raycube::lidar raycube_lidar_support LABELS fast)
raycube_test(lidar_truth SOURCES unit/lidar_truth_test.cpp LIBS raycube_lidar_support LABELS fast)
raycube_cli_test(lidar_render ${PROJECT_SOURCE_DIR}/scenes ${CMAKE_BINARY_DIR}/tests/park/a)
raycube_full_cli_test(lidar_render "the park's survey by one thread as well: 12 s" ${PROJECT_SOURCE_DIR}/scenes
  ${CMAKE_BINARY_DIR}/tests/park/a)
set_tests_properties(lidar_render lidar_render_full PROPERTIES FIXTURES_REQUIRED park)
