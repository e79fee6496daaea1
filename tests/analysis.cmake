# What users compute from cubes: the sums that all of it rests on; the verbs themselves: cli.cmake.
raycube_test(dense_sums SOURCES unit/dense_sums_test.cpp LIBS raycube::analysis LABELS fast)
raycube_test(cut_cube SOURCES unit/cut_cube_test.cpp LIBS raycube::analysis LABELS fast)
