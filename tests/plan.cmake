raycube_test(plan_quadrature SOURCES unit/plan_quadrature_test.cpp LIBS raycube::plan LABELS fast)
raycube_test(plan_sky SOURCES unit/plan_sky_test.cpp LIBS raycube::plan LABELS fast)
raycube_test(imported_tables SOURCES unit/imported_tables_test.cpp LIBS raycube::plan LABELS fast)
raycube_test(plan_make SOURCES unit/plan_make_test.cpp LIBS raycube::plan LABELS fast)
