raycube_test(lidar_volume SOURCES oracle/lidar_volume_test.cpp LIBS raycube::lidar raycube_probes LABELS fast)
raycube_test(volume_input SOURCES unit/volume_input_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(lidar_volume_cross SOURCES cross/lidar_volume_cross_test.cpp LIBS raycube::lidar raycube::reference LABELS
  fast)
