raycube_test(atmos_physics SOURCES oracle/atmos_scatter_test.cpp oracle/bird_riordan_test.cpp LIBS raycube::atmos_tables LABELS fast)
raycube_test(atmos_interpolate SOURCES unit/atmos_interpolate_test.cpp LIBS raycube::atmos_tables LABELS fast)
raycube_test(atmos_clear_sky SOURCES oracle/clear_sky_test.cpp LIBS raycube::atmos_tables LABELS fast)
