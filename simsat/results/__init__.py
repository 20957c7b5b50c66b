"""What one flight is judged by, and the folder it leaves."""
