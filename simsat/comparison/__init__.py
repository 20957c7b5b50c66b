"""What many flights say: statistics, tables, pictures, the report."""
