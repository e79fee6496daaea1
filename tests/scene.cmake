# From simulation files to compiled scenes.
raycube_test(scene_bad_input SOURCES unit/scene_bad_input_test.cpp LIBS raycube::scene_compiler LABELS fast)
