"""The solver in C: generated stage functions and the method, compiled and cached as a library."""
