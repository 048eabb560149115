"""From logs to laws: the gap between a log and a robot, and friction laws fitted to it with honest intervals."""
