"""The linearised window as a sparse quadratic program, solved by OSQP."""
