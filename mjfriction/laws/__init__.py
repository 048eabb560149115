"""Friction laws, one per file, behind one interface (:class:`~mjfriction.laws.law.Law`)."""
