"""The prediction models: where a plan leads by each, and which one to plan with."""
