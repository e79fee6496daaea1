raycube_test(layered_air SOURCES oracle/layered_air_test.cpp oracle/atmosphere_stability_test.cpp LIBS
  raycube::atmos_compiler LABELS fast)
raycube_test(profile_fill SOURCES oracle/profile_fill_test.cpp LIBS raycube::atmos_compiler LABELS fast)
