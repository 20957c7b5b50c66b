"""How a spacecraft moves: the models that predictions are made with."""
