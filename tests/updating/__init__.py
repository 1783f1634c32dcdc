"""From measured values to updated models and damage."""
