raycube_test(lidar_plan SOURCES unit/lidar_plan_test.cpp LIBS raycube::lidar raycube_lidar_support LABELS fast)
