add_library(raycube_lidar_support STATIC support/lidar_kit.cpp)
target_link_libraries(raycube_lidar_support PUBLIC raycube_warnings raycube::lidar raycube::scene_bvh)
raycube_test(lidar_link SOURCES oracle/lidar_link_test.cpp LIBS raycube_lidar_support raycube::render LABELS fast)
raycube_test(lidar_surfaces SOURCES oracle/lidar_surfaces_test.cpp LIBS raycube_lidar_support raycube::render LABELS fast)
