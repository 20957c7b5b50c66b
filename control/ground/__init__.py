"""What everything stands on: array shapes, attitudes, a spacecraft as numbers, errors, units."""
