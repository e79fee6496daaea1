raycube_test(solver_closed_form SOURCES oracle/solver_closed_form_test.cpp oracle/slant_path_test.cpp LIBS
  raycube_solver_support raycube::atmos_solver LABELS fast)
raycube_test(solver_laws SOURCES oracle/solver_laws_test.cpp LIBS raycube_solver_support raycube::atmos_solver LABELS
  fast)
raycube_test(solver_stability SOURCES oracle/solver_stability_test.cpp LIBS raycube_solver_support raycube::atmos_solver
  LABELS fast)
raycube_test(solver_published SOURCES oracle/solver_published_test.cpp oracle/solver_layered_test.cpp LIBS
  raycube_solver_support raycube::atmos_solver LABELS fast)
raycube_test(solver_sweep SOURCES oracle/solver_sweep_test.cpp LIBS raycube_solver_support raycube::atmos_solver LABELS
  fast)
