raycube_test(lidar_options SOURCES unit/lidar_options_test.cpp LIBS raycube::scene_compiler nlohmann_json::nlohmann_json
  LABELS fast)
raycube_test(lidar_bad_input SOURCES unit/lidar_bad_input_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(lidar_shots SOURCES unit/lidar_shots_test.cpp LIBS raycube::lidar raycube::sensors LABELS fast)
