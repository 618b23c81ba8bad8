"""What the robot feels: loads on its end effectors, payloads, touches."""
