"""The paper's four experiments with the robot, played through the running product and judged."""
