# Files users keep: against GDAL, OpenEXR and libpng readers, and real files nobody here wrote. They are an executable
# of their own because they call GDAL directly: other tests start without it, as the program does.
raycube_test(envi_header SOURCES unit/envi_header_test.cpp LIBS raycube_products LABELS fast)
raycube_test(radiance_unit SOURCES unit/radiance_unit_test.cpp LIBS raycube_products LABELS fast)
raycube_test(envi_gdal SOURCES cross/envi_gdal_test.cpp LIBS raycube_products GDAL::GDAL LABELS fast)
raycube_test(pictures SOURCES cross/pictures_test.cpp LABELS fast
             LIBS raycube_products PkgConfig::OPENEXR PNG::PNG GDAL::GDAL nlohmann_json::nlohmann_json)
raycube_test(lidar_time_cube SOURCES cross/lidar_time_cube_test.cpp LIBS raycube_products GDAL::GDAL LABELS fast)
