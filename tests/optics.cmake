raycube_test(optics_mie SOURCES oracle/mie_test.cpp oracle/sphere_cloud_test.cpp LIBS raycube::atmos_tables LABELS fast)
raycube_test(optics_air SOURCES oracle/rayleigh_air_test.cpp oracle/air_profile_test.cpp unit/profile_csv_test.cpp
             LIBS raycube_anchor_rows raycube::atmos_tables LABELS fast)
