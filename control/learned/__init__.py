"""The controller beyond the paper: it identifies the model in flight and plans the whole slew."""
