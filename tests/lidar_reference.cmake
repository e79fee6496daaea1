# The LIDAR reference, alone and against the device.
raycube_test(lidar_reference_cross SOURCES cross/lidar_reference_cross_test.cpp
             LIBS raycube::run raycube_test_scenes raycube_reference raycube_lidar_support raycube::render LABELS fast
               device)
raycube_test(lidar_reference SOURCES oracle/lidar_reference_test.cpp LIBS raycube_reference raycube_lidar_support LABELS
  fast)
raycube_test(lidar_reference_air SOURCES oracle/lidar_reference_air_test.cpp LIBS raycube_reference
  raycube_lidar_support LABELS fast)
raycube_cli_test(lidar_check ${PROJECT_SOURCE_DIR}/scenes)
