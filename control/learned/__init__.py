"""The controller beyond the paper: it learns the model in flight and plans the whole manoeuvre."""
