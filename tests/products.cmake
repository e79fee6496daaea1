# Files users keep: against GDAL, OpenEXR and libpng readers, and real files nobody here wrote.
raycube_test(envi_header SOURCES unit/envi_header_test.cpp LIBS raycube_products LABELS fast)
raycube_test(envi_gdal SOURCES cross/envi_gdal_test.cpp LIBS raycube_products GDAL::GDAL LABELS fast)
raycube_test(pictures SOURCES cross/pictures_test.cpp LABELS fast
             LIBS raycube_products PkgConfig::OPENEXR PNG::PNG GDAL::GDAL nlohmann_json::nlohmann_json)
