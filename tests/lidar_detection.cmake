raycube_test(lidar_overlap SOURCES oracle/lidar_overlap_test.cpp LIBS raycube::lidar LABELS fast)
raycube_test(lidar_gauss_hermite SOURCES oracle/lidar_gauss_hermite_test.cpp LIBS raycube::lidar LABELS fast)
