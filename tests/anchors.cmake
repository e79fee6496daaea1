raycube_test(anchor_lowtran_thermal SOURCES oracle/anchor_lowtran_thermal_test.cpp
             LIBS raycube_anchor_support raycube::atmos_compiler LABELS fast)
raycube_test(anchor_modtran5 SOURCES oracle/anchor_modtran5_test.cpp
             LIBS raycube_anchor_support raycube::atmos_compiler LABELS fast)
raycube_full_test(anchor_modtran5 "paths from 2 km too, whose gases lie between those of 1 and 20 km")
raycube_test(anchor_modtran6 SOURCES oracle/anchor_modtran6_test.cpp
             LIBS raycube_anchor_support raycube::atmos_compiler LABELS fast)
raycube_full_test(anchor_modtran6 "soundings of three depths of water more")
raycube_test(anchor_uvspec SOURCES oracle/anchor_uvspec_test.cpp
             LIBS raycube_anchor_support raycube::atmos_compiler LABELS fast)
raycube_test(anchor_g173 SOURCES oracle/anchor_g173_test.cpp
             LIBS raycube_anchor_support raycube::atmos_compiler LABELS fast)
raycube_test(table_round_trip SOURCES oracle/table_round_trip_test.cpp
             LIBS raycube_anchor_support raycube::atmos_compiler LABELS fast)
