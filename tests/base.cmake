# Lowest layer: hashing, sizes, log, progress, and output that is whole or absent.
raycube_test(base SOURCES unit/base_test.cpp LIBS raycube_base nlohmann_json::nlohmann_json LABELS fast)
raycube_test(output_file SOURCES unit/output_file_test.cpp LIBS raycube_base LABELS fast)
