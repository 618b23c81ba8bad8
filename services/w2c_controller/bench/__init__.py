"""What `w2c bench control` times: the controller's own tick, and inverse kinematics beside it."""
