"""The dense quadratic programs inside a solve: active set, and interior point where that fails."""
