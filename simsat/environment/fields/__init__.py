"""The Earth's magnetic field along an orbit."""
