"""The controller's tick against inverse kinematics."""
