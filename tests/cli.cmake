# The command line: its frame, and the program itself driven as users drive it.
raycube_test(cli_frame SOURCES unit/cli_frame_test.cpp LIBS raycube_cli_frame nlohmann_json::nlohmann_json LABELS fast)
