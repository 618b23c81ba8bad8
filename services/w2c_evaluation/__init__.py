"""The paper's experiments, run on the real processes and judged by the simulator's truth."""
