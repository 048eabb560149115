"""The search for causes: candidates, their competition, what is refused, and the forms they end in."""
