# Light between ground and air: environment functions, the map of the environment, and the whole chain.
raycube_test(environment_function SOURCES oracle/environment_function_test.cpp LIBS raycube_atmos_tables LABELS fast)
