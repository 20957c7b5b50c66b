"""Laws that MuJoCo's flight of a model must keep, tried on a test bench before it is flown."""
