"""A spacecraft file from figures: a mass table or an inertia tensor, and a list of wheels."""
