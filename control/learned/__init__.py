"""The learned controller: a model identified in flight, inside a plan of the whole manoeuvre."""
