"""What a diagnosis says: findings, rivals, what is left, the verdict, and the proof on motion not fitted."""
