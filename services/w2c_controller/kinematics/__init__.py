"""The robot's tree: constants, kinematics, statics and their derivatives, compiled."""
