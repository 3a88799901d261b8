"""Cases with exact solutions and their references, which come from independent programs."""
