"""A recorded session in the place of a robot: states at their pace, commands only listened to."""
