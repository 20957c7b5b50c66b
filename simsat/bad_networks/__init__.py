"""Networks that are wrong on purpose, and what each supervisor makes of them."""
