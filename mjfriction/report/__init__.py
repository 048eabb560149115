"""What a person and a program read of a diagnosis; the only room that imports Rerun or a plotting library."""
