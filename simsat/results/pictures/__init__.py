"""Pictures of a flight, drawn without a screen."""
