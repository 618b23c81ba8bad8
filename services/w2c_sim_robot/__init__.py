"""The simulated robot: Talos in MuJoCo behind the driver that a real robot would have."""
