"""The command ``bench``: what a time step costs, beside other programs for the same problems."""
