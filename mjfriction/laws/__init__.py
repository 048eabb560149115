"""Friction laws, one per file, with one interface (:class:`~mjfriction.laws.law.Law`)."""
