"""Many model orders, and what persists through them."""
