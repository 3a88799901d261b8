"""Results: written while a run goes on, read back, compared and drawn."""
