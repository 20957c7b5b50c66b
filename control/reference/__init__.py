"""Attitudes to follow over time: q_ref(t) and its rate."""
