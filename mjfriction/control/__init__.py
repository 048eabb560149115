"""Joint control: feedforward and feedback, friction observers, and friction compensation with them."""
