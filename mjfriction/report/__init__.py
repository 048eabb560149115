"""Reports of a diagnosis for people and programs; the only package that imports Rerun or a plotting library."""
