"""A model in the making: stated values and causes fitted to the rows, how sure that is, and the robot it makes."""
