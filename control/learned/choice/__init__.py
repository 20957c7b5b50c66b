"""Which prediction to plan with."""
