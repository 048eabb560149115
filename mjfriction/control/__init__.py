"""Control of joints: what is fed forward and back, observers of friction, and how they compensate it."""
