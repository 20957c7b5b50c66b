"""References along the orbit or from files, and what following them takes."""
