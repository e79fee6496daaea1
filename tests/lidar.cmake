raycube_test(lidar_plan SOURCES unit/lidar_plan_test.cpp LIBS raycube::lidar raycube_lidar_support LABELS fast)
raycube_test(lidar_truth SOURCES unit/lidar_truth_test.cpp LIBS raycube_lidar_support LABELS fast)
