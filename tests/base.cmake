# Lowest layer: hashing, sizes, log, progress, and output that is whole or absent.
raycube_test(base SOURCES unit/base_test.cpp LIBS raycube_base nlohmann_json::nlohmann_json LABELS fast)
raycube_test(attitude SOURCES unit/attitude_test.cpp LIBS raycube::lidar raycube::sensors raycube::scene_compiler LABELS fast)
raycube_test(output_file SOURCES unit/output_file_test.cpp LIBS raycube_base LABELS fast)
raycube_test(house_map SOURCES unit/house_map_test.cpp LABELS fast)
target_compile_definitions(test_house_map PRIVATE RAYCUBE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
raycube_test(crash_report SOURCES unit/crash_report_test.cpp LIBS raycube_base LABELS fast)
