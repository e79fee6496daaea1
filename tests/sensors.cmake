raycube_test(sensor_geometry SOURCES oracle/sensor_geometry_test.cpp LIBS raycube::sensors LABELS fast)
raycube_test(view_bounds SOURCES oracle/view_bounds_test.cpp LIBS raycube::sensors LABELS fast LOOPS)
raycube_test(sampler SOURCES oracle/sampler_test.cpp LIBS raycube::sensors LABELS fast)
